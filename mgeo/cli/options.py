"""Flags that several commands have, and those that are parameters of an algorithm."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Annotated, Any

import typer

from mgeo.cli import completion
from mgeo.cli.errors import remember_debug
from mgeo.cli.output import reserve

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Tell all parameters of the algorithm.")
]
Json = Annotated[
    bool,
    typer.Option(
        "--json",
        callback=reserve,
        help="Print the result as one JSON document, for scripts; on stdout there is nothing else.",
    ),
]
Debug = Annotated[
    bool,
    typer.Option("--debug", callback=remember_debug, help="Show the traceback of an error."),
]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run",
        help="Run and write nothing; tell the size, the files, and about how long it would take.",
    ),
]

Problem = Annotated[
    str | None,
    typer.Option(
        metavar="MODULE:CLASS",
        help="The problem, where it is none by name: no file has a module imported.",
    ),
]
Sigma = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER[,NUMBER...]",
        help="Standard deviation of steps, one for all variables or one for each.",
    ),
]
Tau = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER|NAME",
        help="Selection pressure; a name lets it follow the search.",
        autocompletion=completion.among_those_of("mgeo.algorithms.selection:RULES"),
    ),
]
Walkers = Annotated[int | None, typer.Option("--walkers", "--runs", help="Number of walkers.")]
Perturbation = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="What sigma is a multiple of.",
        autocompletion=completion.among_those_of("mgeo.algorithms.steps:SCALES"),
    ),
]
Population = Annotated[int | None, typer.Option(help="Population size, of pymoo's algorithms.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Any other parameter of the algorithm, such as bits=12 or restart=archive; may be "
        "given several times.",
    ),
]

#: Parameters that have a flag of their own; any other is set by --set.
FLAGS: Mapping[str, str] = {
    "sigma": "--sigma",
    "tau": "--tau",
    "n_walkers": "--walkers",
    "perturbation": "--perturbation",
    "population": "--population",
}


def parse_parameters(
    algorithm: str, flags: Mapping[str, Any], settings: Sequence[str]
) -> dict[str, Any]:
    """The parameters of an algorithm from its flags, None where not given, and NAME=VALUE texts.

    Raises
    ------
    ValueError
        If a text is none of that form, names a parameter twice or one with a flag of its own, or
        the algorithm has no such parameter: naming the flag, and those it takes.
    """
    from mgeo.algorithms.constructors import IN_PAPERS
    from mgeo.runs.algorithms import complete_parameters, with_parameter
    from mgeo.validation.arguments import decimal_point

    parameters = {key: value for key, value in flags.items() if value is not None}
    if "sigma" in parameters:
        parameters["sigma"] = parse_numbers("--sigma", parameters["sigma"])
    if "tau" in parameters:
        if hint := decimal_point(parameters["tau"]):
            raise ValueError(f"--tau = {parameters['tau']!r}: expected a number or a name{hint}")
        parameters["tau"] = _value(parameters["tau"])
    parameters |= parse_settings(settings)
    known = complete_parameters(algorithm, {})
    for key in parameters:
        if key in IN_PAPERS and key not in known:
            raise ValueError(f"--set {key}: n_i of the papers is {flag(IN_PAPERS[key])}")
        if key not in known:
            taken = ", ".join(map(flag, known))
            others = ", ".join(with_parameter(key))
            raise ValueError(
                f"{flag(key)} does not apply to {algorithm}, which takes {taken}"
                f"{f': it is of {others}' if others else ''}"
            )
    return parameters


def parse_numbers(name: str, text: str) -> float | list[float]:
    """One number, or a list where there are commas.

    Raises
    ------
    ValueError
        If an entry is no number.
    """
    from mgeo.validation.arguments import decimal_point

    if re.fullmatch(r"0,\d+", text):  # no list: no sigma is 0
        raise ValueError(f"{name} = {text!r}: expected a number{decimal_point(text)}")
    try:
        numbers = [float(entry) for entry in text.split(",")]
    except ValueError as error:
        raise ValueError(
            f"{name} = {text!r}: expected a number or numbers separated by commas"
        ) from error
    return numbers[0] if len(numbers) == 1 else numbers


def parse_settings(settings: Sequence[str]) -> dict[str, Any]:
    """The parameters of NAME=VALUE texts; raises as `parse_parameters`."""
    parameters: dict[str, Any] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not (name and equals and value):
            raise ValueError(f"--set {setting}: expected NAME=VALUE")
        if name in FLAGS:
            raise ValueError(f"--set {setting}: expected {FLAGS[name]} for this parameter")
        if name in parameters:
            raise ValueError(f"--set {setting}: {name} is given twice")
        parameters[name] = _value(value)
    return parameters


def _value(text: str) -> Any:
    """A whole number, another number, a list of them where there are commas, or a word."""
    if "," in text:
        return [_value(entry) for entry in text.split(",")]
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text


def flag(parameter: str) -> str:
    """How a parameter of an algorithm is given on the command line."""
    return FLAGS.get(parameter, f"--set {parameter}=...")
