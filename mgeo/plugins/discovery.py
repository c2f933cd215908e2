"""Problems, algorithms and commands of others: found without importing them, loaded on demand.

A plugin is a distribution with an entry point in the group ``mgeo.problems`` that names a pymoo
`Problem` class::

    [project.entry-points."mgeo.problems"]
    attitude = "mgeo_attitude:AttitudeManeuverProblem"

It may name presets, ``options = {"preset": NAME}``, for completion on the command line. They are
read without importing anything, from the name alone, and are therefore entry points, too::

    [project.entry-points."mgeo.presets"]
    "attitude.paper" = "mgeo_attitude.scenario:Scenario.paper"

Its commands, a typer app, appear as ``mgeo NAME ...``::

    [project.entry-points."mgeo.commands"]
    attitude = "mgeo_attitude.commands.app:app"

Another distribution adds its own to them by a name after a dot, and replaces those that only say
where they are to be had::

    [project.entry-points."mgeo.commands"]
    "attitude.calibration" = "mgeo_calibration.commands.app:app"

An algorithm, a class derived from pymoo's `Algorithm`, is known by its name in studies and on the
command line, as ``module:Class`` is without an entry::

    [project.entry-points."mgeo.algorithms"]
    mgeo-cauchy = "cauchy:MGEOCauchy"

A problem, too, is known as ``module:Class`` without one, see `mgeo.plugins.problems`. Besides what
pymoo asks of it it may have the optional parts that `mgeo.plugins.protocol` asks for and
``docs/plugins.md`` lists.
"""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module, metadata
from importlib.metadata import EntryPoint, EntryPoints
from typing import Any

from mgeo._foreign import foreign
from mgeo.benchmarks.collections import PREFIXES

PROBLEMS = "mgeo.problems"
ALGORITHMS = "mgeo.algorithms"
COMMANDS = "mgeo.commands"
PRESETS = "mgeo.presets"

_MODULE_AND_CLASS = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*")


class PluginError(ValueError):
    """A plugin that does not exist, exists twice, or does not load."""


@contextmanager
def code_of_others(what: str, *own: type[Exception]) -> Iterator[None]:
    """For calls of it: whatever it raises is a `PluginError` that begins with `what` was asked.

    Errors of the kinds `own` are in its own words, and stay.
    """
    try:
        with foreign():
            yield
    except Exception as error:  # it may raise anything
        if isinstance(error, (PluginError, *own)):
            raise
        told = f"{what} {type(error).__name__}: {error}".removesuffix(": ")
        raise PluginError(told) from error


@dataclass(frozen=True)
class Plugin:
    """An installed problem, algorithm, or commands, not imported yet."""

    name: str
    distribution: str
    version: str
    entry_point: EntryPoint

    @classmethod
    def of(cls, entry_point: EntryPoint) -> Plugin:
        """What an entry point names; of one built by hand no distribution is known."""
        owner = entry_point.dist
        known = ("", "") if owner is None else (owner.name, owner.version)
        return cls(entry_point.name, *known, entry_point)

    def load(self) -> Any:
        """The class of a problem or an algorithm, or the typer app of commands.

        Raises
        ------
        PluginError
            If the module cannot be imported or the entry point is none of these.
        """
        group = self.entry_point.group
        noun, is_valid, expected = _KINDS[group]
        label = f"{noun} {self.name!r}"
        if self.distribution:
            label += f" of {self.distribution} {self.version}"
        with code_of_others(f"{label} does not load:"):
            loaded = self.entry_point.load()
        if not is_valid(loaded):
            raise PluginError(
                f"{label}: expected {expected} at {self.entry_point.value!r}, found {loaded!r}"
            )
        return loaded


def entry_points(group: str) -> EntryPoints:
    """Those of a group, in all distributions; read again only if a folder of the path changes."""
    found: EntryPoints = _all_entry_points(tuple(map(_changed, sys.path))).select(group=group)
    return found


def _changed(folder: str) -> tuple[str, int]:
    try:
        return folder, os.stat(folder or ".").st_mtime_ns
    except OSError:
        return folder, 0


@lru_cache(maxsize=1)
def _all_entry_points(path: tuple[tuple[str, int], ...]) -> Any:
    return metadata.entry_points()


def installed_plugins(group: str = PROBLEMS) -> list[Plugin]:
    """Every entry point of the group, sorted by name; a name may occur more than once."""
    found = map(Plugin.of, entry_points(group=group))
    return sorted(found, key=lambda plugin: (plugin.name, plugin.distribution))


