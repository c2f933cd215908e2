"""The commands ``mgeo suite``."""
