"""Input, output and result document of the command ``mgeo attitude calibrate``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
from mgeo_attitude.commands.files import SelectedPlan, load_plan
from mgeo_attitude.environment.times import format_instant
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.scenario import Scenario

from mgeo._text import format_duration
from mgeo.plugins.review import Section, build_records
from mgeo.store.atomic import check_writable, lock_folder, write_file
from mgeo.terminal import Output
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.diagnosis import CalibrationError
from mgeo_calibration.calibration.document import build_document, summarize, to_json
from mgeo_calibration.calibration.sections import (
    build_detail_sections,
    build_recalibration_section,
    build_summary_sections,
    describe_requirements,
)

if TYPE_CHECKING:
    from mgeo_calibration.documents import CalibrationOutput, RefusalDocument

    pass

#: Files of the output folder and their contents, in the order of writing.
FILES = {
    "calibration.csv": "calibration parameters",
    "attitude.csv": "attitude at every sample",
    "calibration.html": "report with figures",
    "calibration.json": "all results, for programs and for --after",
}


def select_scenario(text: str | None, plan: ManeuverPlan | None) -> Scenario:
    """Return the scenario that the option --scenario names, a file or a preset. Without this
    option, return the scenario of the plan.

    Raises
    ------
    OSError, ValueError, TypeError
        If both are missing, the scenario cannot be read, or its epoch differs from the epoch of the
        plan, which is the origin of telemetry times.

    Warns
    -----
    ImplausibleValue
        If a value in the file is implausible.
    """
    if text is None:
        if plan is None:
            raise ValueError("--scenario FILE.toml|PRESET: expected this option or --plan")
        return plan.scenario
    path = Path(text)
    if path.suffix != ".toml" and len(path.parts) == 1:
        scenario = Scenario.from_dict({"preset": text})
    elif path.is_file():
        scenario = Scenario.from_toml(path)
    else:
        raise FileNotFoundError(f"--scenario {path}: expected an existing file or a preset")
    if plan is not None and plan.scenario.epoch != scenario.epoch:
        raise ValueError(
            f"--scenario {text}: the epoch is {format_instant(scenario.epoch, 0.0)}; expected "
            f"the epoch of the plan, {format_instant(plan.scenario.epoch, 0.0)}. Without "
            "--scenario, the scenario of the plan is used"
        )
    return scenario


def load_optional_plan(
    source: Path | None, pick: str | None, time: float | None, solution: int | None
) -> SelectedPlan | None:
    """Load the plan that the option --plan names, or return None without this option.

    Raises
    ------
    OSError, ValueError, TypeError
        As `load_plan`, or if an option that selects a solution is given without --plan.
    """
    if source is not None:
        return load_plan(source, pick, time, solution)
    for flag, value in {"--pick": pick, "--time": time, "--solution": solution}.items():
        if value is not None:
            raise ValueError(f"{flag}: expected with --plan RUN, to select a solution of the run")
    return None


def validate_folder(folder: Path, overwrite: bool) -> None:
    """Raise OSError if an output folder is not writable, or if it contains output files that must
    not be overwritten.
    """
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{folder} is not a folder: choose another name")
    check_writable(folder)
    for path in (folder / name for name in FILES):
        if path.exists() and not overwrite:
            raise FileExistsError(f"{path} exists: choose another folder or use --overwrite")


def write_calibration(
    calibration: Calibration, predicted: pd.DataFrame | None, folder: Path
) -> list[str]:
    """Write the tables, the report and the JSON document of a calibration to a folder, and return
    the paths of the written files.
    """
    from mgeo_calibration.calibration.report import build_report

    attitude = calibration.attitude if calibration.history is not None else None
    texts = (
        calibration.build_table().to_csv(index=False, lineterminator="\n"),
        attitude.to_csv(index=False, lineterminator="\n") if attitude is not None else None,
        build_report(calibration, predicted),
        to_json(calibration),
    )
    folder.mkdir(parents=True, exist_ok=True)
    written = {folder / name: text for name, text in zip(FILES, texts, strict=True) if text}
    with lock_folder(folder):
        for path, text in written.items():
            write_file(path, text.encode())
    return list(map(str, written))


def print_calibration(
    calibration: Calibration,
    first: Calibration,
    predicted: pd.DataFrame | None,
    files: Sequence[str],
    output: Output,
    *,
    has_details: bool,
) -> None:
    """Print the verdict, parameters, tests and findings of a calibration, the written files and the
    next command.

    Parameters
    ----------
    calibration : Calibration
    first : Calibration
        Calibration before the repetition with more states; equal to `calibration` if there is no
        repetition.
    predicted : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    files : sequence of str
        Written files.
    output : Output
    has_details : bool
        Whether to print every axis and every test, too.
    """
    sections = build_summary_sections(calibration, predicted)
    if first is not calibration:
        sections.append(build_recalibration_section(first, calibration))
    if has_details:
        sections += build_detail_sections(calibration, predicted)
    use = "Use the calibration parameters below." if calibration.is_consistent else ""
    sentences = calibration.conclusion, use, describe_requirements(calibration)
    output.print_title(" ".join(filter(None, sentences)))
    output.print_text(
        f"Estimates at the last sample, {calibration.utc[:19]} UTC, "
        f"{format_duration(calibration.time)} after the epoch.",
        f"Attitude accuracy: {calibration.attitude_sigma_deg:.2g} deg (1-sigma, worst body axis).",
        "",
    )
    output.print_sections(*sections)
    output.print_files({file: FILES[Path(file).name] for file in files})
    commands = {} if has_details else {"Print every axis and test": "add --all"}
    if not files:
        commands["Write results and report"] = "add --out DIR"
    elif calibration.is_consistent:
        commands["Plan further maneuvers"] = f"mgeo solve attitude --after {files[-1]}"
    output.print_commands(commands)


def print_checks(error: CalibrationError, output: Output) -> None:
    """Print the findings of the attitude-independent checks after a calibration has failed."""
    lines = [
        f"- {name}: {'; '.join(findings) or 'passed'}." for name, findings in error.checks.items()
    ]
    output.print_sections(Section("Checks of the telemetry", lines=tuple(lines)))
    checks = {name: list(findings) for name, findings in error.checks.items()}
    document: RefusalDocument = {"error": str(error), "checks": checks}
    output.print_document(document)


def build_calibration_document(
    calibration: Calibration, predicted: pd.DataFrame | None, files: list[str]
) -> dict[str, Any]:
    """Return a calibration as a JSON-serializable dict, the verdict first, with its comparison to a
    plan and the list of written files.
    """
    entries: CalibrationOutput = {
        "predicted": [] if predicted is None else build_records(predicted),
        "files": files,
    }
    return {**summarize(calibration), **entries, **build_document(calibration)}
