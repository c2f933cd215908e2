"""Discovery of installed problems, algorithms and commands through entry points.

Listing plugins reads metadata only; a plugin is imported when it is used. A problem, a class
derived from pymoo's `Problem`, is declared in the entry-point group ``mgeo.problems``::

    [project.entry-points."mgeo.problems"]
    attitude = "mgeo_attitude:AttitudeManeuverProblem"

An algorithm, a class derived from pymoo's `Algorithm`, is declared in ``mgeo.algorithms``. A typer
app in ``mgeo.commands`` adds the commands ``mgeo NAME ...``; a name with a dot extends the commands
of another distribution::

    [project.entry-points."mgeo.commands"]
    "attitude.calibration" = "mgeo_calibration.commands.app:app"

Presets, used as ``options = {"preset": NAME}``, are declared in ``mgeo.presets``. Shell completion
reads their names without importing them::

    [project.entry-points."mgeo.presets"]
    "attitude.paper" = "mgeo_attitude.scenario:Scenario.paper"

A problem or an algorithm without an entry point is specified as ``module:Class``.
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

PROBLEMS = "mgeo.problems"
ALGORITHMS = "mgeo.algorithms"
COMMANDS = "mgeo.commands"
PRESETS = "mgeo.presets"

_MODULE_AND_CLASS = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*")


class PluginError(ValueError):
    """Error raised if a plugin is missing, ambiguous or not importable, or raises an exception."""


@contextmanager
def convert_plugin_errors(prefix: str, *allowed: type[Exception]) -> Iterator[None]:
    """Context manager that reraises exceptions as `PluginError` with a message prefix.

    Parameters
    ----------
    prefix : str
        Beginning of the message; the type and the text of the original exception follow.
    *allowed : exception classes
        Exceptions that are not converted.
    """
    try:
        yield
    except Exception as error:
        if isinstance(error, (PluginError, *allowed)):
            raise
        raise PluginError(f"{prefix} {type(error).__name__}: {error}".removesuffix(": ")) from error


@dataclass(frozen=True)
class Plugin:
    """Installed problem, algorithm or command that is imported only when needed.

    Attributes
    ----------
    name : str
        Name of the entry point.
    distribution, version : str
        Name and version of the distribution that provides the plugin; empty for ``module:Class``.
    entry_point : EntryPoint
    """

    name: str
    distribution: str
    version: str
    entry_point: EntryPoint

    @classmethod
    def from_entry_point(cls, entry_point: EntryPoint) -> Plugin:
        """Create a plugin from its entry point."""
        distribution = entry_point.dist
        provider = ("", "") if distribution is None else (distribution.name, distribution.version)
        return cls(entry_point.name, *provider, entry_point)

    def load(self) -> Any:
        """Import the plugin, check its type, and return it.

        Returns
        -------
        type or typer.Typer
            Class of the problem or algorithm, or the app of commands.

        Raises
        ------
        PluginError
            If the import fails, or if the imported object has the wrong type.
        """
        group = self.entry_point.group
        noun, path, expected = _KINDS[group]
        label = f"{noun} {self.name!r}"
        if self.distribution:
            label += f" of {self.distribution} {self.version}"
        with convert_plugin_errors(f"{label} cannot be imported:"):
            loaded = self.entry_point.load()
        base: type = resolve_name(path)
        if group == COMMANDS:
            is_expected = isinstance(loaded, base)
        else:
            is_expected = isinstance(loaded, type) and issubclass(loaded, base)
        if not is_expected:
            raise PluginError(
                f"{label}: expected {expected.format(path.replace(':', '.'))} at "
                f"{self.entry_point.value!r}, found {loaded!r}"
            )
        return loaded


def list_plugins(group: str = PROBLEMS) -> list[Plugin]:
    """Return the installed plugins of a group, sorted by name, without importing them.

    Parameters
    ----------
    group : str
        Entry-point group: `PROBLEMS`, `ALGORITHMS` or `COMMANDS`.

    Raises
    ------
    PluginError
        If two distributions declare the same name.
    """
    plugins: dict[str, Plugin] = {}
    for plugin in map(Plugin.from_entry_point, metadata.entry_points(group=group)):
        other = plugins.setdefault(plugin.name, plugin)
        if other != plugin:
            owners = " and ".join(f"{p.distribution} {p.version}" for p in (other, plugin))
            raise PluginError(
                f"the {_KINDS[group][0]} name {plugin.name!r} is declared by {owners}: uninstall "
                "one of them"
            )
    return [plugins[name] for name in sorted(plugins)]


def find_plugin(name: str, group: str = PROBLEMS) -> Plugin:
    """Return the installed plugin with a given name, without importing it.

    Parameters
    ----------
    name : str
        Name of the entry point.
    group : str
        Entry-point group: `PROBLEMS`, `ALGORITHMS` or `COMMANDS`.

    Raises
    ------
    PluginError
        If no plugin of the group has this name. The message lists the installed plugins.
    """
    plugins = {plugin.name: plugin for plugin in list_plugins(group)}
    if name in plugins:
        return plugins[name]
    noun = _KINDS[group][0]
    if not plugins:
        raise PluginError(
            f"no {noun} is named {name!r}: no {noun} is installed (in a checkout: pip install "
            "./problems/attitude)"
        )
    from mgeo.validation.arguments import format_suggestion  # Deferred: imports NumPy.

    tests = ", a test problem such as pymoo:zdt1" if group == PROBLEMS else ""
    raise PluginError(
        f"there is no {noun} {name!r}: expected {', '.join(plugins)}{tests}, or module:Class"
        f"{format_suggestion(name, plugins)}"
    )


def list_plugin_versions(modules: Iterable[str]) -> dict[str, str]:
    """Return the versions of the distributions that provide the given modules.

    Parameters
    ----------
    modules : iterable of str
        Dotted module names, for example those of the classes of a run.

    Returns
    -------
    dict of str to str
        Version by name of the distribution. A distribution is listed if one of its problems or
        algorithms is in the top-level package of one of the modules.
    """
    packages = {module.partition(".")[0] for module in modules}
    return {
        plugin.distribution: plugin.version
        for plugin in (*list_plugins(), *list_plugins(ALGORITHMS))
        if plugin.entry_point.module.partition(".")[0] in packages
    }


def list_preset_names(name: str) -> list[str]:
    """Return the sorted names of a problem's presets, without importing them."""
    prefix = f"{name}."
    names = {entry.name for entry in metadata.entry_points(group=PRESETS)}
    return sorted(full.removeprefix(prefix) for full in names if full.startswith(prefix))


