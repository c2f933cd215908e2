"""``mgeo problems``: what is installed."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from mgeo.cli.consoles import console
from mgeo.plugins import Plugin, installed_plugins, load_problem
from mgeo.runs.names import column_names


def list_problems() -> None:
    """Print one row per installed problem; why one does not load comes below."""
    plugins = installed_plugins()
    out = console()
    if not plugins:
        out.print(Text("no problem is installed; the first to try: pip install mgeo-attitude"))
        return
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    for title in ("name", "distribution", "variables", "objectives"):
        table.add_column(title)
    errors = []
    for plugin in plugins:
        error, *contents = _contents(plugin)
        cells = [plugin.name, f"{plugin.distribution} {plugin.version}", *contents]
        table.add_row(*map(Text, cells))
        errors += [error] if error else []
    out.print(table)
    for error in errors:
        out.print(Text(f"Error: {error}", style="red"), soft_wrap=True)


def _contents(plugin: Plugin) -> tuple[str, str, str]:
    """Error (or nothing), number of variables, objectives."""
    try:
        variables, objectives = column_names(load_problem(plugin.name))
    except Exception as error:  # foreign code: one broken plugin must not hide the others
        return f"{plugin.name}: {error}", "-", "does not load"
    return "", f"{len(variables)}", ", ".join(objectives)
