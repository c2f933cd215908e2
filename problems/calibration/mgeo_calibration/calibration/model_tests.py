"""Whether gyro and sensors do what the scenario says of them, beside their constants."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from mgeo_attitude._typing import Floats

from mgeo_calibration.calibration.agreement import LAGS, SIGNIFICANCE, SensorTest, beyond
from mgeo_calibration.calibration.hypotheses import Hypothesis, sized
from mgeo_calibration.estimation.departures import LATE
from mgeo_calibration.estimation.score import Score, Scores, scores
from mgeo_calibration.estimation.smoother import Solution, last_covariance

#: What is more than 20 times as probable to be exceeded by chance is no rival.
_NEARLY = 2.0 * float(np.log(20.0))
#: From so many of its 1-sigmas on a change of an estimate is told.
_MATTERS = 1.0
#: 1-sigmas within which something else may be so.
_CANNOT_TELL = 3.0
#: What are errors of axes, and what is a course of the bias in time.
_KINDS = {
    "axes": ("scale_factor", "misalignment", "nonorthogonality"),
    "course": ("drift", "step", "bias_decay"),
}


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
    rival : str
        What telemetry may ask for in its place, and what would say it, in words: it can hardly tell
        one from the other. None in files of earlier versions.
    """

    name: str
    says: str
    key: str
    chi_square: float
    freedom: int
    p: float
    p_least: float
    named: bool
    rival: str = ""

    @property
    def words(self) -> str:
        """By how much it is off, and what would say it, or what else may be so."""
        off = beyond(self.chi_square, self.freedom, self.p)
        return f"{self.says} {off}: {self.key}" + (f", or {self.rival}" if self.rival else "")


def model_tests(
    solution: Solution, hypotheses: Mapping[str, Hypothesis], n_tests: int, scatter: float
) -> tuple[tuple[ModelTest, ...], tuple[str, ...]]:
    """Of a settled solution; and notes on what matters and telemetry does not say.

    Of those that fail the one that says most is named, then of the others the one that says most
    beside it, and so on: what is wrong looks like much else. Each time there is one test less
    (S. Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
    Statistics 6 (1979) 65-70). What says nearly as much in its place is its rival.

    Parameters
    ----------
    hypotheses : mapping of str to Hypothesis
        See `hypotheses`.
    n_tests : int
        How many tests there are, of all kinds.
    scatter : float
        By how much the sensors' variance exceeds that of the scenario: what is that uncertain says
        less.
    """
    departures = {
        _key(name, option): departure
        for name, hypothesis in hypotheses.items()
        for option, departure in enumerate(hypothesis.options)
    }
    found = scores(solution, departures)
    alone = _beside(found, hypotheses, ())
    named = _named(found, hypotheses, alone, n_tests, scatter)
    tests = []
    for name in (*named, *(name for name in hypotheses if name not in named)):
        hypothesis, winner = hypotheses[name], named.get(name)
        # beside those that are named before it
        score = winner.score if winner else alone[name]
        rival = winner.rival if winner and winner.rival not in named else None
        tests.append(
            ModelTest(
                name=name,
                says=hypothesis.says(score),
                key=hypothesis.key,
                chi_square=score.chi_square / scatter,
                freedom=score.freedom,
                p=score.p(scatter),
                p_least=SIGNIFICANCE / n_tests,
                named=winner is not None,
                rival=f"{hypotheses[rival].says(winner.beside[rival])}: {hypotheses[rival].key}"
                if winner and rival
                else "",
            )
        )
    return tuple(tests), _notes(solution, alone, found, named)


def scatter_of(tests: Sequence[SensorTest]) -> float:
    """By how much the mean of innovations varies more than the scenario says, at least one.

    Of those that are correlated by more than chance, over all `LAGS`.
    """
    correlated = (
        2.0 * LAGS * test.correlation * (test.correlation > test.correlation_bound)
        for test in tests
    )
    each = (test.nis * (1.0 + more) for test, more in zip(tests, correlated, strict=True))
    return max([1.0, *each])


