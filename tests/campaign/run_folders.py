"""Run folders that somebody has spoiled: run.json, front.csv, checkpoints and records."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from mgeo_attitude.plan import read_front

from mgeo import read_record
from mgeo.report import report_html
from mgeo.runs.resume import resume_run
from mgeo.store.run import RunConfiguration
from mgeo.store.run_folder import read_run

from .harness import Attempt, Box, kind
from .mutations import spoiled_arrays, spoiled_bytes, spoiled_table, spoiled_tree
from .templates import put

RESUME_WRITES = ("work/*/front.csv", "work/*/run.json", "work/*/front.html",
                 "work/*/run.checkpoint", "work/*/evaluations/*")  # fmt: skip


def spoil_json(box: Box, path: Path) -> None:
    """Another value, or other bytes."""
    if box.chance(0.75):
        tree = spoiled_tree(box, json.loads(path.read_text()))
        text = json.dumps(tree, ensure_ascii=box.chance(0.5))
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
    else:
        path.write_bytes(spoiled_bytes(box, path.read_bytes()))


def spoil_front(box: Box, path: Path) -> None:
    """Another cell, or other bytes."""
    content = path.read_bytes()
    path.write_bytes((spoiled_table if box.chance(0.75) else spoiled_bytes)(box, content))


def _spoil_run(box: Box, folder: Path) -> tuple[str, ...]:
    name = box.pick(["run.json", "front.csv"])
    (spoil_json if name == "run.json" else spoil_front)(box, folder / name)
    return ("run.json", "front.csv")


def _whole(run: Any) -> None:
    outcome = run.outcome
    assert outcome.X.shape == (len(outcome.F), len(outcome.variables))
    assert outcome.F.shape[1] == len(outcome.objectives)
    assert np.isfinite(outcome.X).all()
    assert np.isfinite(outcome.F).all()
    assert RunConfiguration(**run.configuration.model_dump()) == run.configuration
    f"{outcome.evaluations:,} {outcome.wall_time_s:.1f} {sum(outcome.failures.values())}"


@kind(weight=14)
def run_read(box: Box) -> Attempt:
    folder = put(box, "run")
    mentions = _spoil_run(box, folder)
    return Attempt(lambda: read_run(folder), mentions, sound=_whole)


@kind(weight=2)
def run_reported(box: Box) -> Attempt:
    folder = put(box, "run")
    _spoil_run(box, folder)
    return Attempt(["mgeo", "report", str(folder), "-q"], writes=("work/run/report.html",),
                   sound=lambda ran: _is_page(folder / "report.html"))  # fmt: skip


def _is_page(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.endswith("</html>\n")
    assert "<script>alert" not in text
    assert "<img src=x" not in text


@kind(weight=8)
def attitude_front_read(box: Box) -> Attempt:
    folder = put(box, "attitude")
    mentions = _spoil_run(box, folder)

    def action() -> Any:
        return read_front(folder).row(box.pick(["knee", "fastest", "best", 300.0]))

    return Attempt(action, mentions, sound=lambda row: None)


@kind(weight=0.4)
def attitude_plan_picked(box: Box) -> Attempt:
    folder = put(box, "attitude")
    mentions = _spoil_run(box, folder)
    pick = ["--pick", box.pick(["knee", "fastest", "best"])]
    out = box.pick(["plan.json", "plan.csv", "plan.aem"])
    return Attempt(["mgeo", "attitude", "export", str(folder), out, *pick], mentions,
                   writes=(f"work/{out}",))  # fmt: skip


@kind(weight=4)
def checkpoint_bytes(box: Box) -> Attempt:
    path = put(box, "begun") / "run.checkpoint"
    path.write_bytes(spoiled_bytes(box, path.read_bytes()))
    return Attempt(["mgeo", "resume", str(path.parent), "-q"], ("run.checkpoint",), RESUME_WRITES)


def spoil_checkpoint(box: Box, path: Path) -> None:
    """Another state, or other arrays."""
    with np.load(path) as archive:
        arrays = dict(archive)
    if box.chance(0.5):
        tree = spoiled_tree(box, json.loads(arrays["json"].tobytes()))
        text = json.dumps(tree).encode()
        arrays["json"] = np.frombuffer(text, dtype=np.uint8)
        body = _npz(arrays)
    else:
        body = spoiled_arrays(box, arrays)
    path.write_bytes(body)


def _npz(arrays: Any) -> bytes:
    content = io.BytesIO()
    np.savez(content, **arrays)
    return content.getvalue()


@kind(weight=10)
def checkpoint_content_read(box: Box) -> Attempt:
    path = put(box, "begun") / "run.checkpoint"
    spoil_checkpoint(box, path)
    return Attempt(lambda: resume_run(path.parent), ("run.checkpoint",))


@kind(weight=2)
def checkpoint_content_resumed(box: Box) -> Attempt:
    path = put(box, "begun") / "run.checkpoint"
    spoil_checkpoint(box, path)
    more = ["--evaluations", "24"] if box.chance(0.5) else []
    return Attempt(["mgeo", "resume", str(path.parent), "-q", *more], writes=RESUME_WRITES,
                   sound=lambda ran: _whole(read_run(path.parent)))  # fmt: skip


def spoil_record(box: Box, folder: Path) -> None:
    """Other bytes, or other arrays."""
    path = box.pick(sorted(folder.iterdir()))
    if box.chance(0.4):
        path.write_bytes(spoiled_bytes(box, path.read_bytes()))
    else:
        with np.load(path) as archive:
            path.write_bytes(spoiled_arrays(box, dict(archive)))


@kind(weight=10)
def record_read(box: Box) -> Attempt:
    folder = put(box, "run") / "evaluations"
    spoil_record(box, folder)

    def sound(table: Any) -> None:
        assert {"generation", "failed"} <= set(table.columns)
        assert len(table) == len(table.dropna(subset=["generation"]))

    return Attempt(lambda: read_record(folder), ("evaluations",), sound=sound)


@kind(weight=1)
def record_reported_or_resumed(box: Box) -> Attempt:
    folder = put(box, "run")
    spoil_record(box, folder / "evaluations")
    if box.chance(0.5):
        return Attempt(lambda: report_html(folder), ("evaluations",))
    return Attempt(["mgeo", "resume", str(folder), "--evaluations", "180", "-q"],
                   writes=RESUME_WRITES)  # fmt: skip
