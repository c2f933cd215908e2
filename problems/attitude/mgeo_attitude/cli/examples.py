"""Examples of commands, for their help and for the tests that read them."""

from __future__ import annotations

from collections.abc import Mapping

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "show": (
        "mgeo-attitude show runs/attitude-mgeo-real-seed1",
        "mgeo-attitude show runs/attitude-mgeo-real-seed1 --time 3000 --html plan.html",
        "mgeo-attitude show plan.json --json | jq .t_end_s",
    ),
    "verify": (
        "mgeo-attitude verify plan.json --runs 500",
        "mgeo-attitude verify runs/first --pick best --out runs/first/verification-best.json",
    ),
    "schema": ("mgeo-attitude schema > scenario.schema.json",),
    "export": (
        "mgeo-attitude export runs/first plan.json plan.csv --pick fastest",
        "mgeo-attitude export plan.json plan.aem --object-name SAT --object-id 2021-015A",
    ),
}


def epilog(command: str) -> str:
    """The end of a command's help."""
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in EXAMPLES[command])])
