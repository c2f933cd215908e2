"""``mgeo problems``: what is installed."""

from __future__ import annotations

from typing import Any

from mgeo._foreign import foreign
from mgeo.cli.output import Output
from mgeo.plugins.discovery import Plugin, installed_plugins, load_problem, preset_names
from mgeo.plugins.protocol import problem_size
from mgeo.terminal import plain, table


def list_problems(output: Output) -> None:
    """Print one row per installed problem; why one does not load comes below."""
    found = [_described(plugin) for plugin in installed_plugins()]
    output.result({"problems": found})
    if not found:
        output.print("no problem is installed; the first to try: pip install mgeo-attitude")
        return
    rows, errors = [], []
    for one in found:
        cells = [str(len(one["variables"])), ", ".join(one["objectives"])]
        if one["error"] is not None:
            cells = ["-", "does not load"]
            errors.append(plain(f"Error: {one['name']}: {one['error']}", style="red"))
        rows.append([one["name"], f"{one['distribution']} {one['version']}", *cells])
    output.print(table(("name", "distribution", "variables", "objectives"), rows), *errors)


def _described(plugin: Plugin) -> dict[str, Any]:
    known: dict[str, Any] = {
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "presets": preset_names(plugin.name),
    }
    try:
        with foreign():
            return known | problem_size(load_problem(plugin.name)) | {"error": None}
    except Exception as error:  # foreign code: one broken plugin must not hide the others
        return known | {"variables": [], "objectives": [], "constraints": 0, "error": str(error)}
