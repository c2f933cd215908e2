"""Commands ``mgeo solve`` and ``mgeo resume``.

Modules that are slow to import are imported only for a run.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import convert_input_errors
from mgeo.terminal import Output

_SECONDS_PER_UNIT = {"s": 1.0, "m": 60.0, "h": 3600.0}


def _parse_duration(text: str) -> float:
    """Parse a duration, such as 90, 10m or 2h, and return it in seconds."""
    unit = text[-1:] if text[-1:] in _SECONDS_PER_UNIT else ""
    try:
        seconds = float(text.removesuffix(unit)) * _SECONDS_PER_UNIT.get(unit, 1.0)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < float("inf"):
        raise typer.BadParameter(f"{text!r}: expected a positive time, such as 90, 10m or 2h")
    return seconds


MaxTime = Annotated[
    float | None,
    typer.Option(
        metavar="TIME",
        parser=_parse_duration,
        help="End the run after this time: seconds, or 10m, 2h. `mgeo resume` continues the run.",
    ),
]


def solve(
    problem: Annotated[
        str,
        typer.Argument(
            help="Name from `mgeo problems`, a class as module:Class, or a test problem such as "
            "pymoo:zdt1.",
            autocompletion=options.complete_problems,
        ),
    ],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET",
            help="Options of the problem: a file, or the name of a preset.",
            autocompletion=options.complete_scenarios,
        ),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Start from an earlier result, such as a calibration, if the problem supports it. "
            "A scenario file then contains only the options that differ.",
        ),
    ] = None,
    robust: Annotated[
        bool,
        typer.Option(
            "--robust",
            help="Solve the robust variant of the problem, which has uncertain parameters, if "
            "there is one.",
        ),
    ] = False,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|MODULE:CLASS",
            help="Name from `mgeo algorithms`, or a class as module:Class [default: mgeo-directed; "
            "mgeo-staged with --robust].",
            autocompletion=options.complete_algorithms,
        ),
    ] = None,
    walkers: options.Walkers = None,
    settings: options.Settings = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Budget of evaluations [default: 5000 generations of one candidate per variable].",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random numbers.")] = 1,
    initial_designs: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Number of initial designs that the problem suggests [default: the recommendation "
            "of the problem; 0 with --robust, --evaluations, an algorithm or its parameters].",
        ),
    ] = None,
    refine: Annotated[
        bool | None,
        typer.Option(
            "--refine/--no-refine",
            help="Refine the front by a local search after the run, in addition to the budget "
            "[default: as for --initial-designs].",
        ),
    ] = None,
    max_time: MaxTime = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder to write [default: runs/PROBLEM-ALGORITHM-seedSEED; "
            "runs/PROBLEM-robust-ALGORITHM-seedSEED with --robust].",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
    ] = False,
    record: Annotated[
        bool, typer.Option("--record", help="Write every evaluation into DIR/evaluations.")
    ] = False,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Search for the Pareto front of a problem, and write it into a folder.

    The folder contains front.csv, front.npz (constraints of each solution), run.json (configuration
    and statistics) and front.html. Ctrl-C ends the run after the current generation and saves the
    results. A second Ctrl-C ends it at once. Algorithms of the MGEO family also write
    run.checkpoint for `mgeo resume`. `mgeo algorithms NAME` lists the parameters of an algorithm.
    """
    from mgeo.plugins.problems import read_scenario
    from mgeo.runs.algorithms import select_default_algorithm
    from mgeo.runs.prepare import prepare_run
    from mgeo.store.run_folder import check_folder

    algorithm_option, algorithm = algorithm, algorithm or select_default_algorithm(robust)
    # Names such as coco:bbob/f1/d10/i1 and module:Class are not valid folder names.
    name = f"{problem}{'-robust' if robust else ''}-{algorithm}".replace(":", "-").replace("/", "-")
    folder = out or Path("runs", f"{name}-seed{seed}")
    with convert_input_errors():
        parameters = options.parse_parameters(settings or [])
        if walkers is not None:
            parameters["n_walkers"] = walkers
        run = prepare_run(
            problem,
            parameters=parameters,
            options=read_scenario(problem, scenario, after=after, trusted_classes=(problem,)),
            algorithm=algorithm_option,
            evaluations=evaluations,
            seed=seed,
            robust=robust,
            initial_designs=initial_designs,
            refine=refine,
            record=record,
        )
        check_folder(folder, overwrite=overwrite)
    output = Output(quiet, json)
    if dry_run:
        from mgeo.cli.dry_run import print_run_size

        print_run_size(run, folder, output)
    else:
        from mgeo.cli.execution import execute_run

        raise typer.Exit(execute_run(run, folder, output, max_time))


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
            help="Class of the algorithm of the run, required if the algorithm has no name.",
        ),
    ] = None,
    problem: options.Problem = None,
    max_time: MaxTime = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check/--no-check",
            help="Refuse to resume if the software versions or the values of the problem differ.",
        ),
    ] = True,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Continue an interrupted run, or extend a finished one.

    The run continues from run.checkpoint in the folder, and gives the same results as an
    uninterrupted run. A run is refused if its problem or its software versions differ from the
    installed ones.
    """
    from mgeo.cli.execution import execute_run
    from mgeo.runs.prepare import resume_run

    with convert_input_errors():
        run = resume_run(
            folder,
            evaluations=evaluations,
            algorithm=algorithm,
            problem=problem,
            check=check,
        )
    raise typer.Exit(execute_run(run, folder, Output(quiet, json), max_time))
