"""Run folders, plans and the command, as for plans."""

from ...attitude.commands.conftest import folder, front, run, violating

__all__ = ["folder", "front", "run", "violating"]
