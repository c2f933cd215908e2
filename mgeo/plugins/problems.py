"""A problem by its name: an installed one, ``module:Class``, or one of a collection."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mgeo.benchmarks.collections import build_benchmark, is_benchmark
from mgeo.plugins.discovery import (
    PROBLEMS,
    PluginError,
    class_of,
    code_of_others,
    find_plugin,
    installed_plugins,
)
from mgeo.plugins.protocol import ProblemMixin, is_own
from mgeo.store.reading import read_json, read_text
from mgeo.validation.constructors import refuse_unknown_options
from mgeo.validation.entries import errors_of

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


def load_problem(
    name: str, options: Mapping[str, Any] | None = None, *, named: Collection[str] = ()
) -> Problem:
    """Build the problem of a name.

    Parameters
    ----------
    name : str
        Of an installed problem, of a test problem with a prefix (`mgeo.benchmarks.collections`), or
        ``module:Class``.
    options : mapping, optional
        Handed to the class method ``from_options(options)``, or as keywords to the constructor.
    named : collection of str
        Names ``module:Class`` that the user gave. No other module is imported, as a name may come
        from a file of somebody else.

    Raises
    ------
    PluginError
        If there is no such problem, it does not load, or its code raises.
    ValueError, TypeError
        If the problem refuses an option.
    """
    if not isinstance(options, Mapping | None):
        raise TypeError(f"options of {name!r} = {options!r:.80}: expected a table")
    given = dict(options or {})
    if is_benchmark(name):
        return _built(name, lambda: build_benchmark(name, given))
    cls = _problem_class(name, named)
    if is_own(cls, ProblemMixin.from_options):
        return _built(name, (lambda: cls.from_options(given)) if given else cls)
    refuse_unknown_options(name, cls, given)
    return _built(name, lambda: cls(**given))


def read_scenario(
    problem: str,
    scenario: str | None,
    folder: Path | str = "",
    after: Path | None = None,
    *,
    named: Collection[str] = (),
) -> dict[str, Any]:
    """Return the options of a problem from a TOML file or a preset.

    Parameters
    ----------
    problem : str
        Name of the problem. Its method ``read_files`` reads the files that the scenario names.
    scenario : str or None
        Path of a TOML file, relative to `folder`, or the name of a preset.
    after : Path, optional
        JSON file of an earlier result. Its contents become the option ``after``.
    named : collection of str
        As for `load_problem`.

    Raises
    ------
    OSError
        If there is no such file.
    ValueError
        If a file is not TOML or JSON, or the problem refuses a file that the scenario names.
    """
    more = {} if after is None else {"after": read_json(after)}
    if scenario is None:
        return more
    path = Path(scenario)
    if path.suffix != ".toml" and len(path.parts) == 1:
        return {"preset": scenario, **more}
    path = Path(folder) / path
    if not path.is_file():
        raise FileNotFoundError(f"there is no scenario file {path}")
    text = read_text(path)
    with errors_of(path):
        return _read_files(problem, tomllib.loads(text) | more, path.parent, named)


def _read_files(
    name: str, options: dict[str, Any], folder: Path, named: Collection[str]
) -> dict[str, Any]:
    """Let the problem read the files that a scenario names; `load_problem` refuses bad names."""
    if is_own_class(name):
        cls = _problem_class(name, named) if name in named else None
    else:
        plugins = {plugin.name: plugin for plugin in installed_plugins()}
        cls = plugins[name].load() if name in plugins else None
    reader = getattr(cls, "read_files", None)
    if reader is None:
        return options
    with code_of_others(f"read_files of problem {name!r} raised", ValueError, OSError):
        read: dict[str, Any] = reader(options, folder)
    return read


def is_own_class(problem: str) -> bool:
    """Return whether the name of a problem is ``module:Class``, and of no collection."""
    return ":" in problem and not is_benchmark(problem)


def _built(name: str, build: Callable[[], Problem]) -> Problem:
    # a ValueError is the plugin's own message on an option; a TypeError is mostly Python's
    with code_of_others(f"problem {name!r} cannot be built:", ValueError, OSError):
        return build()


def _problem_class(name: str, named: Collection[str]) -> Any:
    if not is_own_class(name):
        return find_plugin(name).load()
    if name not in named:
        raise PluginError(
            f"problem {name!r}: its module is imported only if it is named: --problem {name}, "
            f"in Python named=[{name!r}]"
        )
    return class_of(name, PROBLEMS)