def load_algorithm(name: str) -> Any:
    """Import an algorithm by name and return its class.

    Parameters
    ----------
    name : str
        Name of an installed algorithm, or ``module:Class``.

    Raises
    ------
    PluginError
        If there is no such algorithm, or if its import fails.
    """
    return import_class(name, ALGORITHMS) if ":" in name else find_plugin(name, ALGORITHMS).load()


def import_class(name: str, group: str) -> Any:
    """Import a problem or algorithm class specified as ``module:Class``, and return it.

    The module may be in the current folder, which is appended to ``sys.path``.

    Parameters
    ----------
    name : str
        Module and class, separated by a colon.
    group : str
        `PROBLEMS` or `ALGORITHMS`, for the expected base class.

    Raises
    ------
    PluginError
        If the name has another form, the import fails, or the class has another base class.
    """
    if not _MODULE_AND_CLASS.fullmatch(name):
        raise PluginError(f"{_KINDS[group][0]} {name!r}: expected module:Class")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    return Plugin.from_entry_point(EntryPoint(name, name, group)).load()


#: Noun for messages, expected type, and description of the expected object, by group.
_KINDS: Mapping[str, tuple[str, str, str]] = {
    PROBLEMS: ("problem", "pymoo.core.problem:Problem", "a class derived from {}"),
    ALGORITHMS: ("algorithm", "pymoo.core.algorithm:Algorithm", "a class derived from {}"),
    COMMANDS: ("command", "typer:Typer", "an instance of {}"),
}
