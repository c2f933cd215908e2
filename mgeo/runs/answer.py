"""What a run comes to, in one line: the solution that a person would look at first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mgeo.plugins import protocol
from mgeo.runs.limits import nearest_kept, told
from mgeo.runs.representative import default_solution

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.store.run import Outcome


@dataclass(frozen=True)
class Answer:
    """A solution by its number, of how many, why this one, and what it is worth.

    Attributes
    ----------
    exceeded
        Limits of which the problem tells that it exceeds them, though it keeps all constraints.
    instead
        Then the nearest solution that exceeds none, by its number, if one is found.
    """

    solution: int
    count: int
    label: str
    text: str
    exceeded: tuple[str, ...] = ()
    instead: int | None = None

    def __str__(self) -> str:
        said = f"solution {self.solution} of {self.count:,}, {self.label}: {self.text}"
        if not self.exceeded:
            return said
        other = "" if self.instead is None else f"; solution {self.instead} keeps all limits"
        return f"{said}; BUT {'; '.join(self.exceeded)}{other}"


def answer(problem: Problem, outcome: Outcome) -> Answer | None:
    """The `default_solution` in the problem's words, or else its objectives; None of no front."""
    if not len(outcome.F):
        return None
    shown = default_solution(problem, outcome.F)
    chosen = outcome.X[[shown.row]]
    lines = protocol.answers(problem, chosen)
    if lines is None:
        pairs = zip(outcome.objectives, outcome.F[shown.row], strict=True)
        lines = [", ".join(f"{name} {value:.5g}" for name, value in pairs)]
    known = told(problem, chosen) or [[]]
    exceeded = tuple(str(limit) for limit in known[0] if not limit.kept)
    instead = nearest_kept(problem, outcome.X, shown.row) if exceeded else None
    return Answer(shown.row, len(outcome.F), shown.label, lines[0], exceeded, instead)
