"""Examples of commands, for their help and for the tests that read them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

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
    "new": ("mgeo new problem my-beam", "mgeo new problem my-beam --out plugins/my-beam"),
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
