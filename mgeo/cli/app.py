"""The command ``mgeo`` and its commands; those of plugins are imported when they are run.

Examples for their help stand here, too, for the tests that read them.
"""

from __future__ import annotations

import os
import re
import textwrap
import warnings
from collections.abc import Iterable, Iterator, Mapping
from importlib import metadata
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from mgeo._foreign import foreign
from mgeo.cli import explore, installed, report, runs, study
from mgeo.cli.errors import ExitCode, ended
from mgeo.cli.output import reserved
from mgeo.plugins.discovery import (
    ALGORITHMS,
    COMMANDS,
    PROBLEMS,
    Plugin,
    PluginError,
    entry_points,
    find_plugin,
    installed_plugins,
)

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "solve": (
        "mgeo solve attitude",
        "mgeo solve attitude --scenario cubesat_6u --algorithm nsga2 --population 50",
        "mgeo solve attitude --scenario mine.toml --evaluations 20000 --out runs/mine --dry-run",
        "mgeo solve attitude --robust",
        "mgeo solve attitude --algorithm mgeo-canonical --set bits=12 --set restart=archive",
        "mgeo solve attitude --seed 2 --json | jq .hypervolume.value",
    ),
    "resume": (
        "mgeo resume runs/attitude-mgeo-directed-seed1",
        "mgeo resume runs/attitude-mgeo-directed-seed1 --evaluations 120000",
    ),
    "report": (
        "mgeo report runs/attitude-mgeo-directed-seed1",
        "mgeo report runs/attitude-mgeo-directed-seed1 --out review.html",
        "mgeo report runs/attitude-mgeo-directed-seed1 --png --pdf",
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

_ROOM = 74  # of 80 columns, beside the indentation and the backslash


def epilog(command: str, examples: Mapping[str, Iterable[str]] = EXAMPLES) -> str:
    """The end of a command's help."""
    lines = (broken for line in examples[command] for broken in _broken(line))
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in lines)])


def _broken(line: str) -> Iterator[str]:
    """A command in lines that a shell takes as one, each but the first with whole options."""
    shown = ""
    for part in re.split(r" (?=--|\|)", line):
        if shown and len(shown) + len(part) > _ROOM:
            yield f"{shown} \\"
            shown = f"  {part}"
        else:
            shown = f"{shown} {part}" if shown else part
    yield shown


_WHOLE = 1000  # characters of a sentence


class Commands(TyperGroup):
    """Commands of which every error is one line, and an exit code."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options before the command's name; without any words, show the help."""
        if not (args or ctx.resilient_parsing):
            typer.echo(ctx.get_help(), err=True)
            raise typer.Exit(2)
        with ended(ctx):
            return super().parse_args(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """What each command does, its whole first sentence: click would cut it at the margin."""
        named = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        shown = [(name, found.get_short_help_str(_WHOLE)) for name, found in named if found]
        if shown:
            with formatter.section("Commands"):
                formatter.write_dl(shown)

    def invoke(self, ctx: Any) -> Any:
        """Read the command's own words and do it; it ends by returning or `typer.Exit`."""
        with ended(ctx), foreign():
            return super().invoke(ctx)


class RootCommands(Commands):
    """mgeo's own commands, and after them those of plugins; mgeo's own cannot be replaced."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands."""
        self._find_plugins()
        return super().list_commands(ctx)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of this name, of a plugin only its name and what it is about."""
        if cmd_name not in self.commands:
            self._find_plugins()
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command to run, of a plugin imported."""
        name, command, rest = super().resolve_command(ctx, args)
        if isinstance(command, _NotImported):
            try:
                with reserved():  # a word --json may follow
                    command = _imported(args[0])
            except PluginError:
                if not ctx.resilient_parsing:  # else a shell asks, and there is nothing to offer
                    raise
        return name, command, rest

    def _find_plugins(self) -> None:
        for plugin in installed_plugins(COMMANDS):
            if "." in plugin.name:  # adds to the commands of another
                continue
            self.commands.setdefault(plugin.name, _NotImported(plugin.name))


class _NotImported(TyperCommand):
    """What stands for a plugin's commands in the help: the summary of its distribution."""

    def __init__(self, name: str) -> None:
        try:
            plugin = find_plugin(name, COMMANDS)
            found = plugin.entry_point.dist
            about = f"Of {plugin.distribution}."
            if found is not None and "Summary" in found.metadata:
                about = found.metadata["Summary"]
        except PluginError as error:
            about = str(error)
        super().__init__(name=name, help=about)


def _imported(name: str) -> Any:
    """A plugin's commands and what others add to them, with the help and errors of mgeo's own."""
    group = _group(find_plugin(name, COMMANDS))
    for plugin in installed_plugins(COMMANDS):
        if plugin.name.startswith(f"{name}."):
            group.commands |= _group(find_plugin(plugin.name, COMMANDS)).commands
    return group


def _group(plugin: Plugin) -> Any:
    """Commands of one plugin."""
    root = typer.Typer(rich_markup_mode=None)
    root.add_typer(plugin.load(), name=plugin.name, cls=Commands)
    return typer.main.get_group(root).commands[plugin.name]


_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def versions() -> dict[str, str]:
    """Versions by name: of mgeo, of its plugins, of Python, and of what all of these require."""
    import platform

    plugins = {
        entry.dist.name
        for group in (PROBLEMS, ALGORITHMS, COMMANDS)
        for entry in entry_points(group)
        if entry.dist
    }
    own = ["mgeo", *sorted(plugins)]
    needed = {name for package in own for name in _required(package)} - {*own}
    found = {name: metadata.version(name) for name in own}
    found["python"] = platform.python_version()
    return found | {name: metadata.version(name) for name in sorted(needed)}


def _required(package: str) -> list[str]:
    """Names of what a package cannot do without: what an extra or a platform adds is left out."""
    lines = [line for line in metadata.requires(package) or () if ";" not in line]
    return [match[0].lower() for line in lines if (match := _NAME.match(line))]


def _exit_codes() -> Iterator[str]:
    for code in ExitCode:
        lines = textwrap.wrap(code.meaning, 66)
        yield from (
            f"{c:>5}  {line}" for c, line in zip([code.value, *[""] * 9], lines, strict=False)
        )


app = typer.Typer(
    name="mgeo",
    cls=RootCommands,
    help="Multiobjective generalized extremal optimization of installed problems.",
    epilog="\n".join(["\b", "Exit codes:", *_exit_codes()]),
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)


def main() -> None:
    """Entry point of the command ``mgeo``; what will go of a file's keys is told, each once."""
    shown, told = warnings.showwarning, set[str]()

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if not issubclass(category, FutureWarning):
            shown(message, category, *where, **more)
        elif str(message) not in told:
            told.add(str(message))
            typer.echo(f"Note: {message}", err=True)

    warnings.showwarning = show
    # before NumPy is imported: with several threads BLAS adds in another order, so that the same
    # seed would give another front where there are more processors, and a study with other --jobs
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        for name, number in versions().items():
            typer.echo(f"{name} {number}")
        raise typer.Exit


@app.callback()
def _root(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the versions of mgeo, its plugins and what they need, and exit.",
        ),
    ] = False,
    no_color: Annotated[
        bool, typer.Option("--no-color", help="No colors, as with NO_COLOR in the environment.")
    ] = False,
) -> None:
    if no_color:
        os.environ["NO_COLOR"] = "1"


for _command in (
    runs.solve,
    runs.resume,
    report.report,
    explore.explore,
    installed.problems,
    installed.algorithms,
    study.study,
    study.schema,
):
    app.command(epilog=epilog(_command.__name__))(_command)
