"""Construction of a problem from its name and options, and reading of scenario files."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mgeo.benchmarks.collections import build_benchmark, is_benchmark
from mgeo.plugins.discovery import (
    PROBLEMS,
    PluginError,
    convert_plugin_errors,
    find_plugin,
    import_class,
    list_plugins,
    list_preset_names,
)
from mgeo.plugins.protocol import ProblemMixin, has_override
from mgeo.store.readers import read_json, read_text
from mgeo.validation.constructors import reject_unknown_options
from mgeo.validation.entries import convert_file_errors

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


def load_problem(
    name: str, options: Mapping[str, Any] | None = None, *, trusted_classes: Collection[str] = ()
) -> Problem:
    """Build a pymoo problem from its name and options.

    A class ``module:Class`` is imported only if `trusted_classes` contains its name.

    Parameters
    ----------
    name : str
        Name of an installed problem, name of a test problem with a prefix (see
        `mgeo.benchmarks.collections`), or ``module:Class``.
    options : mapping, optional
        Options of the problem. They are passed to the class method ``from_options(options)`` if the
        class defines one, otherwise to the constructor as keywords.
    trusted_classes : collection of str
        Names ``module:Class`` that the user specified. Other modules are not imported, because
        `name` may come from an untrusted file.

    Raises
    ------
    PluginError
        If there is no such problem, its import fails, or its code raises.
    ValueError, TypeError
        If an option is unknown or invalid.
    """
    if not isinstance(options, Mapping | None):
        raise TypeError(f"options of {name!r} = {options!r:.80}: expected a table")
    arguments = dict(options or {})
    if is_benchmark(name):
        return _build_problem(name, lambda: build_benchmark(name, arguments))
    cls = _load_class(name, trusted_classes)
    if has_override(cls, ProblemMixin.from_options):
        return _build_problem(name, (lambda: cls.from_options(arguments)) if arguments else cls)
    reject_unknown_options(name, cls, arguments)
    return _build_problem(name, lambda: cls(**arguments))


def read_scenario(
    problem: str,
    scenario: str | None,
    folder: Path | str = "",
    after: Path | None = None,
    *,
    trusted_classes: Collection[str] = (),
) -> dict[str, Any]:
    """Read the options of a problem from a TOML file, or select a preset by name.

    Parameters
    ----------
    problem : str
        Name of the problem. The class method ``read_files`` of the problem, if defined, reads the
        files that the scenario refers to.
    scenario : str or None
        Path of a TOML file, relative to `folder`, or the name of a preset. None for no options.
    folder : path
        Folder of relative scenario paths.
    after : Path, optional
        JSON file with an earlier result, whose content becomes the option ``after``.
    trusted_classes : collection of str
        Names ``module:Class`` that the user specified, see `load_problem`.

    Returns
    -------
    dict of str to value
        Options for `load_problem`.

    Raises
    ------
    OSError
        If a file does not exist.
    ValueError
        If a file is not valid TOML or JSON, or the problem rejects a file of the scenario.
    """
    result_options = {} if after is None else {"after": read_json(after)}
    if scenario is None:
        return result_options
    path = Path(scenario)
    if not path.suffix and len(path.parts) == 1:
        return {"preset": scenario, **result_options}
    path = Path(folder) / path
    if not path.is_file():
        presets = ", ".join(list_preset_names(problem))
        raise FileNotFoundError(
            f"there is no scenario file {path}{presets and f'; presets of {problem}: {presets}'}"
        )
    text = read_text(path)
    with convert_file_errors(path):
        return _read_files(
            problem, tomllib.loads(text) | result_options, path.parent, trusted_classes
        )


def _read_files(
    name: str, options: dict[str, Any], folder: Path, trusted_classes: Collection[str]
) -> dict[str, Any]:
    # Names that are unknown here pass unchanged: `load_problem` reports them.
    if is_class_path(name):
        cls = _load_class(name, trusted_classes) if name in trusted_classes else None
    else:
        plugins = {plugin.name: plugin for plugin in list_plugins()}
        cls = plugins[name].load() if name in plugins else None
    reader = getattr(cls, "read_files", None)
    if reader is None:
        return options
    with convert_plugin_errors(f"read_files of problem {name!r} raised", ValueError, OSError):
        expanded_options: dict[str, Any] = reader(options, folder)
    return expanded_options


def is_class_path(problem: str) -> bool:
    """Return True if a problem name has the form ``module:Class`` and is not a test problem.

    Names of test problems also contain a colon, for example ``pymoo:zdt1``.
    """
    return ":" in problem and not is_benchmark(problem)


def _build_problem(name: str, builder: Callable[[], Problem]) -> Problem:
    # A ValueError passes unchanged, because it is the plugin's message about an option. A TypeError
    # usually comes from Python and does not identify the problem.
    with convert_plugin_errors(f"problem {name!r} cannot be built:", ValueError, OSError):
        return builder()


def _load_class(name: str, trusted_classes: Collection[str]) -> Any:
    if not is_class_path(name):
        return find_plugin(name).load()
    if name not in trusted_classes:
        raise PluginError(
            f"problem {name!r}: its module is imported only if you specify it: --problem {name}, "
            f"in Python trusted_classes=[{name!r}]"
        )
    return import_class(name, PROBLEMS)


def format_problem_options(names: Iterable[str]) -> str:
    """Return the ``--problem`` options by which a user permits the import of problem classes.

    Commands import a class ``module:Class`` only if the user specifies it. The result is an empty
    string if no name has this form.
    """
    return "".join(f" --problem {name}" for name in dict.fromkeys(names) if is_class_path(name))
