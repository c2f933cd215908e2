"""Parameters of an algorithm as they are typed on the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

FLAGS: Mapping[str, str] = {
    "sigma": "--sigma",
    "tau": "--tau",
    "n_walkers": "--walkers",
    "perturbation": "--perturbation",
    "population": "--population",
}


def flag(parameter: str) -> str:
    """How a parameter is given: by a flag of its own, or by --set."""
    return FLAGS.get(parameter, f"--set {parameter}=...")


def parse_numbers(name: str, text: str) -> float | list[float]:
    """One number, or a list where there are commas.

    Raises
    ------
    ValueError
        If an entry is no number.
    """
    try:
        numbers = [float(entry) for entry in text.split(",")]
    except ValueError as error:
        raise ValueError(
            f"{name} = {text!r}: expected a number or numbers separated by commas"
        ) from error
    return numbers[0] if len(numbers) == 1 else numbers


def parse_value(text: str) -> Any:
    """A whole number, another number, a list of them where there are commas, or a word."""
    if "," in text:
        return [parse_value(entry) for entry in text.split(",")]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def parse_settings(settings: Sequence[str]) -> dict[str, Any]:
    """The parameters of NAME=VALUE texts.

    Raises
    ------
    ValueError
        If a text is none of that form, names a parameter twice or one with a flag of its own.
    """
    parameters: dict[str, Any] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not (name and equals and value):
            raise ValueError(f"--set {setting}: expected NAME=VALUE")
        if name in FLAGS:
            raise ValueError(f"--set {setting}: expected {FLAGS[name]} for this parameter")
        if name in parameters:
            raise ValueError(f"--set {setting}: {name} is given twice")
        parameters[name] = parse_value(value)
    return parameters
