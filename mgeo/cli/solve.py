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
    """Convert a duration such as 90, 10m or 2h to seconds."""
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
        rich_help_panel="Search",
        help="End the run after this time, such as 90 (seconds), 10m or 2h. `mgeo resume` "
        "continues the run.",
    ),
]


def solve(
    problem: Annotated[
        str,
        typer.Argument(
            metavar="PROBLEM",
            help="Problem to solve: a name from `mgeo problems`, a test problem such as "
            "pymoo:zdt1, or a class as MODULE:CLASS.",
            autocompletion=options.complete_problems,
        ),
    ],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET",
            rich_help_panel="Problem",
            help="Scenario: a file with the options of the problem, or the name of a preset.",
            autocompletion=options.complete_scenarios,
        ),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            rich_help_panel="Problem",
            help="Earlier result, such as a calibration, if the problem supports it. Its accuracy "
            "becomes the initial accuracy. A scenario file then contains only the options that "
            "differ from those of the earlier result.",
        ),
    ] = None,
    robust: Annotated[
        bool,
        typer.Option(
            "--robust",
            rich_help_panel="Problem",
            help="Search for robust solutions, whose objectives include random errors and are not "
            "exceeded in about 90 % of new Monte Carlo runs, if the problem supports it.",
        ),
    ] = False,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|MODULE:CLASS",
            rich_help_panel="Search",
            help="Algorithm: a name from `mgeo algorithms`, or a class [default: mgeo-directed; "
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
            metavar="N",
            rich_help_panel="Search",
            help="Number of evaluations of the problem, rounded up to whole generations [default: "
            "`--dry-run` prints it].",
        ),
    ] = None,
    seed: Annotated[
        int,
        typer.Option(
            min=0,
            metavar="N",
            rich_help_panel="Search",
            help="Seed of all random numbers. Equal seeds give equal results.",
        ),
    ] = 1,
    initial_designs: Annotated[
        int | None,
        typer.Option(
            min=0,
            metavar="N",
            rich_help_panel="Search",
            help="Number of initial designs that the problem suggests, included in --evaluations "
            "[default: chosen by the problem; 0 if --robust, --evaluations, --algorithm, "
            "--walkers or --set is given].",
        ),
    ] = None,
    refine: Annotated[
        bool | None,
        typer.Option(
            "--refine/--no-refine",
            rich_help_panel="Search",
            help="Refine the front by a local search after all evaluations [default: chosen by "
            "the problem; off if --robust, --evaluations, --algorithm, --walkers or --set is "
            "given].",
        ),
    ] = None,
    max_time: MaxTime = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            rich_help_panel="Output",
            help="Folder to write [default: runs/PROBLEM-ALGORITHM-seedN; "
            "runs/PROBLEM-robust-ALGORITHM-seedN with --robust].",
        ),
    ] = None,
    overwrite: Annotated[
        bool,
        typer.Option(
            "--overwrite", rich_help_panel="Output", help="Replace the run in an existing folder."
        ),
    ] = False,
    record: Annotated[
        bool,
        typer.Option(
            "--record",
            rich_help_panel="Output",
            help="Write every evaluation into DIR/evaluations.",
        ),
    ] = False,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Search for the Pareto front of a problem, and write it into a folder.

    The folder contains the solutions (front.csv, front.npz), the configuration (run.json), a figure
    (front.html) and, for algorithms of the MGEO family, a checkpoint for `mgeo resume`. Ctrl-C ends
    the run after the current generation and saves the results; a second Ctrl-C ends it at once.
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
            scenario_file=scenario if scenario and Path(scenario).is_file() else None,
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
        typer.Option(
            min=1,
            metavar="N",
            rich_help_panel="Search",
            help="New number of evaluations, counted from the beginning of the run.",
        ),
    ] = None,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="MODULE:CLASS",
            help="Class of the algorithm. Required if the run was made with MODULE:CLASS.",
        ),
    ] = None,
    problem: options.Problem = None,
    max_time: MaxTime = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check/--no-check",
            help="Refuse to resume if the software versions or the values of the problem differ "
            "[default: --check].",
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
