"""Command lines that nobody should type, and that somebody will."""

from __future__ import annotations

from pathlib import Path

from .harness import Attempt, Box, kind
from .mutations import ESCAPES
from .templates import put

TEXTS = ["", " ", "x", "-1", "0", "1.5", "nan", "inf", "1e999", "99999999999999999999999", "None",
         "two\nlines", ESCAPES, "é" * 300, "\udcff", "../x", "'\"", "{}", "%s", "x" * 9000, "--",
         "=", ",", "1,", "1,x", "٣"]  # fmt: skip

_SOLVE: dict[str, list[str]] = {
    "--sigma": ["0.1,0.2", "1," * 500 + "1", "-0.0", "1e-320"],
    "--tau": ["a-geo1", "a-geo3", "1e308", "-2"],
    "--walkers": ["1000000000000000000", "3"],
    "--population": ["3", "1000000000000000000"],
    "--perturbation": ["absolut", "RANGE"],
    "--set": ["bits=0", "bits=100", "bits=1000000000000", "a=b", "patience=-1", "patience=nan",
              "bounds=reflect", "bounds=x", "restart=x", "__class__=1", "sigma=1", "bits=", "=1",
              "n_walkers=3", "bits=8", "bits=1,2"],
    "--seed": ["1", "1000000000000000000000000000000"],
    "--algorithm": ["nsga2", "mgeo-var", "NSGA2", "moead", "mgeo_real", "ctaea", "nsde", "rvea"],
    "--scenario": ["paper", "none.toml", ".", "/", "..", "/dev/null", "../elsewhere/precious.txt",
                   "../elsewhere", "\x00.toml", "x" * 300 + ".toml"],
    "--out": ["made/deeper", "../elsewhere/../made"],
    "--evaluations": ["1", "8"],
}  # fmt: skip


@kind(weight=5)
def solve_arguments(box: Box) -> Attempt:
    """A short run with one or two arguments that are as likely bad as good."""
    problem = box.pick(["zdt1", "cantilever"])
    if box.chance(0.1):
        problem = box.pick([*TEXTS, "zdt", "ZDT1", "pymoo:zdt1", "zdt1 "])
    # the last of several counts: 1,000 walkers would take their time
    arguments = ["mgeo", "solve", "--walkers", "2", "--evaluations", "8", "--out", "made", "-q"]
    if box.chance(0.5):  # the published algorithm, which has the most flags
        arguments += ["--algorithm", "mgeo-real"]
    for _ in range(1 if box.chance(0.6) else 2):
        flag = box.pick(list(_SOLVE))
        value = box.pick(_SOLVE[flag] if box.chance(0.5) else TEXTS)
        if flag in ("--walkers", "--evaluations") and value.startswith("9"):
            value = "0"
        arguments += [flag, value] if box.chance(0.8) else [f"{flag}={value}"]
    if "--walkers" in arguments[9:] or any(a in ("nsga2", "moead") for a in arguments):
        arguments = [a for i, a in enumerate(arguments) if i not in (2, 3)]
    if box.chance(0.1):
        arguments.insert(int(box.rng.integers(2, len(arguments))), box.pick(TEXTS))
    return Attempt([*arguments, "--", problem], writes=("work/*", "made/*", "x/*"))


@kind(weight=2)
def other_arguments(box: Box) -> Attempt:
    folder = put(box, "run")
    put(box, "plans")
    value = box.pick([text for text in TEXTS if not text.startswith("9")])  # as a budget it is good
    plan = "plans/plan.json"
    return Attempt(
        box.pick([
            ["mgeo", "resume", str(folder), "--evaluations", value, "-q"],
            ["mgeo", "resume", str(folder), "--generations", value, "-q"],
            ["mgeo", "resume", str(folder), value],
            ["mgeo", "report", str(folder), value],
            ["mgeo", "study", "none.toml", "--jobs", value],
            ["mgeo", "study", "none.toml", "--cluster", value, "--seeds", "0"],
            ["mgeo", value],
            ["mgeo", "problems", value],
            ["mgeo", "attitude", "show", "plans/attitude", "--pick", value],
            ["mgeo", "attitude", "show", "plans/attitude", "--time",
             box.pick(["nan", "inf", "x", ""])],
            ["mgeo", "attitude", "show", plan, "--pick", value],
            ["mgeo", "attitude", "verify", plan, "--walkers", box.pick(["0", "1", "-1", "x", ""])],
            ["mgeo", "attitude", "verify", plan, "--seed", box.pick(["-1", "x", "", "1.5"])],
            ["mgeo", "attitude", "export", plan, "a.aem", "--object-name", value],
            ["mgeo", "attitude", "export", plan, "a.aem", "--originator", value],
            ["mgeo", "attitude", "export", plan, "a.aem", "--aem-version", value],
            ["mgeo", "attitude", "export", plan, "a.aem", "--spacing",
             box.pick(["0", "-1", "nan", "inf", "x", "1e-300", "1e308"])],
            ["mgeo", "attitude", "export", plan, value],
            ["mgeo", "attitude", "export", plan, f"{value}.csv"],
            ["mgeo", "attitude", "export", plan, "a.csv", "a.csv"],
            ["mgeo", "attitude", "export", plan, "a.csv", f"a.{value}"],
        ]),
        writes=("work/run/*", "work/a.*", "work/*.csv", "x.csv", "work/plans/a.*"),
    )  # fmt: skip


@kind(weight=1)
def sound_command(box: Box) -> Attempt:
    """Nothing is wrong: what refuses everything must not look good."""
    put(box, "run")
    Path("load.toml").write_text("load = 700.0\n")
    actions = [
        ["mgeo", "resume", "run", "--evaluations", "180"],
        ["mgeo", "solve", "cantilever", "--walkers", "2", "--evaluations", "8", "--out", "made"],
        ["mgeo", "problems"],
        ["mgeo", "report", "run"],
    ]

    def sound(ran: object) -> None:
        assert getattr(ran, "exit_code", None) == 0

    return Attempt(box.pick(actions), writes=("work/*",), codes=(0,), sound=sound)
