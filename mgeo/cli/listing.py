"""Commands ``mgeo problems`` and ``mgeo algorithms``."""

from __future__ import annotations

from textwrap import indent
from typing import TYPE_CHECKING, Annotated

import typer

from mgeo._text import TEXT_WIDTH, wrap_text
from mgeo.benchmarks.collections import EXAMPLES_BY_PREFIX
from mgeo.cli import options
from mgeo.cli.errors import convert_input_errors
from mgeo.plugins.discovery import Plugin, PluginError, list_plugins, list_preset_names
from mgeo.plugins.review import Section
from mgeo.terminal import Output

if TYPE_CHECKING:
    from mgeo.documents import (
        AlgorithmRow,
        AlgorithmsDocument,
        ProblemRow,
        ProblemsDocument,
        ProblemSize,
    )


def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems, with their objectives and presets."""
    import pandas as pd

    descriptions = [_describe_problem(plugin) for plugin in list_plugins()]
    output = Output(json=json)
    document: ProblemsDocument = {"problems": descriptions}
    output.print_document(document)
    if not descriptions:
        output.print("No problem is installed. Install one with: pip install mgeo-attitude")
        return
    rows = [
        (
            each["name"],
            len(each["variables"]),
            ", ".join(each["objectives"]),
            each["distribution"],
        )
        for each in descriptions
        if not each["error"]
    ]
    table = pd.DataFrame(rows, columns=["problem", "variables", "objectives", "package"])
    output.print_sections(Section("", table=table))
    presets = {each["name"]: ", ".join(each["presets"]) for each in descriptions if each["presets"]}
    if presets:
        output.print("")
        output.print_title("Presets for --scenario")
        output.print_pairs(presets)
    output.print("", f"Test problems, for example: {', '.join(EXAMPLES_BY_PREFIX.values())}")
    output.print_commands({"Check a run": f"mgeo solve {descriptions[0]['name']} --dry-run"})
    for each in descriptions:
        if each["error"]:
            output.print_note(f"Error: {each['name']}: {each['error']}")


def algorithms(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="Algorithm whose parameters are listed: a name, or a class as MODULE:CLASS.",
            autocompletion=options.complete_algorithms,
        ),
    ] = None,
    json: options.Json = False,
    debug: options.Debug = False,
) -> None:
    """List the algorithms, or the parameters of one algorithm."""
    import pandas as pd

    from mgeo.runs.algorithms import describe_algorithm, list_algorithms

    output = Output(json=json)
    if name is None:
        descriptions = [_describe_algorithm(each) for each in list_algorithms()]
        document: AlgorithmsDocument = {"algorithms": descriptions}
        output.print_document(document)
        rows = [
            (each["name"], each["library"], each["error"] or each["description"])
            for each in descriptions
        ]
        table = pd.DataFrame(rows, columns=["algorithm", "library", "method and use"])
        output.print_sections(Section("", table=table))
        output.print_commands({"Parameters of an algorithm": "mgeo algorithms NAME"})
        return
    with convert_input_errors():
        description = describe_algorithm(name)
    output.print_document(description)
    output.print_title(f"{name}: {description['label']}")
    output.print_text(description["description"])
    for parameter in description["parameters"]:
        output.print(f"\n{parameter['name']} = {_format_default(parameter['default'])}")
        output.print(indent(wrap_text(parameter["meaning"], width=TEXT_WIDTH - 4), "    "))
    command = f"mgeo solve PROBLEM --algorithm {name} --set NAME=VALUE"
    output.print_commands({"Set a parameter": command})


def _describe_algorithm(name: str) -> AlgorithmRow:
    from mgeo.runs.algorithms import describe_algorithm

    try:
        return {**describe_algorithm(name), "error": None}
    except PluginError as error:  # One broken plugin must not hide the other algorithms.
        return {
            "name": name,
            "label": name,
            "library": "",
            "description": "",
            "parameters": [],
            "error": str(error),
        }


def _describe_problem(plugin: Plugin) -> ProblemRow:
    from mgeo.plugins.problems import load_problem
    from mgeo.plugins.protocol import describe_size

    size: ProblemSize = {"variables": [], "objectives": [], "constraints": 0}
    message = None
    try:
        size = describe_size(load_problem(plugin.name))
    except (ValueError, OSError) as error:  # One broken plugin must not hide the other problems.
        message = str(error)
    return {
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "presets": list_preset_names(plugin.name),
        **size,
        "error": message,
    }


def _format_default(default: object) -> str:
    return ",".join(map(str, default)) if isinstance(default, list | tuple) else str(default)