@dataclass(frozen=True)
class _Winner:
    """What is named, its score and those of all others beside what is named before it."""

    score: Score
    beside: Mapping[str, Score]
    rival: str | None


def _named(
    found: Scores,
    hypotheses: Mapping[str, Hypothesis],
    alone: Mapping[str, Score],
    n_tests: int,
    scatter: float,
) -> dict[str, _Winner]:
    named: dict[str, _Winner] = {}
    while True:
        keys = [_key(name, winner.score.option) for name, winner in named.items()]
        others = {name: each for name, each in hypotheses.items() if name not in named}
        beside = _beside(found, others, keys) if named else alone
        says = {
            name: score.evidence(scatter)
            for name, score in beside.items()
            if hypotheses[name].possible(score)
        }
        best = max(says, key=lambda name: says[name], default=None)
        if best is None or beside[best].p(scatter) >= SIGNIFICANCE / (n_tests - len(named)):
            return named
        unlike = [name for name in says if _kind(name) != _kind(best)]
        rival = max(unlike, key=lambda name: says[name], default=best)
        near = rival != best and says[rival] > says[best] - _NEARLY
        named[best] = _Winner(beside[best], beside, rival if near else None)


def _beside(
    found: Scores, hypotheses: Mapping[str, Hypothesis], keys: Sequence[str]
) -> dict[str, Score]:
    """Return each hypothesis's option of greatest evidence, with others estimated beside it."""
    best = {}
    for name, hypothesis in hypotheses.items():
        count = len(hypothesis.options)
        each = [
            replace(found.of(_key(name, option), keys), option=option, options=count)
            for option in range(count)
        ]
        best[name] = max(each, key=lambda score: score.evidence())
    return best


def _kind(name: str) -> tuple[str, str]:
    """Whose it is and of what kind: two of one kind are not told as rivals."""
    owner, _, what = name.partition(".")
    return owner, next((kind for kind, names in _KINDS.items() if what in names), what)


def _key(name: str, option: int) -> str:
    return f"{name} {option}"


def _notes(
    solution: Solution, alone: Mapping[str, Score], found: Scores, named: Collection[str]
) -> tuple[str, ...]:
    """On what makes a difference and cannot be told from what is said."""
    if named:
        return ()
    gyro, times = solution.batch.suite.gyro, solution.batch.times
    duration, score = float(times[-1] - times[0]), alone["gyro.bias_decay"]
    notes, none = [], -gyro.bias_decay * duration
    if none and abs(none - score.estimate[0]) <= _CANNOT_TELL * score.sigma[0]:
        decay, spread = gyro.bias_decay + score.estimate[0] / duration, score.sigma[0] / duration
        notes += _if_so(
            solution,
            found.change[:, found.places[_key("gyro.bias_decay", 0)]][:, 0] * none,
            "gyro.bias may be constant: telemetry says that it decays by "
            f"{sized(decay, spread)} 1/s; without a decay",
            f"see gyro.bias_decay = {gyro.bias_decay:g}",
        )
    if sampled := alone.get("gyro.delay"):
        (early,), (sigma,) = LATE * sampled.estimate, LATE * sampled.sigma
        half = 0.5 * float(np.median(solution.batch.durations))
        if early > 0.5 * half and abs(half - early) <= _CANNOT_TELL * sigma:
            notes += _if_so(
                solution,
                found.change[:, found.places[_key("gyro.delay", 0)]][:, 0] * half / LATE,
                f"gyro may report the rates at its samples: these are {sized(early, sigma)} s "
                "early; if so,",
                "see rate under [gyro] of the mapping",
            )
    return tuple(notes)


def _if_so(solution: Solution, change: Floats, begin: str, end: str) -> list[str]:
    """A note, if what is estimated at the last sample would be elsewhere."""
    order = np.concatenate([solution.parts.driven, solution.parts.constant])
    off = np.abs(change) / np.sqrt(np.diag(last_covariance(solution)))[order]
    if (most := float(off.max())) < _MATTERS:
        return []
    block = solution.batch.suite.blocks[int(order[off.argmax()]) // 3]
    return [f"{begin} {block} would be {most:.2g} of its 1-sigmas elsewhere, {end}"]
