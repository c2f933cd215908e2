"""A problem by its name: a plugin's, a class of one's own, or one of a collection."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from numbers import Integral
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

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


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
    with code_of_others(f"read_files of problem {name!r} raised", ValueError, OSError):
        given = reader(options, folder)
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

    # the plugin's own words on an option; a TypeError is mostly Python's
    with code_of_others(f"problem {name!r} cannot be built:", ValueError, OSError):
        problem = build()
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
    return class_of(name, PROBLEMS)


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
