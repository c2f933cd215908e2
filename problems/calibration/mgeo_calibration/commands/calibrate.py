"""``mgeo attitude calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from mgeo_attitude.commands.files import Picked, load_plan
from mgeo_attitude.environment.times import utc_text
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.scenario import Scenario

from mgeo.store.atomic import check_writable, lock, write_file
from mgeo.terminal import Output, note, plain, rows, titled
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.diagnosis import CannotCalibrate
from mgeo_calibration.calibration.document import document, to_json
from mgeo_calibration.calibration.recalibration import compare_calibrations, describe_noise

#: Files of a folder, in the order of writing.
FILES = ("calibration.csv", "attitude.csv", "calibration.html", "calibration.json")


def scenario_of(text: str | None, plan: ManeuverPlan | None) -> Scenario:
    """Return the named scenario, or that of the plan.

    Raises
    ------
    OSError, ValueError, TypeError
        If neither is given, the scenario cannot be read, or its epoch differs from the plan's:
        times of telemetry count from the epoch.

    Warns
    -----
    Implausible
        For an implausible value in a file.
    """
    if text is None:
        if plan is None:
            raise ValueError("--scenario FILE.toml|PRESET: expected it, or --plan, which has one")
        return plan.scenario
    path = Path(text)
    if path.suffix != ".toml" and len(path.parts) == 1:
        scenario = Scenario.from_dict({"preset": text})
    elif path.is_file():
        scenario = Scenario.from_toml(path)
    else:
        raise FileNotFoundError(f"there is no scenario file {path}")
    if plan is not None and plan.scenario.epoch != scenario.epoch:
        raise ValueError(
            f"--scenario {text}: its epoch is {utc_text(scenario.epoch, 0.0)}; expected that of "
            f"the plan, {utc_text(plan.scenario.epoch, 0.0)} (taken where there is no --scenario)"
        )
    return scenario


def flown_plan(
    source: Path | None, pick: str | None, time: float | None, solution: int | None
) -> Picked | None:
    """Return the named plan; raises as `load_plan`."""
    if source is not None:
        return load_plan(source, pick, time, solution)
    for flag, value in {"--pick": pick, "--time": time, "--solution": solution}.items():
        if value is not None:
            raise ValueError(f"{flag}: expected with --plan RUN, of which it picks a solution")
    return None


def check_folder(folder: Path, overwrite: bool) -> None:
    """Raise an OSError for a folder in which the files could not or must not be written."""
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{folder} is no folder: choose another name")
    check_writable(folder)
    for path in (folder / name for name in FILES):
        if path.exists() and not overwrite:
            raise FileExistsError(f"{path} exists: choose another name or allow --overwrite")


def write_calibration(
    calibration: Calibration, promised: pd.DataFrame | None, folder: Path
) -> list[str]:
    """Write `FILES` into a folder, without attitudes if there are none, and return the paths."""
    from mgeo_calibration.calibration.report import report_html

    attitude = calibration.attitude if calibration.history is not None else None
    texts = (
        calibration.table().to_csv(index=False, lineterminator="\n"),
        attitude.to_csv(index=False, lineterminator="\n") if attitude is not None else None,
        report_html(calibration, promised),
        to_json(calibration),
    )
    folder.mkdir(parents=True, exist_ok=True)
    written = {folder / name: text for name, text in zip(FILES, texts, strict=True) if text}
    with lock(folder):
        for path, text in written.items():
            write_file(path, text.encode())
    return list(map(str, written))


def print_calibration(
    calibration: Calibration, promised: pd.DataFrame | None, picked: Picked | None, output: Output
) -> None:
    """Print estimates, tests and conclusion."""
    table = calibration.table().set_index("block")
    output.print(
        f"scenario {calibration.scenario.name}: calibrated at {calibration.time:.6g} s, "
        f"{calibration.utc} UTC",
        *titled("Errors of gyro and sensors", table),
        *titled("Innovations", calibration.test_table().T),
        note("before, after: rms of the residuals without and with the calibration"),
    )
    if promised is not None and picked is not None:
        time = f"{promised.attrs['time_s']:.6g} s"
        time += promised.attrs["flown"]
        title = f"1-sigma that the plan predicted for {time}, and achieved: {picked.name}"
        output.print(*titled(title, promised), *picked.doubts())
    for told in calibration.notes:
        output.print(note(told))
    output.print("", plain(calibration.conclusion, "bold"))


def report_refusal(refused: CannotCalibrate, output: Output) -> None:
    """Print the checks of telemetry that cannot be calibrated."""
    table = refused.check_table()
    output.print(*titled("Without any attitude", table))
    output.result({"refused": str(refused), "checks": rows(table)})


def print_tests(calibration: Calibration, output: Output) -> None:
    """Print all tests of the model and of the prior, and the causes found without attitude."""
    columns = ["says", "chi_square", "freedom", "p", "named", "key"]
    output.print(*titled("Beside what the scenario says", calibration.model_table()[columns]))
    output.print(*titled("Estimate and prior", calibration.prior_table()))
    for cause in calibration.causes:
        output.print(f"seen without any attitude: {cause}")


def print_comparison(first: Calibration, second: Calibration, output: Output) -> None:
    """Print the difference between calibrations with and without added states or noise."""
    output.print(
        *titled("With and without what was added", compare_calibrations(first, second)),
        note("moved: by how many of its 1-sigmas"),
        note(f"noise: {describe_noise(second)}"),
        note(f"without: {first.conclusion}"),
    )


def calibration_document(
    calibration: Calibration, promised: pd.DataFrame | None, files: list[str]
) -> dict[str, Any]:
    """Return the content of calibration.json, the comparison with a plan, and the files."""
    compared = [] if promised is None else rows(promised)
    return {
        **document(calibration),
        "supported": calibration.supported,
        "promised": compared,
        "files": files,
    }
