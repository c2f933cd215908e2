"""Installed problems, algorithms and commands: found without an import, loaded on demand.

A plugin is a distribution with an entry point in the group ``mgeo.problems`` that names a pymoo
`Problem` class::

    [project.entry-points."mgeo.problems"]
    attitude = "mgeo_attitude:AttitudeManeuverProblem"

An algorithm, a class derived from pymoo's `Algorithm`, has one in ``mgeo.algorithms``. Commands, a
typer app, have one in ``mgeo.commands`` and appear as ``mgeo NAME ...``; a name with a dot adds
commands to those of another distribution::

    [project.entry-points."mgeo.commands"]
    "attitude.calibration" = "mgeo_calibration.commands.app:app"

Presets, ``options = {"preset": NAME}``, are listed in ``mgeo.presets`` for the completion of the
command line, which reads the names only::

    [project.entry-points."mgeo.presets"]
    "attitude.paper" = "mgeo_attitude.scenario:Scenario.paper"

Without an entry point a problem or an algorithm is named as ``module:Class``.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import metadata
from importlib.metadata import EntryPoint
from pkgutil import resolve_name
from typing import Any

from mgeo.benchmarks.collections import PREFIXES

PROBLEMS = "mgeo.problems"
ALGORITHMS = "mgeo.algorithms"
COMMANDS = "mgeo.commands"
PRESETS = "mgeo.presets"

_MODULE_AND_CLASS = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*")


class PluginError(ValueError):
    """A plugin is missing, installed twice, does not load, or raises."""


@contextmanager
def code_of_others(what: str, *own: type[Exception]) -> Iterator[None]:
    """Raise a `PluginError` that begins with `what` for any error but those of the kinds `own`."""
    try:
        yield
    except Exception as error:
        if isinstance(error, (PluginError, *own)):
            raise
        raise PluginError(f"{what} {type(error).__name__}: {error}".removesuffix(": ")) from error


@dataclass(frozen=True)
class Plugin:
    """An installed problem, algorithm or command, not imported yet.

    Attributes
    ----------
    name : str
    distribution, version : str
        The distribution that provides it; empty for ``module:Class``.
    entry_point : EntryPoint
    """

    name: str
    distribution: str
    version: str
    entry_point: EntryPoint

    @classmethod
    def of(cls, entry_point: EntryPoint) -> Plugin:
        """Return the plugin of an entry point."""
        owner = entry_point.dist
        known = ("", "") if owner is None else (owner.name, owner.version)
        return cls(entry_point.name, *known, entry_point)

    def load(self) -> Any:
        """Import the class of a problem or an algorithm, or the typer app of commands.

        Raises
        ------
        PluginError
            If the import fails, or the entry point names something else.
        """
        group = self.entry_point.group
        noun, path, expected = _KINDS[group]
        label = f"{noun} {self.name!r}"
        if self.distribution:
            label += f" of {self.distribution} {self.version}"
        with code_of_others(f"{label} does not load:"):
            loaded = self.entry_point.load()
        base: type = resolve_name(path)
        if group == COMMANDS:
            fits = isinstance(loaded, base)
        else:
            fits = isinstance(loaded, type) and issubclass(loaded, base)
        if not fits:
            raise PluginError(
                f"{label}: expected {expected.format(path.replace(':', '.'))} at "
                f"{self.entry_point.value!r}, found {loaded!r}"
            )
        return loaded


def installed_plugins(group: str = PROBLEMS) -> list[Plugin]:
    """Return the plugins of a group, sorted by name.

    Raises
    ------
    PluginError
        If two distributions claim the same name.
    """
    found: dict[str, Plugin] = {}
    for plugin in map(Plugin.of, metadata.entry_points(group=group)):
        other = found.setdefault(plugin.name, plugin)
        if other != plugin:
            owners = " and ".join(f"{p.distribution} {p.version}" for p in (other, plugin))
            raise PluginError(
                f"the {_KINDS[group][0]} name {plugin.name!r} is claimed by {owners}: uninstall "
                "one of them"
            )
    return [found[name] for name in sorted(found)]


def find_plugin(name: str, group: str = PROBLEMS) -> Plugin:
    """Return the plugin of a name, not imported.

    Raises
    ------
    PluginError
        If there is none; the message lists what is installed.
    """
    plugins = {plugin.name: plugin for plugin in installed_plugins(group)}
    if name in plugins:
        return plugins[name]
    noun = _KINDS[group][0]
    if not plugins:
        raise PluginError(
            f"no {noun} is called {name!r}: no {noun} is installed (in a checkout: pip install "
            "./problems/attitude)"
        )
    from mgeo.validation.arguments import did_you_mean  # imports NumPy

    tests = f"; test problems have names as {', '.join(PREFIXES.values())}"
    raise PluginError(
        f"no {noun} is called {name!r}: installed are {', '.join(plugins)}"
        f"{tests if group == PROBLEMS else ''}; or module:Class{did_you_mean(name, plugins)}"
    )


def plugin_versions(modules: Iterable[str]) -> dict[str, str]:
    """Return distributions and versions of the plugins that provide these modules."""
    tops = {module.partition(".")[0] for module in modules}
    return {
        plugin.distribution: plugin.version
        for plugin in (*installed_plugins(), *installed_plugins(ALGORITHMS))
        if plugin.entry_point.module.partition(".")[0] in tops
    }


def preset_names(name: str) -> list[str]:
    """Return the presets that plugins declare for a problem, sorted."""
    prefix = f"{name}."
    names = {entry.name for entry in metadata.entry_points(group=PRESETS)}
    return sorted(full.removeprefix(prefix) for full in names if full.startswith(prefix))


def load_algorithm(name: str) -> Any:
    """Return the class of an installed algorithm, or of ``module:Class``.

    Raises
    ------
    PluginError
        If there is none, or it does not load.
    """
    return class_of(name, ALGORITHMS) if ":" in name else find_plugin(name, ALGORITHMS).load()


def class_of(name: str, group: str) -> Any:
    """Import ``module:Class``; the module may be in the current folder.

    Raises
    ------
    PluginError
        If the name is not of this form, or the module or class does not load.
    """
    if not _MODULE_AND_CLASS.fullmatch(name):
        raise PluginError(f"{_KINDS[group][0]} {name!r}: expected module:Class")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    return Plugin.of(EntryPoint(name, name, group)).load()


#: Noun, base class, and description of what an entry point names, by group.
_KINDS: Mapping[str, tuple[str, str, str]] = {
    PROBLEMS: ("problem", "pymoo.core.problem:Problem", "a class derived from {}"),
    ALGORITHMS: ("algorithm", "pymoo.core.algorithm:Algorithm", "a class derived from {}"),
    COMMANDS: ("command", "typer:Typer", "an instance of {}"),
}
