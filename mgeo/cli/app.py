"""Root command ``mgeo``, with its own subcommands and those of installed plugins."""

from __future__ import annotations

import io
import os
import platform
import sys
import warnings
from collections.abc import Mapping
from importlib import metadata
from typing import Annotated, Any

import typer

from mgeo.cli import explore, listing, report, schema, solve, study
from mgeo.cli.errors import (
    ExitCode,
    print_warning,
    raise_on_sigterm,
    report_errors,
)
from mgeo.cli.help_text import (
    Command,
    CommandGroup,
    format_examples,
    format_exit_codes,
)
from mgeo.plugins.discovery import (
    ALGORITHMS,
    COMMANDS,
    PROBLEMS,
    Plugin,
    list_plugins,
)

#: Example command lines by command. The help of the command shows them, and a test parses them.
EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "solve": (
        "mgeo solve attitude",
        "mgeo solve attitude --scenario cubesat_6u --dry-run",
        "mgeo solve attitude --scenario cubesat_6u --robust",
        "mgeo solve pymoo:zdt1 --algorithm nsga2 --set population=50",
        "mgeo solve attitude --seed 2 --json | jq .hypervolume",
    ),
    "resume": (
        "mgeo resume runs/attitude-mgeo-directed-seed1",
        "mgeo resume runs/attitude-mgeo-directed-seed1 --evaluations 120000",
    ),
    "report": (
        "mgeo report runs/attitude-mgeo-directed-seed1",
        "mgeo report runs/attitude-mgeo-directed-seed1 --figure front --paper",
        "mgeo report runs/first runs/second --out both.html",
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
    "schema": ("mgeo schema study.toml | tee study.schema.json", "mgeo schema solve"),
}


#: Title of the command groups of installed problems in the help.
_PROBLEM_COMMANDS = "Command groups of problems, each with its own --help"


class _CommandGroup(CommandGroup):
    """Command group that prints its help and exits with code 2 if no subcommand is given."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not (args or ctx.resilient_parsing):
            typer.echo(ctx.get_help(), err=True)
            raise typer.Exit(ExitCode.BAD_INPUT)
        return super().parse_args(ctx, args)


class RootCommandGroup(_CommandGroup):
    """Root command group that adds the commands of installed plugins and reports errors.

    An error of a command is printed as one line on stderr and sets the exit code, see `ExitCode`.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        ctx.meta["debug"] = "--debug" in args
        with report_errors(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        with report_errors(ctx, debug=ctx.meta["debug"]):
            return super().invoke(ctx)

    def list_commands(self, ctx: Any) -> list[str]:
        for plugin in list_plugins(COMMANDS):
            # A name with a dot extends the commands of another plugin.
            if "." not in plugin.name:
                # A plugin must not replace a command of mgeo.
                self.commands.setdefault(plugin.name, _PluginCommandStub(plugin))
        return super().list_commands(ctx)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in self.commands:
            self.list_commands(ctx)
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, command, rest = super().resolve_command(ctx, args)
        if isinstance(command, _PluginCommandStub):
            command = command.load()
        return name, command, rest


class _PluginCommandStub(Command):
    """Placeholder that lets ``mgeo --help`` list a command group without importing its plugin."""

    def __init__(self, plugin: Plugin) -> None:
        distribution = plugin.entry_point.dist
        summary = None if distribution is None else distribution.metadata["Summary"]
        super().__init__(name=plugin.name, short_help=summary, rich_help_panel=_PROBLEM_COMMANDS)
        self._plugin = plugin

    def load(self) -> Any:
        """Import the plugin and return its command group.

        The group includes subcommands that other distributions add.
        """
        group = _build_group(self._plugin)
        for plugin in list_plugins(COMMANDS):
            if plugin.name.startswith(f"{self._plugin.name}."):
                group.commands |= _build_group(plugin).commands
        return group


def _build_group(plugin: Plugin) -> Any:
    application = plugin.load()
    for command in application.registered_commands:
        command.cls = Command
    root = typer.Typer(rich_markup_mode=None)
    root.add_typer(application, name=plugin.name, cls=_CommandGroup)
    return typer.main.get_group(root).commands[plugin.name]


app = typer.Typer(
    name="mgeo",
    cls=RootCommandGroup,
    help="Solve multiobjective problems by generalized extremal optimization, and compare "
    "algorithms.",
    epilog=format_exit_codes() + "\n\nThe help of each command has examples: mgeo solve --help",
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)


def main() -> None:
    """Run the ``mgeo`` command with the arguments in ``sys.argv``."""
    # This must precede the import of NumPy. The order of sums in BLAS depends on the number of
    # threads, so that fronts of equal seeds would depend on the number of processors and --jobs.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # The encoding may lack characters.
    raise_on_sigterm()
    warnings.showwarning = print_warning
    app()


def _print_version(is_requested: bool) -> None:
    if not is_requested:
        return
    groups = (PROBLEMS, ALGORITHMS, COMMANDS)
    plugins = {plugin.distribution for group in groups for plugin in list_plugins(group)}
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
        bool, typer.Option("--no-color", help="Print without colors, as if NO_COLOR were set.")
    ] = False,
) -> None:
    if no_color:
        os.environ["NO_COLOR"] = "1"


for _group, _commands in {
    "Runs": (solve.solve, solve.resume, report.report, explore.explore),
    "Studies": (study.study, schema.schema),
    "Lists": (listing.problems, listing.algorithms),
}.items():
    for _command in _commands:
        app.command(
            cls=Command,
            rich_help_panel=_group,
            epilog=format_examples(_command.__name__, EXAMPLES),
            short_help=(_command.__doc__ or "").partition("\n")[0],
        )(_command)
