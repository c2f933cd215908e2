"""The command ``mgeo``."""

from mgeo.cli.app import main

__all__ = ["main"]
