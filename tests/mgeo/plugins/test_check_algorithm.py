"""`check_algorithm` accepts valid algorithms and detects the violation of each rule."""

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.soo.nonconvex.de import DE

from mgeo import MGEOReal
from mgeo.testing import CheckError, check_algorithm


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=2), NSGA2(pop_size=12)])
def test_valid_algorithms_pass(algorithm):
    check_algorithm(algorithm)


def test_checks_of_unsupported_features_can_be_disabled():
    check_algorithm(DE(pop_size=10), n_obj=(1,))
    check_algorithm(NeverReports(pop_size=12), n_obj=(2,), constraints=False)
    with pytest.raises(CheckError):
        check_algorithm(DE(pop_size=10), n_obj=(2,))


class Unseeded(NSGA2):
    def _infill(self):
        infills = super()._infill()
        noise = np.random.default_rng().uniform(0, 1e-9, infills[0].X.shape)
        infills[0].X = np.clip(infills[0].X + noise, -2, 2)
        return infills


class Global(NSGA2):
    def _infill(self):
        np.random.random()  # noqa: NPY002
        return super()._infill()


class Outside(NSGA2):
    def _infill(self):
        infills = super()._infill()
        infills[0].X = infills[0].X + 9.0
        return infills


class Uncounted(NSGA2):
    def _advance(self, infills=None, **kwargs):
        self.problem.evaluate(infills.get("X"))
        return super()._advance(infills, **kwargs)


class KeepsDominated(NSGA2):
    def _set_optimum(self):
        self.opt = self.pop[self.pop.get("feas")]


class Unpicklable(NSGA2):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.hook = lambda: None


class IgnoresConstraints(NSGA2):
    def result(self):
        result = super().result()
        if self.problem.has_constraints() and result.X is not None:
            result.X[:, 0] = -1.0
        return result


class NeverReports(NSGA2):
    def _set_optimum(self):
        super()._set_optimum()
        if not self.opt.get("feas").any():
            self.opt = None


@pytest.mark.parametrize(
    ("cls", "message"),
    [
        (Unseeded, "same seed, same points: got"),
        (Global, "global random state was used"),
        (Outside, "out of bounds were evaluated"),
        (Uncounted, "n_eval = 60 after 108 evaluations"),
        (KeepsDominated, "points of res.F are dominated"),
        (Unpicklable, "pickle the algorithm"),
        (IgnoresConstraints, "infeasible points returned"),
        (NeverReports, "return_least_infeasible: expected a point"),
    ],
)
def test_each_violated_rule_is_detected(cls, message):
    with pytest.raises(CheckError, match=message):
        check_algorithm(cls(pop_size=12), n_obj=(2,))


class Forgetful(MGEOReal):
    """Algorithm that depends on an attribute outside its state."""

    n_calls = 0

    def accept(self, F, violation):
        self.n_calls += 1
        return super().accept(F if self.n_calls % 3 else -F, violation)


def test_variant_with_state_outside_run_state_is_detected():
    with pytest.raises(CheckError, match="a run that was saved and restored midway: X"):
        check_algorithm(Forgetful(n_walkers=3))


class Halved(MGEOReal):
    """Algorithm that stores another value than its parameter."""

    def __init__(self, scale=0.1, **options):
        super().__init__(**options)
        self.scale = scale / 2

    def compute_step_sigmas(self, sigma):
        return self.scale * sigma


class Hidden(MGEOReal):
    """Algorithm that uses another value than the stored one."""

    def __init__(self, scale=0.1, **options):
        super().__init__(**options)
        self.scale, self.width = 0.1, scale

    def compute_step_sigmas(self, sigma):
        return self.width * sigma


@pytest.mark.parametrize(
    ("algorithm", "message"),
    [
        (Halved(n_walkers=3), r"Halved\(scale=0.05\) has scale = 0.025"),
        (Hidden(0.3, n_walkers=3), r"an algorithm built from get_params\(\) .* original: X"),
    ],
)
def test_parameter_that_is_not_stored_as_attribute_is_detected(algorithm, message):
    with pytest.raises(CheckError, match=message):
        check_algorithm(algorithm, n_gen=3)
