"""Whether gyro and sensors do what the scenario says of them, beside their constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats

from mgeo_calibration.calibration.questions import Question, sized
from mgeo_calibration.calibration.sensor_tests import LAGS, SIGNIFICANCE, SensorTest
from mgeo_calibration.estimation.score import Score, Scores, scores
from mgeo_calibration.estimation.smoother import Solution, last_covariance

#: What a degree of freedom has to explain, as by Schwarz's criterion of 1,000 readings.
_EACH = float(np.log(1000.0))
#: From so many of its 1-sigmas on a change of an estimate is told.
_MATTERS = 1.0


@dataclass(frozen=True, kw_only=True)
class ModelTest:
    """Score test of something that the scenario says, or says nothing of.

    Attributes
    ----------
    name : str
    says : str
        What telemetry asks for, in words, with 1-sigma.
    key : str
        What would say it.
    chi_square : float
    freedom : int
        Its degrees of freedom.
    p : float
        Probability that chance exceeds it.
    p_least : float
        The test fails below this.
    named : bool
        Whether it fails, and those that say more do not explain it.
    """

    name: str
    says: str
    key: str
    chi_square: float
    freedom: int
    p: float
    p_least: float
    named: bool

    @property
    def words(self) -> str:
        """By how much it is off, and what would say it."""
        p = f"p = {self.p:.1g}" if self.p > 1e-300 else "p < 1e-300"
        return f"{self.says} (chi-square {self.chi_square:.4g} of {self.freedom}, {p}): {self.key}"


def model_tests(
    solution: Solution, asked: Mapping[str, Question], n_tests: int, scatter: float
) -> tuple[tuple[ModelTest, ...], tuple[str, ...]]:
    """Of a settled solution; and notes on what matters and telemetry does not say.

    Of those that fail the one that says most is named, then of the others the one that says most
    beside it, and so on: what is wrong looks like much else. Each time there is one test less
    (S. Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
    Statistics 6 (1979) 65-70).

    Parameters
    ----------
    asked : mapping of str to Question
        See `questions`.
    n_tests : int
        How many tests there are, of all kinds.
    scatter : float
        By how much the sensors' variance exceeds that of the scenario: what is that uncertain says
        less.
    """
    found = scores(solution, {name: question.departure for name, question in asked.items()})
    named = _named(found, asked, n_tests, scatter)
    tests = []
    for name in (*named, *(name for name in asked if name not in named)):
        question = asked[name]
        # beside those that are named before it
        score = found.of(name, named[: named.index(name)] if name in named else ())
        tests.append(
            ModelTest(
                name=name,
                says=question.says(score),
                key=question.key,
                chi_square=score.chi_square / scatter,
                freedom=score.freedom,
                p=score.p(scatter),
                p_least=SIGNIFICANCE / n_tests,
                named=name in named,
            )
        )
    return tuple(tests), _notes(solution, found, named)


def model_table(tests: Sequence[ModelTest]) -> pd.DataFrame:
    """A row for each."""
    columns = [field.name for field in fields(ModelTest)]
    frame = pd.DataFrame([vars(test) for test in tests], columns=columns)
    return frame.set_index("name").drop(columns="p_least")


def scatter_of(tests: Sequence[SensorTest]) -> float:
    """By how much the mean of innovations varies more than the scenario says, at least one.

    Of those that are correlated by more than chance, over all `LAGS`.
    """
    correlated = (
        2.0 * LAGS * test.correlation * (test.correlation > test.correlation_bound)
        for test in tests
    )
    each = (test.nis * (1.0 + more) for test, more in zip(tests, correlated, strict=True))
    return max(1.0, *each)


def _named(
    found: Scores, asked: Mapping[str, Question], n_tests: int, scatter: float
) -> tuple[str, ...]:
    named: list[str] = []
    while True:
        beside = {name: found.of(name, named) for name in asked if name not in named}
        left = [name for name, score in beside.items() if asked[name].possible(score)]
        best = max(left, key=lambda name: _evidence(beside[name], scatter), default=None)
        if best is None or beside[best].p(scatter) >= SIGNIFICANCE / (n_tests - len(named)):
            return tuple(named)
        named.append(best)


def _notes(solution: Solution, found: Scores, named: tuple[str, ...]) -> tuple[str, ...]:
    """On a decay that is believed, makes a difference and cannot be told from none."""
    gyro, times = solution.batch.suite.gyro, solution.batch.times
    duration, score = float(times[-1] - times[0]), found.of("gyro.bias_decay")
    none = -gyro.bias_decay * duration
    if named or not none or abs(none - score.estimate[0]) > 3.0 * score.sigma[0]:
        return ()
    order = np.concatenate([solution.parts.driven, solution.parts.constant])
    sigma = np.sqrt(np.diag(last_covariance(solution)))[order]
    change: Floats = np.abs(found.change[:, found.places["gyro.bias_decay"]][:, 0] * none) / sigma
    most = float(change.max())
    if most < _MATTERS:
        return ()
    block = solution.batch.suite.blocks[int(order[change.argmax()]) // 3]
    decay, spread = gyro.bias_decay + score.estimate[0] / duration, score.sigma[0] / duration
    return (
        f"gyro.bias may be constant: telemetry says that it decays by {sized(decay, spread)} 1/s; "
        f"without a decay {block} would be {most:.2g} of its 1-sigmas elsewhere, see "
        f"gyro.bias_decay = {gyro.bias_decay:g}",
    )


def _evidence(score: Score, scatter: float) -> float:
    return score.chi_square / scatter - _EACH * score.freedom
