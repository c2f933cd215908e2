"""``mgeo problems`` and ``mgeo algorithms``: what is installed, and what it takes."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from mgeo._foreign import foreign
from mgeo.cli import options
from mgeo.cli.errors import bad_input
from mgeo.cli.options import FLAGS
from mgeo.cli.output import Output
from mgeo.plugins.discovery import Plugin, installed_plugins, preset_names
from mgeo.terminal import plain, table


def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems."""
    found = [_described(plugin) for plugin in installed_plugins()]
    output = Output(json=json)
    output.result({"problems": found})
    if not found:
        output.print("no problem is installed; the first to try: pip install ./problems/attitude")
        return
    rows, errors = [], []
    for one in found:
        cells = [str(len(one["variables"])), ", ".join(one["objectives"])]
        if one["error"] is not None:
            cells = ["-", "does not load"]
            errors.append(plain(f"Error: {one['name']}: {one['error']}", style="red"))
        rows.append([one["name"], f"{one['distribution']} {one['version']}", *cells])
    output.print(table(("name", "distribution", "variables", "objectives"), rows), *errors)


def algorithms(
    name: Annotated[
        str | None,
        typer.Argument(help="One of them, or MODULE:CLASS.", autocompletion=options.algorithms),
    ] = None,
    json: options.Json = False,
    debug: options.Debug = False,
) -> None:
    """List the algorithms, or the parameters of one."""
    output = Output(json=json)
    if name is None:
        _list_algorithms(output)
        return
    from mgeo.runs.algorithms import described

    with bad_input():
        found = described(name)
    output.result(found)
    rows = [
        [FLAGS.get(p["name"], p["name"]), _text(p["default"]), p["meaning"]]
        for p in found["parameters"]
    ]
    output.print(
        f"{name}: {found['about']}",
        table(("parameter", "default", "what"), rows),
        "a parameter without -- is given by --set NAME=VALUE",
    )


def _list_algorithms(output: Output) -> None:
    from mgeo.runs.algorithms import algorithm_names, described

    every = []
    for each in algorithm_names():
        try:
            with foreign():
                every.append(described(each) | {"error": None})
        except Exception as error:  # foreign code: one broken plugin must not hide the others
            every.append(
                {"name": each, "about": "does not load", "parameters": [], "error": str(error)}
            )
    output.result({"algorithms": every})
    rows = [[each["name"], each["about"]] for each in every]
    failed = [f"Error: {each['name']}: {each['error']}" for each in every if each["error"]]
    output.print(table(("name", "what"), rows), *(plain(e, style="red") for e in failed))


def _described(plugin: Plugin) -> dict[str, Any]:
    known: dict[str, Any] = {
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "presets": preset_names(plugin.name),
    }
    from mgeo.plugins.problems import load_problem
    from mgeo.plugins.protocol import problem_size

    try:
        with foreign():
            return known | problem_size(load_problem(plugin.name)) | {"error": None}
    except Exception as error:  # foreign code: one broken plugin must not hide the others
        return known | {"variables": [], "objectives": [], "constraints": 0, "error": str(error)}


def _text(default: object) -> str:
    return ",".join(map(str, default)) if isinstance(default, list | tuple) else str(default)
