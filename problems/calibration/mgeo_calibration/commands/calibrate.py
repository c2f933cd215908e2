"""Input, output and result document of the command ``mgeo attitude calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from mgeo_attitude.commands.files import SelectedPlan, load_plan
from mgeo_attitude.environment.times import format_instant
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.scenario import Scenario

from mgeo.store.atomic import check_writable, lock_folder, write_file
from mgeo.terminal import Output, build_titled_table, escape_text, format_note, to_records
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.diagnosis import CalibrationError
from mgeo_calibration.calibration.document import build_document, to_json
from mgeo_calibration.calibration.recalibration import compare_calibrations, describe_noise

#: Files of the output folder, in the order of writing.
FILES = ("calibration.csv", "attitude.csv", "calibration.html", "calibration.json")


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
    predicted: pd.DataFrame | None,
    picked: SelectedPlan | None,
    output: Output,
) -> None:
    """Print the estimates, innovation tests, notes and conclusion of a calibration and, if a plan
    is given, the comparison with the plan.
    """
    table = calibration.build_table().set_index("block")
    output.print(
        f"scenario {calibration.scenario.name}: calibrated at {calibration.time:.6g} s, "
        f"{calibration.utc} UTC",
        *build_titled_table("Calibration parameters", table),
        *build_titled_table("Innovations", calibration.build_sensor_test_table().T),
        format_note("before, after: rms of the residuals without and with the calibration"),
    )
    if predicted is not None and picked is not None:
        time = f"{predicted.attrs['time_s']:.6g} s"
        time += predicted.attrs["motion"]
        title = f"1-sigma at {time}, predicted by the plan and achieved: {picked.name}"
        output.print(*build_titled_table(title, predicted), *picked.list_warnings())
    for text in calibration.notes:
        output.print(format_note(text))
    output.print("", escape_text(calibration.conclusion, "bold"))


def print_checks(error: CalibrationError, output: Output) -> None:
    """Print the findings of the attitude-independent checks after a calibration has failed."""
    table = error.build_check_table()
    output.print(*build_titled_table("Attitude-independent checks", table))
    output.print_document({"error": str(error), "checks": to_records(table)})


def print_tests(calibration: Calibration, output: Output) -> None:
    """Print the results of the tests for unmodeled errors, the comparison of the estimate with the
    prior, and the faults in the data.
    """
    columns = ["description", "chi_square", "degrees_of_freedom", "p", "is_selected", "key"]
    output.print(
        *build_titled_table(
            "Errors outside the scenario's model", calibration.build_model_test_table()[columns]
        )
    )
    output.print(*build_titled_table("Estimate and prior", calibration.build_prior_test_table()))
    for fault in calibration.data_faults:
        output.print(f"fault in the data: {fault}")


def print_comparison(first: Calibration, second: Calibration, output: Output) -> None:
    output.print(
        *build_titled_table("With and without the additions", compare_calibrations(first, second)),
        format_note("change / sigma: change of the estimate in units of its 1-sigma"),
        format_note(f"noise: {describe_noise(second)}"),
        format_note(f"without: {first.conclusion}"),
    )


def build_calibration_document(
    calibration: Calibration, predicted: pd.DataFrame | None, files: list[str]
) -> dict[str, Any]:
    """Return a calibration as a JSON-serializable dict, with its comparison to a plan and the list
    of written files.
    """
    compared = [] if predicted is None else to_records(predicted)
    return {
        **build_document(calibration),
        "consistent": calibration.is_consistent,
        "predicted": compared,
        "files": files,
    }
