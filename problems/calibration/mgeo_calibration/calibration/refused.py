"""Telemetry of which no calibration comes, and all that was tested of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.calibration.agreement import MOST_REJECTED, tests_table
from mgeo_calibration.calibration.model_tests import ModelTest, model_tests
from mgeo_calibration.calibration.questions import channels_of, questions
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.fit import fit
from mgeo_calibration.estimation.residuals import filtered
from mgeo_calibration.telemetry.telemetry import Telemetry

#: By how much noise is taken to be larger where readings do not fit at all.
_WIDER = (5.0, 20.0, 80.0)


def checks(
    scenario: Scenario, telemetry: Telemetry, data: Batch | None
) -> dict[str, tuple[str, ...]]:
    """What is seen without any attitude, in words, by what is looked at; the most certain first.

    Parameters
    ----------
    data : Batch, optional
        What was made of telemetry, if it could be.
    """
    from mgeo_calibration.estimation.axes import axes_causes
    from mgeo_calibration.telemetry.checks import channel_causes
    from mgeo_calibration.telemetry.clocks import clock_causes

    return {
        "numbers": tuple(channel_causes(telemetry)),
        "times": tuple(clock_causes(scenario, telemetry)),
        "axes": () if data is None else tuple(axes_causes(data)),
    }


def causes(scenario: Scenario, telemetry: Telemetry, data: Batch | None) -> tuple[str, ...]:
    """All that `checks` say."""
    found = checks(scenario, telemetry, data)
    return tuple(words for said in found.values() for words in said)


class CannotCalibrate(ValueError):
    """No attitude, or no estimate, follows from telemetry; the cause comes first, if one is seen.

    Attributes
    ----------
    checks : mapping of str to tuple of str
        See `checks`.
    model_tests : tuple of ModelTest
        Where these see nothing: of what the scenario says, with noise that is larger by
        `noise_factor`, if then an estimate follows.
    causes : tuple of str
        In words, the most certain first.
    """

    def __init__(
        self,
        message: str,
        checks: Mapping[str, tuple[str, ...]] | None = None,
        tested: tuple[float, tuple[ModelTest, ...]] = (1.0, ()),
        causes: tuple[str, ...] = (),
    ) -> None:
        # the message alone is enough: pickles begin with it
        super().__init__(message)
        self.checks = checks or {}
        self.noise_factor, self.model_tests = tested
        self.causes = causes

    @classmethod
    def of(
        cls,
        error: str,
        checks: Mapping[str, tuple[str, ...]],
        batch: Batch | None,
        belief: Belief,
        gate: float,
        telemetry: Telemetry | None = None,
    ) -> CannotCalibrate:
        """With the cause of an error in front of it."""
        tested: tuple[float, tuple[ModelTest, ...]] = (1.0, ())
        causes = tuple(words for said in checks.values() for words in said)
        if batch is not None and not causes:
            tested = of_a_wide_fit(batch, belief, gate, telemetry)
            causes = tuple(test.words for test in tested[1] if test.named)
        return cls(f"{causes[0]} ({error})" if causes else error, checks, tested, causes)

    def check_table(self) -> pd.DataFrame:
        """A row for each check that needs no attitude, and what it ``says``."""
        rows = {name: "; ".join(said) or "nothing" for name, said in self.checks.items()}
        return pd.DataFrame({"says": rows}).rename_axis("check")

    def model_table(self) -> pd.DataFrame:
        """As of a calibration."""
        return tests_table(ModelTest, self.model_tests, "name")


def of_a_wide_fit(
    batch: Batch, belief: Belief, gate: float, telemetry: Telemetry | None = None
) -> tuple[float, tuple[ModelTest, ...]]:
    """By how much noise has to be larger for few outliers, and what is tested then."""
    found = None
    for factor in _WIDER:
        try:
            made = fit(replace(batch, noise=factor * batch.noise), belief, gate)
        except ValueError:
            continue
        found = factor, made.solution
        if (made.rejected.sum(axis=1) <= MOST_REJECTED * batch.there.sum(axis=1)).all():
            break
    if found is None:
        return _WIDER[-1], ()
    factor, solution = found
    channels: dict[str, Floats] = {}
    left_out = 0
    if telemetry is not None:
        channels, left_out = channels_of(telemetry, batch, filtered(solution).innovations)
    asked = questions(solution, channels)
    n_tests = len(asked) + left_out * (1 + len(batch.sensors))
    return factor, model_tests(solution, asked, n_tests, 1.0)[0]
