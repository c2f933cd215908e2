"""Commands ``mgeo problems`` and ``mgeo algorithms``."""

from __future__ import annotations

import re
from textwrap import indent
from typing import TYPE_CHECKING, Annotated

import typer

from mgeo._text import TEXT_WIDTH, wrap_text
from mgeo.benchmarks.collections import EXAMPLES
from mgeo.cli import options
from mgeo.cli.errors import convert_input_errors
from mgeo.plugins.discovery import Plugin, PluginError, list_plugins, list_preset_names
from mgeo.plugins.review import Section
from mgeo.runs.registry import ALGORITHMS
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

    described = [_describe_problem(plugin) for plugin in list_plugins()]
    descriptions = [description for description, _ in described]
    output = Output(json=json)
    document: ProblemsDocument = {"problems": descriptions}
    output.print_document(document)
    if not descriptions:
        output.print("No problem is installed. Install one with: pip install mgeo-attitude")
        return
    rows = [
        (each["name"], len(each["variables"]), ", ".join(titles))
        for each, titles in described
        if not each["error"]
    ]
    table = pd.DataFrame(rows, columns=["problem", "variables", "objectives"])
    note = "Variables and objectives of the default scenario; --scenario selects another."
    output.print_sections(Section("", table=table, note=note))
    presets = [
        (each["name"], preset, text)
        for each in descriptions
        for preset, text in each["presets"].items()
    ]
    if presets:
        table = pd.DataFrame(presets, columns=["problem", "preset", "scenario"])
        output.print("")
        output.print_sections(Section("Presets of --scenario", table=table))
    output.print("")
    output.print_title("Test problems, for example")
    output.print_pairs(EXAMPLES)
    name = descriptions[0]["name"]
    output.print_commands({"Size of a run, without running it": f"mgeo solve {name} --dry-run"})
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
    if name in ALGORITHMS and ALGORITHMS[name].candidates:
        output.print_text("", ALGORITHMS[name].candidates)
    for parameter in description["parameters"]:
        output.print(f"\n{parameter['name']} = {_format_default(parameter['default'])}")
        meaning = _format_meaning(parameter["meaning"])
        output.print(indent(wrap_text(meaning, width=TEXT_WIDTH - 4), "    "))
    command = f"mgeo solve PROBLEM --algorithm {name} --set NAME=VALUE"
    output.print_commands({"Set a parameter": command})


def _format_meaning(text: str) -> str:
    """Replace class names by command-line names, and remove references to modules."""
    text = re.sub(r" \(`mgeo\.[\w.]+`\)", "", text)
    for name, record in ALGORITHMS.items():
        text = text.replace(f"`{record.path.partition(':')[2]}`", name)
    return text


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


def _describe_problem(plugin: Plugin) -> tuple[ProblemRow, list[str]]:
    """Return the description of a problem and the titles of its objectives."""
    from mgeo.plugins.problems import load_problem
    from mgeo.plugins.protocol import describe_size
    from mgeo.plugins.view import build_view

    size: ProblemSize = {"variables": [], "objectives": [], "constraints": 0}
    message, texts, titles = None, {}, []
    try:
        problem = load_problem(plugin.name)
        size = describe_size(problem)
        texts = dict(getattr(problem, "preset_descriptions", {}))
        titles = list(map(build_view(problem).format_title, size["objectives"]))
    except (ValueError, OSError) as error:  # One broken plugin must not hide the other problems.
        message = str(error)
    description: ProblemRow = {
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "presets": {name: texts.get(name, "") for name in list_preset_names(plugin.name)},
        **size,
        "error": message,
    }
    return description, titles


def _format_default(default: object) -> str:
    return ",".join(map(str, default)) if isinstance(default, list | tuple) else str(default)
