"""Checkpoints of subclasses with another constructor, and wrappers of pymoo."""

import numpy as np
import pytest
from pymoo.constraints.eps import AdaptiveEpsilonConstraintHandling
from pymoo.core.callback import Callback
from pymoo.optimize import minimize
from pymoo.problems.multi import TNK, ZDT1

from mgeo import Checkpoint, MGEOCanonical, MGEODirected, MGEOReal, resume

PROBLEM = ZDT1(n_var=4)


class Storing(MGEOReal):
    """Algorithm that stores its parameter as an attribute of the same name."""

    def __init__(self, width, n_walkers=3, **options):
        super().__init__(sigma=width / 2, n_walkers=n_walkers, **options)
        self.width = width


class NotStoring(MGEOReal):
    """Algorithm that does not store its parameter."""

    def __init__(self, width, **options):
        super().__init__(sigma=width / 2, **options)


class Fixed(MGEOReal):
    """Algorithm that fixes one parameter and passes on all others."""

    def __init__(self, **options):
        super().__init__(sigma=0.1, **options)


@pytest.mark.parametrize(
    "algorithm",
    [Storing(0.4, tau=1.0), Fixed(n_walkers=3, tau=1.0, restart="archive", patience=2)],
    ids=lambda algorithm: type(algorithm).__name__,
)
def test_subclass_resumes_from_checkpoint_with_all_parameters(algorithm, tmp_path):
    checkpoint = Checkpoint(tmp_path / "kept")
    minimize(PROBLEM, algorithm, ("n_gen", 6), callback=checkpoint, seed=1)
    with pytest.raises(
        ValueError, match=f"{type(algorithm).__name__}' is not an algorithm of mgeo"
    ):
        resume(checkpoint.path, PROBLEM, ("n_gen", 12))
    resumed = resume(checkpoint.path, PROBLEM, ("n_gen", 12), algorithm=algorithm)
    assert type(resumed) is type(algorithm)
    assert (resumed.tau, resumed.patience) == (algorithm.tau, algorithm.patience)
    whole = minimize(PROBLEM, algorithm, ("n_gen", 12), seed=1)
    assert np.array_equal(resumed.run().F, whole.F)


@pytest.mark.parametrize(
    ("algorithm", "message"),
    [
        (NotStoring(0.4), "NotStoring has no attribute 'width': expected"),
        (AdaptiveEpsilonConstraintHandling(MGEOReal(n_walkers=3)), "has no attribute 'algorithm'"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_first_checkpoint_rejects_algorithm_that_cannot_be_resumed(algorithm, message, tmp_path):
    checkpoint = Checkpoint(tmp_path / "kept")
    with pytest.raises(TypeError, match=message):
        minimize(PROBLEM, algorithm, ("n_gen", 3), callback=checkpoint, seed=1)
    assert not checkpoint.path.exists()


class Tolerance(Callback):
    """Callback that records the constraint tolerance in each generation."""

    def __init__(self):
        super().__init__()
        self.tolerated = []

    def notify(self, algorithm):
        self.tolerated.append(algorithm.adapted_config["cv_eps"])


@pytest.mark.parametrize(
    "algorithm",
    [
        MGEOReal(0.2, n_walkers=5, perturbation="range"),
        MGEODirected(n_walkers=5),
        MGEOCanonical(n_walkers=2, bits=8),
    ],
    ids=["real", "directed", "canonical"],
)
def test_temporarily_tolerated_violations_do_not_enter_front(algorithm):
    wrapped, callback = AdaptiveEpsilonConstraintHandling(algorithm), Tolerance()
    result = minimize(TNK(), wrapped, ("n_gen", 40), seed=1, callback=callback)
    assert result.algorithm.problem is not None
    assert algorithm.problem is None
    assert callback.tolerated[5] > callback.tolerated[10] > 0 == callback.tolerated[-1]
    assert np.all(result.CV == 0)
    assert np.all(TNK().evaluate(result.X, return_values_of=["G"]) <= 0)
    strict = minimize(TNK(), algorithm, ("n_gen", 40), seed=1)
    assert not np.array_equal(result.pop.get("X"), strict.pop.get("X"))
