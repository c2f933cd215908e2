"""``mgeo problems``: what is installed."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from mgeo.cli.output import Output
from mgeo.consoles import plain
from mgeo.plugins import Plugin, installed_plugins, load_problem, preset_names
from mgeo.runs.names import problem_size


def list_problems(output: Output) -> None:
    """Print one row per installed problem; why one does not load comes below."""
    found = [_described(plugin) for plugin in installed_plugins()]
    output.result({"problems": found})
    if not found:
        output.print("no problem is installed; the first to try: pip install mgeo-attitude")
        return
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    for title in ("name", "distribution", "variables", "objectives"):
        table.add_column(title)
    for one in found:
        cells = [one["name"], f"{one['distribution']} {one['version']}"]
        if one["error"] is None:
            cells += [str(len(one["variables"])), ", ".join(one["objectives"])]
        else:
            cells += ["-", "does not load"]
        table.add_row(*map(plain, cells))
    errors = [f"Error: {one['name']}: {one['error']}" for one in found if one["error"] is not None]
    output.print(table, *(plain(error, style="red") for error in errors))


def _described(plugin: Plugin) -> dict[str, Any]:
    known: dict[str, Any] = {
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "presets": preset_names(plugin.name),
    }
    try:
        return known | problem_size(load_problem(plugin.name)) | {"error": None}
    except Exception as error:  # foreign code: one broken plugin must not hide the others
        return known | {"variables": [], "objectives": [], "constraints": 0, "error": str(error)}
