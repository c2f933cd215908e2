"""Score tests for unmodeled errors, and selection of the errors that explain the data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mgeo_calibration.calibration.consistency_tests import (
    SIGNIFICANCE,
    Failure,
    SensorTest,
    format_chi_square,
)
from mgeo_calibration.calibration.hypotheses import Hypothesis
from mgeo_calibration.estimation.score import Score, ScoreTests, compute_scores
from mgeo_calibration.estimation.smoother import Solution, compute_last_covariance

#: Hypotheses are indistinguishable if their p-values differ by less than this factor.
_MAX_P_RATIO = 1000.0
#: Smallest change of an estimate, in 1-sigmas, for a note on a doubtful convention.
_MIN_CHANGE_SIGMAS = 1.0
#: Largest distance of a score from an alternative convention, in 1-sigmas, for a note.
_MAX_DISTANCE_SIGMAS = 3.0


@dataclass(frozen=True, kw_only=True)
class ModelTest:
    """Result of a score test for an error that the scenario does not model.

    Attributes
    ----------
    name : str
        Gyro or sensor, and error: for example ``mag.latency``.
    description : str
        Size of the error with its 1-sigma, or why the error cannot be tested.
    action : str
        What the user should do if the error exists: usually a key of the scenario to set.
    chi_square : float
        Test statistic.
    degrees_of_freedom : int
        Degrees of freedom; zero if the error is not tested.
    p : float
        p-value of the chi-square.
    significance_level : float
        Significance level of the test.
    is_selected : bool
        True if the error is significant and not explained by more significant errors.
    alternatives : str
        Errors that cannot be distinguished from this error, with their sizes, actions and
        correlations.
    """

    name: str
    description: str
    action: str
    chi_square: float
    degrees_of_freedom: int
    p: float
    significance_level: float
    is_selected: bool
    alternatives: str = ""

    @property
    def failure(self) -> Failure:
        """Description of the failed test."""
        evidence = format_chi_square(
            self.chi_square, self.degrees_of_freedom, self.p, self.significance_level
        )
        return Failure(
            "unmodeled errors", self.description, evidence, self.action, self.alternatives
        )


def run_model_tests(
    solution: Solution, hypotheses: Mapping[str, Hypothesis], n_tests: float, variance_ratio: float
) -> tuple[tuple[ModelTest, ...], tuple[str, ...]]:
    """Test a converged fit for unmodeled errors, and select the errors that explain the data.

    The most significant error is selected first. The other errors are then tested again with the
    selected error estimated, until none is significant: one error resembles many others. The number
    of tests decreases with each selection (S. Holm, A simple sequentially rejective multiple test
    procedure, Scandinavian Journal of Statistics 6 (1979) 65-70).

    Parameters
    ----------
    solution : Solution
    hypotheses : mapping of str to Hypothesis
        Result of `build_hypotheses`.
    n_tests : float
        Sum of the weights of tests of all kinds.
    variance_ratio : float
        Ratio of actual to declared variance of the readings.

    Returns
    -------
    tests : tuple of ModelTest
        Selected errors first.
    doubts : tuple of str
        Notes on doubtful conventions, if no error is selected.
    """
    model_errors = {
        _format_key(name, option): model_error
        for name, hypothesis in hypotheses.items()
        for option, model_error in enumerate(hypothesis.options)
    }
    result = compute_scores(solution, model_errors)
    single_scores = _score_hypotheses(result, hypotheses, ())
    selected = _select_errors(result, hypotheses, single_scores, n_tests, variance_ratio)
    tests = []
    for name in (*selected, *(name for name in hypotheses if name not in selected)):
        hypothesis = hypotheses[name]
        score, alternatives = selected.get(name, (single_scores[name], ""))
        description = (
            hypothesis.describe(score)
            if score.degrees_of_freedom
            else f"not observable {hypothesis.observability_condition}"
        )
        tests.append(
            ModelTest(
                name=name,
                description=description,
                action=hypothesis.action,
                chi_square=score.chi_square / variance_ratio,
                degrees_of_freedom=score.degrees_of_freedom,
                p=score.compute_p_value(variance_ratio),
                significance_level=hypothesis.weight * SIGNIFICANCE / n_tests,
                is_selected=name in selected,
                alternatives=alternatives,
            )
        )
    doubts = (
        () if selected else tuple(_describe_doubts(solution, hypotheses, single_scores, result))
    )
    return tuple(tests), doubts


def compute_variance_ratio(tests: Sequence[SensorTest]) -> float:
    """Return the largest variance ratio of all sensors, but at least 1."""
    return max([1.0, *(test.variance_ratio for test in tests)])


def _select_errors(
    all_scores: ScoreTests,
    hypotheses: Mapping[str, Hypothesis],
    single_scores: Mapping[str, Score],
    n_tests: float,
    variance_ratio: float,
) -> dict[str, tuple[Score, str]]:
    """Select significant errors one by one, and return their scores and alternatives."""
    selected: dict[str, tuple[Score, str]] = {}
    current_scores, n_remaining = single_scores, n_tests

    def is_significant(name: str, score: Score) -> bool:
        return (
            score.compute_p_value(variance_ratio)
            < hypotheses[name].weight * SIGNIFICANCE / n_remaining
        )

    while True:
        evidence = {
            name: score.compute_evidence(variance_ratio) + 2.0 * math.log(hypotheses[name].weight)
            for name, score in current_scores.items()
            if hypotheses[name].is_possible(score)
        }
        best = max(evidence, key=lambda name: evidence[name], default=None)
        if best is None or not is_significant(best, current_scores[best]):
            return selected
        keys = [_format_key(name, score.alternative) for name, (score, _) in selected.items()]
        keys.append(_format_key(best, current_scores[best].alternative))
        others = {n: each for n, each in hypotheses.items() if n not in selected and n != best}
        remaining_scores = _score_hypotheses(all_scores, others, keys)
        min_evidence = evidence[best] - 2.0 * math.log(_MAX_P_RATIO)
        alternatives = sorted(
            (
                name
                for name in evidence
                if name != best
                and evidence[name] > min_evidence
                and not is_significant(name, remaining_scores[name])
            ),
            key=lambda name: -evidence[name],
        )
        selected[best] = (
            current_scores[best],
            _describe_alternatives(hypotheses, current_scores, remaining_scores, alternatives),
        )
        current_scores, n_remaining = remaining_scores, n_remaining - hypotheses[best].weight


def _describe_alternatives(
    hypotheses: Mapping[str, Hypothesis],
    current_scores: Mapping[str, Score],
    remaining_scores: Mapping[str, Score],
    alternatives: Sequence[str],
) -> str:
    words = []
    for name in alternatives:
        unexplained = remaining_scores[name].chi_square / current_scores[name].chi_square
        correlation = math.sqrt(max(0.0, 1.0 - unexplained))
        hypothesis = hypotheses[name]
        words.append(
            f"or {hypothesis.describe(current_scores[name])} (correlation {correlation:.2f}): "
            f"{hypothesis.action}"
        )
    return "; ".join(words)


def _score_hypotheses(
    all_scores: ScoreTests, hypotheses: Mapping[str, Hypothesis], keys: Sequence[str]
) -> dict[str, Score]:
    """Test each hypothesis about an unmodeled error, and return its most significant score. The
    errors in `keys` are estimated at the same time.
    """
    best = {}
    for name, hypothesis in hypotheses.items():
        count = len(hypothesis.options)
        each = [
            replace(
                all_scores.compute_score(_format_key(name, option), keys),
                alternative=option,
                n_alternatives=count,
            )
            for option in range(count)
        ]
        best[name] = max(each, key=lambda score: score.compute_evidence())
    return best


def _format_key(name: str, option: int) -> str:
    return f"{name} {option}"


def _describe_doubts(
    solution: Solution,
    hypotheses: Mapping[str, Hypothesis],
    single_scores: Mapping[str, Score],
    all_scores: ScoreTests,
) -> Iterator[str]:
    """Yield a note for each declared convention if the data suggest, without statistical
    significance, that another convention applies.
    """
    order = np.concatenate([solution.partition.stochastic, solution.partition.constant])
    sigma = np.sqrt(np.diag(compute_last_covariance(solution)))[order]
    for name, hypothesis in hypotheses.items():
        score, alternative = single_scores[name], hypothesis.alternative_coefficient
        if alternative is None or not score.degrees_of_freedom:
            continue
        off = abs(alternative - score.estimate[0])
        if off > min(_MAX_DISTANCE_SIGMAS * score.sigma[0], abs(score.estimate[0])):
            continue
        change = (
            all_scores.state_changes[:, all_scores.slices[_format_key(name, 0)]][:, 0] * alternative
        )
        moved = np.abs(change) / sigma
        if (most := float(moved.max())) >= _MIN_CHANGE_SIGMAS:
            block = solution.batch.suite.blocks[int(order[moved.argmax()]) // 3]
            yield (
                f"{hypothesis.describe(score)}, which is not significant. If this is true, {block} "
                f"changes by {most:.2g} 1-sigma: {hypothesis.action}"
            )
