"""Arguments and flags that commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from mgeo.cli import completion
from mgeo.cli.errors import remember_debug
from mgeo.cli.parameters import FLAGS


class Solving(TyperCommand):
    """A command whose help on algorithms comes from their table and classes, imported for it."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, with what is known only now."""
        from mgeo.runs import algorithms

        others = ", ".join(algorithms.other_parameters(FLAGS))
        texts = {flag: algorithms.parameter_help(name) for name, flag in FLAGS.items()} | {
            "--algorithm": f"{', '.join(algorithms.ALGORITHMS)}.",
            "--set": f"Any other parameter of the algorithm, such as bits=12 or restart=archive; "
            f"may be given several times. They are {others}.",
        }
        for option in self.params:
            for flag in texts.keys() & option.opts:
                vars(option)["help"] = texts[flag]
        super().format_help(ctx, formatter)


Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Json = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON document, for scripts.")
]
Debug = Annotated[
    bool,
    typer.Option("--debug", callback=remember_debug, help="Show the traceback of an error."),
]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run",
        help="Run and write nothing; tell the size, the files, and about how long it would take.",
    ),
]
Problem = Annotated[
    str,
    typer.Argument(
        help="Name of a problem (see `mgeo problems`).", autocompletion=completion.problems
    ),
]
Scenario = Annotated[
    str | None,
    typer.Option(
        metavar="FILE.toml|PRESET",
        help="Options of the problem: a file, or a preset's name.",
        autocompletion=completion.scenarios,
    ),
]
Algorithm = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        autocompletion=completion.among_those_of("mgeo.runs.algorithms:ALGORITHMS"),
    ),
]
Sigma = Annotated[str | None, typer.Option(metavar="NUMBER[,NUMBER...]")]
Tau = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER|NAME",
        autocompletion=completion.among_those_of("mgeo.algorithms.selection:RULES"),
    ),
]
Walkers = Annotated[int | None, typer.Option("--walkers", "--runs")]
Perturbation = Annotated[
    str | None,
    typer.Option(
        metavar="NAME", autocompletion=completion.among_those_of("mgeo.algorithms.steps:SCALES")
    ),
]
Population = Annotated[int | None, typer.Option()]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE"),
]
Budget = Annotated[
    int | None,
    typer.Option(min=1, help="Budget [default: 5000 generations of one candidate per variable]."),
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all randomness.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
]
Record = Annotated[
    bool, typer.Option("--record", help="Keep every evaluation, in the folder's evaluations/.")
]
Unfinished = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="Folder of the run.", autocompletion=completion.kept_runs),
]
Finished = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="Folder of the run.", autocompletion=completion.runs),
]
StudyFile = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="A study as TOML.", autocompletion=completion.toml_files),
]
