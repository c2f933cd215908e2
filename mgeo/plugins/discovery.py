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

A problem, too, is known as ``module:Class`` without one. Besides what pymoo asks of it it may have
the optional parts that `mgeo.plugins.protocol` asks for and ``docs/plugins.md`` lists.
"""

from __future__ import annotations

import inspect
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from importlib.metadata import EntryPoint, EntryPoints
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mgeo._foreign import foreign
from mgeo.benchmarks.collections import PREFIXES, build_benchmark, is_benchmark

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

PROBLEMS = "mgeo.problems"
ALGORITHMS = "mgeo.algorithms"
COMMANDS = "mgeo.commands"
PRESETS = "mgeo.presets"

_MODULE_AND_CLASS = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*")


class PluginError(ValueError):
    """A plugin that does not exist, exists twice, or does not load."""


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
        try:
            with foreign():
                loaded = self.entry_point.load()
        except Exception as error:  # whatever a foreign module raises while it is imported
            raise PluginError(f"{label} does not load: {type(error).__name__}: {error}") from error
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


def load_problem(
    name: str, options: Mapping[str, Any] | None = None, *, named: Collection[str] = ()
) -> Problem:
    """The problem of this name, built from `options`: a plugin's, or one of a collection.

    Names of collections have a prefix (`mgeo.benchmarks.collections`). A class with a method
    ``from_options(options)`` is built by it, any other one by its constructor.

    Parameters
    ----------
    named : names ``module:Class`` that a person gave: no other has its module imported, since a
        name may be from a file of somebody else.

    Raises
    ------
    PluginError
        If there is not exactly one plugin of this name, or it does not load.
    ValueError, TypeError
        If the problem refuses an option.
    """
    if not isinstance(options, Mapping | None):
        raise TypeError(f"options of {name!r} = {options!r:.80}: expected a table")
    given = dict(options or {})
    if is_benchmark(name):
        return built(name, lambda: build_benchmark(name, given))
    cls = _problem_class(name, named)
    if hasattr(cls, "from_options"):
        return built(name, (lambda: cls.from_options(given)) if given else cls)
    accepted = sorted(_constructor_keywords(cls))
    unknown = [key for key in given if key not in accepted]
    if unknown:
        from mgeo.validation.arguments import did_you_mean

        raise ValueError(
            f"unknown option {unknown[0]!r} of problem {name!r}: expected "
            f"{' or '.join(accepted) or 'no options'}{did_you_mean(unknown[0], accepted)}"
        )
    return built(name, lambda: cls(**given))


def read_files(
    name: str, options: dict[str, Any], folder: Path, *, named: Collection[str] = ()
) -> dict[str, Any]:
    """Options of a scenario file in `folder` as the problem's ``read_files`` gives them.

    Without one they are what they were, and of a name that no or more than one plugin has, which
    is refused when it is built; of ``module:Class`` they are unless `named`, see `load_problem`.

    Raises
    ------
    PluginError
        If it fails by an error of its code, or gives something else than a dict.
    ValueError, OSError
        Of ``read_files``, in its own words.
    """
    plugins = [plugin for plugin in installed_plugins() if plugin.name == name]
    cls = plugins[0].load() if len(plugins) == 1 else None
    if name in named and is_own_class(name):
        cls = _problem_class(name, named)
    reader = getattr(cls, "read_files", None)
    if reader is None:
        return options
    try:
        with foreign():
            given = reader(options, folder)
    except Exception as error:  # whatever foreign code raises
        if isinstance(error, ValueError | OSError):
            raise
        raise PluginError(
            f"read_files of problem {name!r} raised {type(error).__name__}: {error}"
        ) from error
    if not isinstance(given, dict):
        raise PluginError(f"read_files of problem {name!r} gives {given!r:.80}: expected a dict")
    return given


def built(name: str, build: Callable[[], Any]) -> Problem:
    """What `build` makes for this name, if it is a problem that can be searched.

    Raises
    ------
    PluginError
        If it is not, or `build` fails by an error of its code.
    ValueError, OSError
        Of `build`, in its own words.
    """
    from pymoo.core.problem import Problem

    try:
        with foreign():
            problem = build()
    except Exception as error:  # whatever foreign code raises
        if isinstance(error, ValueError | TypeError | OSError) and type(error) is not TypeError:
            raise  # the plugin's own words on an option; a bare TypeError is mostly Python's
        raise PluginError(
            f"problem {name!r} cannot be built: {type(error).__name__}: {error}"
        ) from error
    if not isinstance(problem, Problem):
        raise PluginError(f"problem {name!r} is built as {problem!r:.80}: expected a pymoo Problem")
    for key, least in (("n_var", 1), ("n_obj", 1), ("n_ieq_constr", 0), ("n_eq_constr", 0)):
        count = getattr(problem, key)
        if isinstance(count, bool) or not isinstance(count, Integral) or count < least:
            raise PluginError(
                f"{key} of problem {name!r} = {count!r:.80}: expected an integer >= {least}"
            )
    _check_sizes(name, problem)
    return problem


def _check_sizes(name: str, problem: Problem) -> None:
    if getattr(problem, "vars", None) is not None:
        return  # its bounds are in its variables
    import numpy as np

    for key in ("xl", "xu"):
        bound = getattr(problem, key)
        values = np.zeros(problem.n_var) if bound is None else np.asarray(bound)
        numbers = values.dtype.kind in "biuf" and bool(np.isfinite(values).all())
        if values.shape != (problem.n_var,) or not numbers:
            raise PluginError(
                f"{key} of problem {name!r} = {bound!r:.80}: expected {problem.n_var} numbers, "
                "all of them finite"
            )
    if problem.xl is not None and problem.xu is not None and (problem.xl > problem.xu).any():
        raise PluginError(f"problem {name!r}: expected xl <= xu, not {problem.xl} and {problem.xu}")


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


def _constructor_keywords(cls: type) -> set[str]:
    """What a problem's constructor takes by name: its own, and what it hands on by ``**options``.

    pymoo's own constructors hand theirs to `Problem`, which swallows any keyword, and what that
    takes is no option: names count that some constructor before it spells out.
    """
    found: set[str] = set()
    for base in cls.__mro__:
        if base.__module__ == "pymoo.core.problem":
            break
        if "__init__" not in vars(base):
            continue
        own = inspect.signature(base.__init__).parameters.values()  # type: ignore[misc]
        found |= {p.name for p in own if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
        if all(p.kind is not p.VAR_KEYWORD for p in own):
            break
    return found - {"self"}


def load_algorithm(name: str) -> Any:
    """The class of an installed algorithm, or that of ``module:Class``.

    A module is looked for in the current folder, too, after all other places.

    Raises
    ------
    PluginError
        If there is not exactly one, or it does not load.
    """
    return _class_of(name, ALGORITHMS) if ":" in name else find_plugin(name, ALGORITHMS).load()


def is_own_class(problem: str) -> bool:
    """Whether the name of a problem is ``module:Class``, and of no collection."""
    return ":" in problem and not is_benchmark(problem)


def _problem_class(name: str, named: Collection[str]) -> Any:
    if not is_own_class(name):
        return find_plugin(name).load()
    if name not in named:
        raise PluginError(
            f"problem {name!r}: its module is imported only if it is named: --problem {name}, "
            f"in Python named=[{name!r}]"
        )
    return _class_of(name, PROBLEMS)


def _class_of(name: str, group: str) -> Any:
    """What ``module:Class`` names, of a module that may be in the current folder."""
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
