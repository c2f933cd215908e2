"""Algorithms of others: installed under a name, or ``module:Class``."""

from __future__ import annotations

import os
import re
import sys
from importlib.metadata import EntryPoint
from typing import Any

from mgeo.plugins.discovery import ALGORITHMS, Plugin, PluginError, find_plugin

_MODULE_AND_CLASS = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*")


def load_algorithm(name: str) -> Any:
    """The class of an installed algorithm, or that of ``module:Class``.

    A module is looked for in the current folder, too, after all other places.

    Raises
    ------
    PluginError
        If there is not exactly one, or it does not load.
    """
    if ":" not in name:
        return find_plugin(name, ALGORITHMS).load()
    if not _MODULE_AND_CLASS.fullmatch(name):
        raise PluginError(f"algorithm {name!r}: expected module:Class")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    return Plugin.of(EntryPoint(name, name, ALGORITHMS)).load()
