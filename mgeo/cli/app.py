"""Command ``mgeo`` with its own commands and those of plugins, which are imported at first use."""

from __future__ import annotations

import io
import os
import platform
import sys
import warnings
from collections.abc import Iterable, Mapping
from importlib import metadata
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from mgeo.cli import explore, listing, report, solve, study
from mgeo.cli.errors import (
    EXIT_CODES,
    ExitCode,
    print_warning,
    raise_on_sigterm,
    report_errors,
)
from mgeo.plugins.discovery import (
    ALGORITHMS,
    COMMANDS,
    PROBLEMS,
    Plugin,
    list_plugins,
)

#: Examples of each command, which its help shows and the tests run.
EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "solve": (
        "mgeo solve attitude",
        "mgeo solve attitude --scenario cubesat_6u --algorithm nsga2 --set population=50",
        "mgeo solve attitude --robust",
        "mgeo solve attitude --seed 2 --json | jq .hypervolume.value",
    ),
    "resume": (
        "mgeo resume runs/attitude-mgeo-directed-seed1",
        "mgeo resume runs/attitude-mgeo-directed-seed1 --evaluations 120000",
    ),
    "report": (
        "mgeo report runs/attitude-mgeo-directed-seed1",
        "mgeo report runs/attitude-mgeo-directed-seed1 --figure front --paper",
        "mgeo report runs/first runs/second --out beside.html",
        "mgeo report studies/benchmarks --figure ranks --paper",
    ),
    "explore": (
        "mgeo explore runs/attitude-mgeo-directed-seed1",
        "mgeo explore runs/first --save plan.json --port 8000 --no-browser",
    ),
    "problems": ("mgeo problems", "mgeo problems --json | jq -r .problems[].name"),
    "algorithms": ("mgeo algorithms", "mgeo algorithms mgeo-directed"),
    "study": (
        "mgeo study table3.toml --seeds 3 --evaluations 3600",
        "mgeo study table3.toml --dry-run",
        "mgeo study table3.toml --cluster tcp://HOST:8786",
    ),
    "schema": ("mgeo schema study | tee study.schema.json",),
}


def format_examples(command: str, examples: Mapping[str, Iterable[str]] = EXAMPLES) -> str:
    """Return the examples of a command as the last part of its help."""
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in examples[command])])


class CommandGroup(TyperGroup):
    """Group of commands that prints its help if no command is given."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not (args or ctx.resilient_parsing):
            typer.echo(ctx.get_help(), err=True)
            raise typer.Exit(ExitCode.BAD_INPUT)
        return super().parse_args(ctx, args)


class RootCommandGroup(CommandGroup):
    """Commands of mgeo and of plugins; each error is reported in one line with an exit code."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        ctx.meta["debug"] = "--debug" in args
        with report_errors(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        with report_errors(ctx, debug=ctx.meta["debug"]):
            return super().invoke(ctx)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands; plugins cannot replace commands of mgeo."""
        for plugin in list_plugins(COMMANDS):
            # A name with a dot extends the commands of another plugin.
            if "." not in plugin.name:
                self.commands.setdefault(plugin.name, _PluginCommandStub(plugin))
        return super().list_commands(ctx)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by name; a plugin's command is a stub that is not imported."""
        if cmd_name not in self.commands:
            self.list_commands(ctx)
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command to run, after importing it."""
        name, command, rest = super().resolve_command(ctx, args)
        if isinstance(command, _PluginCommandStub):
            command = command.load()
        return name, command, rest


class _PluginCommandStub(TyperCommand):
    """Stub of a plugin's commands, for the help of ``mgeo`` without importing the plugin."""

    def __init__(self, plugin: Plugin) -> None:
        distribution = plugin.entry_point.dist
        summary = None if distribution is None else distribution.metadata["Summary"]
        super().__init__(name=plugin.name, short_help=summary)
        self._plugin = plugin

    def load(self) -> Any:
        """Import the commands, including those that other distributions add."""
        group = _build_group(self._plugin)
        for plugin in list_plugins(COMMANDS):
            if plugin.name.startswith(f"{self._plugin.name}."):
                group.commands |= _build_group(plugin).commands
        return group


def _build_group(plugin: Plugin) -> Any:
    root = typer.Typer(rich_markup_mode=None)
    root.add_typer(plugin.load(), name=plugin.name, cls=CommandGroup)
    return typer.main.get_group(root).commands[plugin.name]


app = typer.Typer(
    name="mgeo",
    cls=RootCommandGroup,
    help="Multiobjective generalized extremal optimization of installed problems.",
    epilog="\n\n".join(
        ["Exit codes:", *(f"{int(code)}: {text}" for code, text in EXIT_CODES.items())]
    ),
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)


def main() -> None:
    # This must precede the import of NumPy. The order of sums in BLAS depends on the number of
    # threads, so that fronts of equal seeds would depend on the number of processors and --jobs.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # Some encodings lack characters.
    raise_on_sigterm()
    warnings.showwarning = print_warning
    app()


def _print_version(is_requested: bool) -> None:
    if not is_requested:
        return
    groups = (PROBLEMS, ALGORITHMS, COMMANDS)
    plugins = {each.distribution for group in groups for each in list_plugins(group)}
    for name in ("mgeo", *sorted(plugins - {"mgeo"}), "numpy", "scipy", "pymoo"):
        typer.echo(f"{name} {metadata.version(name)}")
    typer.echo(f"python {platform.python_version()}")
    raise typer.Exit


@app.callback()
def _root(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the versions of mgeo, its plugins and their dependencies, and exit.",
        ),
    ] = False,
    no_color: Annotated[
        bool, typer.Option("--no-color", help="Print no colors, as with the variable NO_COLOR.")
    ] = False,
) -> None:
    if no_color:
        os.environ["NO_COLOR"] = "1"


for _command in (
    solve.solve,
    solve.resume,
    report.report,
    explore.explore,
    listing.problems,
    listing.algorithms,
    study.study,
    study.schema,
):
    _about = (_command.__doc__ or "").partition("\n")[0]
    app.command(epilog=format_examples(_command.__name__), short_help=_about)(_command)
