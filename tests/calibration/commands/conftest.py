"""Fixtures for run folders, plans and the command line."""

from ...attitude.commands.conftest import folder, front, run, violating

__all__ = ["folder", "front", "run", "violating"]
