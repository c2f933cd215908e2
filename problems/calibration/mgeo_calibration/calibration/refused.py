"""Telemetry of which no calibration comes, and all that was tested of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pandas as pd

from mgeo_calibration.calibration.model_tests import ModelTest, model_table, model_tests
from mgeo_calibration.calibration.questions import questions
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.fit import fit

#: By how much noise is taken to be larger where readings do not fit at all.
_WIDER = (5.0, 20.0, 80.0)


class CannotCalibrate(ValueError):
    """No attitude, or no estimate, follows from telemetry; the cause comes first, if one is seen.

    Attributes
    ----------
    checks : mapping of str to tuple of str
        See `diagnosis.checks`.
    model_tests : tuple of ModelTest
        Where these see nothing: of what the scenario says, with noise that is larger by
        `noise_factor`, if then an estimate follows.
    causes : tuple of str
        In words, the most certain first.
    """

    def __init__(
        self,
        error: str,
        checks: Mapping[str, tuple[str, ...]],
        batch: Batch | None,
        belief: Belief,
        gate: float,
    ) -> None:
        self.checks = checks
        self.causes = tuple(words for said in checks.values() for words in said)
        self.noise_factor: float = 1.0
        self.model_tests: tuple[ModelTest, ...] = ()
        if batch is not None and not self.causes:
            self.noise_factor, self.model_tests = _of_a_wide_fit(batch, belief, gate)
            self.causes = tuple(test.words for test in self.model_tests if test.named)
        super().__init__(f"{self.causes[0]} ({error})" if self.causes else error)

    def check_table(self) -> pd.DataFrame:
        """A row for each check that needs no attitude, and what it ``says``."""
        rows = {name: "; ".join(said) or "nothing" for name, said in self.checks.items()}
        return pd.DataFrame({"says": rows}).rename_axis("check")

    def model_table(self) -> pd.DataFrame:
        """As of a calibration."""
        return model_table(self.model_tests)


def _of_a_wide_fit(
    batch: Batch, belief: Belief, gate: float
) -> tuple[float, tuple[ModelTest, ...]]:
    """By how much noise has to be larger, and what is tested then."""
    for factor in _WIDER:
        try:
            solution = fit(replace(batch, noise=factor * batch.noise), belief, gate).solution
        except ValueError:
            continue
        asked = questions(solution, {})
        return factor, model_tests(solution, asked, len(asked), 1.0)[0]
    return _WIDER[-1], ()
