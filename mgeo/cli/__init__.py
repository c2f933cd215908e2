"""Command line of mgeo."""
