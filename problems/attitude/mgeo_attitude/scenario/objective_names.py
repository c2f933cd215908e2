"""Names of what can be minimized; `mgeo_attitude.criteria.objectives` computes it."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from mgeo_attitude.fields import InvalidValue, known_names

#: The paper's two, equation (5).
PAPER = ("t_end", "trace")

#: Begins the name of the trace over some of the state's blocks: ``trace:attitude,gyro.bias``.
TRACE_OF = "trace:"

#: All others.
NAMES = (
    *PAPER,
    "normalized_trace",
    "log_det",
    "max_eigenvalue",
    "t_required",
    "angle",
    "rate_change",
)


def blocks_of(name: str) -> list[str]:
    """The blocks in ``trace:BLOCK,BLOCK...``; none in another name."""
    return name.removeprefix(TRACE_OF).split(",") if name.startswith(TRACE_OF) else []


def check_objectives(names: Sequence[str], blocks: Collection[str], required: bool) -> None:
    """Refuse, with an InvalidValue, names that do not say what to minimize.

    They may refer to the `blocks` of the state and, if any are `required`, to required 1-sigmas.
    """
    if not names:
        raise InvalidValue("objectives", [], "expected at least one name")
    for i, name in enumerate(names):
        key = f"objectives[{i}]"
        if name in names[:i]:
            raise InvalidValue(key, name, "expected each one once")
        unknown = [block for block in blocks_of(name) if block not in blocks]
        if unknown:
            known = known_names(unknown[0], blocks)
            raise InvalidValue(key, name, f"unknown state block {unknown[0]!r}{known}")
        if name not in NAMES and not blocks_of(name):
            known = known_names(name, [*NAMES, f"{TRACE_OF}BLOCK"])
            raise InvalidValue(key, name, f"unknown objective{known}")
        if name == "t_required" and not required:
            raise InvalidValue(key, name, "the scenario has no required_sigma")
