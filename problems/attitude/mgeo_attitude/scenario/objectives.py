"""Check of the objectives that a scenario names; `criteria.objectives` computes them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from mgeo_attitude.criteria.objectives import OBJECTIVES, TRACE_OF, blocks_of
from mgeo_attitude.settings.errors import InvalidValue, expect_unique, known_names


def check_objectives(names: Sequence[str], blocks: Collection[str], required: bool) -> None:
    """Refuse, with an InvalidValue, names that do not say what to minimize.

    They may refer to the `blocks` of the state and, if any are `required`, to required 1-sigmas.
    """
    expect_unique("objectives[{}]", names)
    for i, name in enumerate(names):
        key = f"objectives[{i}]"
        unknown = [block for block in blocks_of(name) if block not in blocks]
        if unknown:
            known = known_names(unknown[0], blocks)
            raise InvalidValue(key, name, f"unknown state block {unknown[0]!r}{known}")
        if name not in OBJECTIVES and not blocks_of(name):
            known = known_names(name, [*OBJECTIVES, f"{TRACE_OF}BLOCK"])
            raise InvalidValue(key, name, f"unknown objective{known}")
        if name == "t_required" and not required:
            raise InvalidValue(key, name, "the scenario has no required_sigma")
