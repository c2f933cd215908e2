"""All kinds of cases, registered by importing them."""

from . import arguments, places, plugins, run_folders, texts
from .harness import KINDS

__all__ = ["KINDS", "arguments", "places", "plugins", "run_folders", "texts"]
