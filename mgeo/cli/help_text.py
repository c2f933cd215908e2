"""Layout of the help of commands: arguments and options in groups, examples and exit codes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from typer.core import TyperCommand, TyperGroup

from mgeo._text import TEXT_WIDTH, wrap_text
from mgeo.cli.errors import EXIT_CODES

#: Group of the options that most commands have.
GENERAL_OPTIONS = "General options"


class Command(TyperCommand):
    """Command whose help page lists arguments and options in groups."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [re.sub("[{}]", "", piece) for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        _write_groups(map(_describe_parameter, self.get_params(ctx)), formatter)


class CommandGroup(TyperGroup):
    """Command group whose help page lists subcommands in groups, with untruncated summaries."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        commands: dict[str, Any] = {n: self.get_command(ctx, n) for n in self.list_commands(ctx)}
        rows = [
            (command.rich_help_panel or "Commands", name, command.get_short_help_str(1000))
            for name, command in commands.items()
            if not command.hidden
        ]
        options = map(_describe_parameter, self.get_params(ctx))
        rows += [(GENERAL_OPTIONS, names, text) for _, names, text in options]
        _write_groups(rows, formatter)


def format_examples(command: str, examples: Mapping[str, Iterable[str]]) -> str:
    """Return the "Examples" section of a command's help page.

    Parameters
    ----------
    command
        Name of the command.
    examples
        Example command lines by command.
    """
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in examples[command])])


def format_exit_codes() -> str:
    """Return the section "Exit codes" of the help text."""
    lines = (
        wrap_text(f"  {int(code):<5}{text}", " " * 7, TEXT_WIDTH - 2)
        for code, text in EXIT_CODES.items()
    )
    return "\n".join(["\b", "Exit codes:", *lines])


def _write_groups(rows: Iterable[tuple[str, str, str]], formatter: Any) -> None:
    groups: dict[str, list[tuple[str, str]]] = {}
    for group, name, text in rows:
        groups.setdefault(group, []).append((name, text))
    for group, lines in groups.items():
        with formatter.section(group):
            formatter.write_dl(lines)


def _describe_parameter(parameter: Any) -> tuple[str, str, str]:
    """Return the group, the name and the description of a parameter, for the help page."""
    text = parameter.help or ""
    if parameter.param_type_name == "argument":
        return "Arguments", parameter.metavar or parameter.name.upper(), text
    group = GENERAL_OPTIONS if parameter.name == "help" else "Options"
    group = getattr(parameter, "rich_help_panel", None) or group
    names = ", ".join(sorted([*parameter.opts, *parameter.secondary_opts], key=len))
    if parameter.is_flag:
        return group, names, text
    if parameter.default not in (None, ()):
        text += f" [default: {parameter.default}]"
    return group, f"{names} {parameter.metavar or 'N'}", text
