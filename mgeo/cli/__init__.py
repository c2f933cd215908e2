"""The command ``mgeo``."""
