"""The command ``mgeo-attitude``: from a front to a plan that is flown."""

from .app import main

__all__ = ["main"]
