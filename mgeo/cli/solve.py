"""``mgeo solve`` and ``mgeo resume``: their options. What takes long to import waits for a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import bad_input
from mgeo.terminal import Output

_UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0}


def _duration(text: str) -> float:
    """Return a time [s] from a number of seconds, or a number with a unit: 90, 10m, 2h."""
    unit = text[-1:] if text[-1:] in _UNITS else ""
    try:
        seconds = float(text.removesuffix(unit)) * _UNITS.get(unit, 1.0)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < float("inf"):
        raise typer.BadParameter(f"{text!r}: expected seconds above 0, or as 10m or 2h")
    return seconds


MaxTime = Annotated[
    float | None,
    typer.Option(
        metavar="TIME",
        parser=_duration,
        help="End the run after this time: seconds, or 10m, 2h. Continue it by `mgeo resume`.",
    ),
]


def solve(
    problem: Annotated[
        str,
        typer.Argument(
            help="One of `mgeo problems`, a class of one's own, module:Class, or a test problem, "
            "pymoo:zdt1.",
            autocompletion=options.problems,
        ),
    ],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET",
            help="Options of the problem: a file, or a preset's name.",
            autocompletion=options.scenarios,
        ),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Go on from a result, such as a calibration, if the problem can; a scenario file "
            "says only what differs.",
        ),
    ] = None,
    robust: Annotated[
        bool,
        typer.Option(
            "--robust",
            help="Judge solutions by what they keep where things are not exactly known, if the "
            "problem can.",
        ),
    ] = False,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|MODULE:CLASS",
            help="One of `mgeo algorithms`, or a class of one's own [default: mgeo-directed, of a "
            "robust run mgeo-staged].",
            autocompletion=options.algorithms,
        ),
    ] = None,
    walkers: options.Walkers = None,
    settings: options.Settings = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            min=1, help="Budget [default: 5000 generations of one candidate per variable]."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all randomness.")] = 1,
    starts: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Designs that the problem suggests, to begin with [default: what the problem "
            "recommends; 0 with --robust, --evaluations, an algorithm or its parameters].",
        ),
    ] = None,
    polish: Annotated[
        bool | None,
        typer.Option(
            "--polish/--no-polish",
            help="Let the problem refine what was found, in addition to the budget [default: as "
            "for --starts].",
        ),
    ] = None,
    max_time: MaxTime = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder to write [default: runs/PROBLEM-ALGORITHM-seedSEED, of a robust run "
            "runs/PROBLEM-robust-ALGORITHM-seedSEED].",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
    ] = False,
    record: Annotated[
        bool, typer.Option("--record", help="Save every evaluation, in the folder's evaluations/.")
    ] = False,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Search the Pareto front of a problem and write it to a folder.

    The folder gets front.csv, front.npz (constraints of each solution), run.json (how to run it
    again) and front.html. Ctrl-C ends the run and keeps what was found; a second Ctrl-C does not
    wait for the end of the generation. Runs of the MGEO family write run.checkpoint: see
    `mgeo resume`. Parameters of an algorithm and their defaults: `mgeo algorithms NAME`.
    """
    from mgeo.plugins.problems import read_scenario
    from mgeo.runs.algorithms import default_algorithm
    from mgeo.runs.prepare import prepare
    from mgeo.store.run_folder import check_folder

    given, algorithm = algorithm, algorithm or default_algorithm(robust)
    # of a collection, coco:bbob/f1/d10/i1, and of a class, module:Class
    name = f"{problem}{'-robust' if robust else ''}-{algorithm}".replace(":", "-").replace("/", "-")
    folder = out or Path("runs", f"{name}-seed{seed}")
    with bad_input():
        parameters = options.parse_parameters(settings or [])
        if walkers is not None:
            parameters["n_walkers"] = walkers
        run = prepare(
            problem,
            parameters=parameters,
            options=read_scenario(problem, scenario, after=after, named=(problem,)),
            algorithm=given,
            evaluations=evaluations,
            seed=seed,
            robust=robust,
            starts=starts,
            polish=polish,
            record=record,
        )
        check_folder(folder, overwrite=overwrite)
    output = Output(quiet, json)
    if dry_run:
        from mgeo.cli.dry_run import describe_run

        describe_run(run, folder, output)
    else:
        from mgeo.cli.running import run_and_show

        raise typer.Exit(run_and_show(run, folder, output, max_time))


def resume(
    folder: options.RunFolder,
    evaluations: Annotated[
        int | None,
        typer.Option(min=1, help="New budget, counted from the beginning of the run."),
    ] = None,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="MODULE:CLASS",
            help="That of the run, where it is none by name: no file has a module imported.",
        ),
    ] = None,
    problem: options.Problem = None,
    max_time: MaxTime = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check/--no-check",
            help="Refuse other versions of the software, and a problem with other values.",
        ),
    ] = True,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Continue a run that was interrupted or killed, or make a finished one longer.

    The run continues from run.checkpoint in the folder exactly as if it had not stopped, and
    writes the same files. A run of another problem or of other versions is refused.
    """
    from mgeo.cli.running import run_and_show
    from mgeo.runs.prepare import resume_run

    with bad_input():
        run = resume_run(
            folder,
            evaluations=evaluations,
            algorithm=algorithm,
            problem=problem,
            check=check,
        )
    raise typer.Exit(run_and_show(run, folder, Output(quiet, json), max_time))
