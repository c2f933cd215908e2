"""Commands ``mgeo problems`` and ``mgeo algorithms``."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from mgeo.cli import options
from mgeo.cli.errors import convert_input_errors
from mgeo.plugins.discovery import Plugin, PluginError, list_plugins, list_preset_names
from mgeo.terminal import Output, build_table, escape_text


def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems."""
    descriptions = [_describe_problem(plugin) for plugin in list_plugins()]
    output = Output(json=json)
    output.print_document({"problems": descriptions})
    if not descriptions:
        output.print(
            "no problem is installed; for the attitude problem: pip install ./problems/attitude"
        )
        return
    titles = ("name", "distribution", "version", "variables", "objectives")
    rows = [
        (*(each[key] for key in titles[:3]), len(each["variables"]), ", ".join(each["objectives"]))
        for each in descriptions
    ]
    errors = [f"Error: {each['name']}: {each['error']}" for each in descriptions if each["error"]]
    output.print(build_table(titles, rows), *(escape_text(error, style="red") for error in errors))


def algorithms(
    name: Annotated[
        str | None,
        typer.Argument(
            help="Name of an algorithm, or MODULE:CLASS.",
            autocompletion=options.complete_algorithms,
        ),
    ] = None,
    json: options.Json = False,
    debug: options.Debug = False,
) -> None:
    """List the algorithms, or the parameters of one algorithm."""
    from mgeo.runs.algorithms import describe_algorithm, list_algorithms

    output = Output(json=json)
    if name is None:
        descriptions = [_describe_algorithm(each) for each in list_algorithms()]
        output.print_document({"algorithms": descriptions})
        rows = [
            [each["name"], each["label"], each["error"] or each["description"]]
            for each in descriptions
        ]
        output.print(build_table(("name", "algorithm", "description"), rows))
        return
    with convert_input_errors():
        description = describe_algorithm(name)
    output.print_document(description)
    rows = [
        [p["name"], _format_default(p["default"]), p["meaning"]] for p in description["parameters"]
    ]
    output.print(
        f"{name}: {description['description']}",
        build_table(("parameter", "default", "description"), rows),
        "set a parameter by --set NAME=VALUE",
    )


def _describe_algorithm(name: str) -> dict[str, Any]:
    from mgeo.runs.algorithms import describe_algorithm

    try:
        return describe_algorithm(name) | {"error": None}
    except PluginError as error:  # One broken plugin must not hide the other algorithms.
        return {
            "name": name,
            "label": name,
            "description": "",
            "parameters": [],
            "error": str(error),
        }


def _describe_problem(plugin: Plugin) -> dict[str, Any]:
    from mgeo.plugins.problems import load_problem
    from mgeo.plugins.protocol import describe_size

    record: dict[str, Any] = {
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "presets": list_preset_names(plugin.name),
    }
    try:
        return record | describe_size(load_problem(plugin.name)) | {"error": None}
    except (ValueError, OSError) as error:  # One broken plugin must not hide the other problems.
        return record | {"variables": [], "objectives": [], "constraints": 0, "error": str(error)}


def _format_default(default: object) -> str:
    return ",".join(map(str, default)) if isinstance(default, list | tuple) else str(default)
