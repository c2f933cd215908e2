"""Examples of commands, for their help and for the tests that read them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

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
    ),
    "problems": ("mgeo problems", "mgeo problems --json | jq -r .problems[].name"),
    "algorithms": ("mgeo algorithms", "mgeo algorithms mgeo-directed"),
    "study": (
        "mgeo study table3.toml --seeds 3 --evaluations 3600",
        "mgeo study table3.toml --dry-run",
        "mgeo study table3.toml --cluster tcp://HOST:8786",
    ),
    "schema": ("mgeo schema study | tee study.schema.json",),
}


def epilog(command: str, examples: Mapping[str, Iterable[str]] = EXAMPLES) -> str:
    """The end of a command's help."""
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in examples[command])])