def find_plugin(name: str, group: str = PROBLEMS) -> Plugin:
    """The plugin of this name, not imported.

    Raises
    ------
    PluginError
        If there is none (the message lists what is installed) or more than one (it names them).
    """
    noun = _KINDS[group][0]
    plugins = installed_plugins(group)
    matches = [plugin for plugin in plugins if plugin.name == name]
    if not matches:
        raise PluginError(f"no {noun} is called {name!r}{_alternatives(name, noun, plugins)}")
    if len(matches) > 1:
        owners = " and ".join(f"{match.distribution} {match.version}" for match in matches)
        raise PluginError(f"the {noun} name {name!r} is claimed by {owners}: uninstall all but one")
    return matches[0]


def plugin_versions(modules: Iterable[str]) -> dict[str, str]:
    """Distributions and versions of the plugins that these modules belong to."""
    tops = {module.partition(".")[0] for module in modules}
    return {
        plugin.distribution: plugin.version
        for plugin in (*installed_plugins(), *installed_plugins(ALGORITHMS))
        if plugin.entry_point.module.partition(".")[0] in tops
    }


def preset_names(name: str) -> list[str]:
    """Presets that plugins declare for the problem of this name, sorted."""
    prefix = f"{name}."
    names = {entry.name for entry in entry_points(group=PRESETS)}
    return sorted(full.removeprefix(prefix) for full in names if full.startswith(prefix))


def _is_problem_class(loaded: object) -> bool:
    from pymoo.core.problem import Problem

    return isinstance(loaded, type) and issubclass(loaded, Problem)


def _is_algorithm_class(loaded: object) -> bool:
    from pymoo.core.algorithm import Algorithm

    return isinstance(loaded, type) and issubclass(loaded, Algorithm)


def _is_app(loaded: object) -> bool:
    import typer

    return isinstance(loaded, typer.Typer)


_KINDS: Mapping[str, tuple[str, Callable[[object], bool], str]] = {
    PROBLEMS: ("problem", _is_problem_class, "a class derived from pymoo.core.problem.Problem"),
    ALGORITHMS: (
        "algorithm",
        _is_algorithm_class,
        "a class derived from pymoo.core.algorithm.Algorithm",
    ),
    COMMANDS: ("command", _is_app, "a typer app"),
}


def _alternatives(name: str, noun: str, plugins: Iterable[Plugin]) -> str:
    names = sorted({plugin.name for plugin in plugins})
    if not names:
        return f": no {noun} is installed (in a checkout: pip install ./problems/attitude)"
    from mgeo.validation.arguments import did_you_mean

    others = f"{_prefixes(PROBLEMS)}; or module:Class" if noun == "problem" else ""
    return f": installed are {', '.join(names)}{others}{did_you_mean(name, names)}"


def load_algorithm(name: str) -> Any:
    """The class of an installed algorithm, or that of ``module:Class``.

    A module is looked for in the current folder, too, after all other places.

    Raises
    ------
    PluginError
        If there is not exactly one, or it does not load.
    """
    return class_of(name, ALGORITHMS) if ":" in name else find_plugin(name, ALGORITHMS).load()


def class_of(name: str, group: str) -> Any:
    """What ``module:Class`` names, of a module that may be in the current folder.

    Raises
    ------
    PluginError
        If the name is not of this form, or the module or class does not load.
    """
    noun = _KINDS[group][0]
    if not _MODULE_AND_CLASS.fullmatch(name):
        raise PluginError(f"{noun} {name!r}: expected module:Class{_prefixes(group)}")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    try:
        return Plugin.of(EntryPoint(name, name, group)).load()
    except PluginError as error:
        raise PluginError(f"{error}{_prefixes(group)}") from error


def _prefixes(group: str) -> str:
    """What a name with a colon may also be."""
    known = ", ".join(PREFIXES.values())
    return f"; test problems have names as {known}" if group == PROBLEMS else ""


def __getattr__(name: str) -> Any:
    if name not in ("load_problem", "read_files", "built", "is_own_class"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    warnings.warn(
        f"mgeo.plugins.discovery.{name} is mgeo.plugins.problems.{name} now; gone in 0.4",
        DeprecationWarning,
        stacklevel=2,
    )
    return getattr(import_module("mgeo.plugins.problems"), name)
