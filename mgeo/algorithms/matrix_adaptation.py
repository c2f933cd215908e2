"""Matrix adaptation evolution strategies, run in parallel by some walkers of `MGEODirected`."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from mgeo._typing import FloatArray, IntArray


@dataclass(kw_only=True, eq=False, slots=True)
class SearchDistributions:
    """Adaptive normal distributions, one per walker, that generate the candidates.

    The class stores k distributions. A step from the mean is sigma M z, in units of the width of
    the bounds, with z from a standard normal distribution. Steps are drawn and evaluated in several
    batches. When the sample of a distribution is complete, its mean moves towards the best steps,
    and sigma and M are adapted.

    The method is the matrix adaptation evolution strategy (Beyer & Sendhoff, "Simplify your
    covariance matrix adaptation evolution strategy", IEEE Trans. Evol. Comput. 21, 2017, figure 3),
    with the weights, learning rates and damping of the CMA-ES (Hansen, "The CMA evolution strategy:
    a tutorial", 2016).

    Attributes
    ----------
    sigma : array, shape (k,)
        Step sizes as a fraction of the width of the bounds; 0 for a distribution that has not
        started.
    matrix : array, shape (k, n_var, n_var)
        Matrices M. The covariance is sigma^2 M M^T.
    path : array, shape (k, n_var)
        Evolution paths: exponentially weighted sums of the recent steps of the means.
    z : array, shape (k, sample_size, n_var)
        Standard normal vectors of the current sample.
    F, violation : array, shape (k, sample_size, n_obj) and (k, sample_size)
        Objectives and constraint violations of the current sample.
    n_drawn : int
        Number of evaluated steps in each sample.
    """

    sigma: FloatArray
    matrix: FloatArray
    path: FloatArray
    z: FloatArray
    F: FloatArray
    violation: FloatArray
    n_drawn: int

    @classmethod
    def create(cls, n_distributions: int, n_var: int, n_obj: int, n_candidates: int) -> Self:
        """Create distributions that are inactive until `reset` sets their step sizes.

        Parameters
        ----------
        n_distributions, n_var, n_obj : int
            Numbers of distributions, variables and objectives.
        n_candidates : int
            Number of steps that each distribution draws per generation. The sample size is the
            smallest multiple of this number that is at least 4 + floor(3 ln n_var).
        """
        size = n_candidates * int(np.ceil((4 + int(3 * np.log(n_var))) / n_candidates))
        return cls(
            sigma=np.zeros(n_distributions),
            matrix=np.zeros((n_distributions, n_var, n_var)),
            path=np.zeros((n_distributions, n_var)),
            z=np.zeros((n_distributions, size, n_var)),
            F=np.zeros((n_distributions, size, n_obj)),
            violation=np.zeros((n_distributions, size)),
            n_drawn=0,
        )

    def reset(self, rows: IntArray, sigma: FloatArray) -> None:
        """Reset the selected distributions to isotropic normal distributions.

        Parameters
        ----------
        rows : array of int, shape (n,)
            Indices of the distributions.
        sigma : array, shape (n,)
            Step sizes as a fraction of the width of the bounds.
        """
        self.sigma[rows] = sigma
        self.matrix[rows] = np.eye(self.path.shape[1])
        self.path[rows] = 0.0

    @property
    def max_sigma(self) -> FloatArray:
        """Largest standard deviation of each distribution over all variables.

        The array has shape (k,) and is a fraction of the width of the bounds.
        """
        return np.asarray(self.sigma * np.sqrt((self.matrix**2).sum(axis=2).max(axis=1)))

    def draw_steps(self, n_candidates: int, rng: np.random.Generator) -> FloatArray:
        """Draw and store random steps from the mean of each distribution.

        Returns
        -------
        array, shape (k, n_candidates, n_var)
            Steps from the means, as a fraction of the width of the bounds.
        """
        k, _, n_var = self.z.shape
        z = rng.standard_normal((k, n_candidates, n_var))
        self.z[:, self.n_drawn : self.n_drawn + n_candidates] = z
        return self.sigma[:, None, None] * (z @ self.matrix.transpose(0, 2, 1))

    def add_evaluations(self, F: FloatArray, violation: FloatArray) -> bool:
        """Store the objectives and constraint violations of the steps drawn last.

        Return True once enough steps are stored for one adaptation of the covariance matrices.

        Parameters
        ----------
        F : array, shape (k, n_candidates, n_obj)
            Objectives of the steps that `draw_steps` returned last.
        violation : array, shape (k, n_candidates)
            Constraint violations of these steps.
        """
        batch = slice(self.n_drawn, self.n_drawn + F.shape[1])
        self.F[:, batch], self.violation[:, batch] = F, violation
        self.n_drawn = batch.stop
        return bool(self.n_drawn == self.z.shape[1])

    def adapt(self, ranking: IntArray) -> FloatArray:
        """Update each distribution from the ranking of its stored steps.

        Parameters
        ----------
        ranking : array of int, shape (k, sample_size)
            Indices of the stored steps of each distribution, best first.

        Returns
        -------
        array, shape (k, n_var)
            Steps of the means, as a fraction of the width of the bounds.
        """
        # The names of the constants are those of Hansen's tutorial.
        n = self.path.shape[1]
        mu = self.z.shape[1] // 2
        weights = np.log(mu + 0.5) - np.log(np.arange(1, mu + 1))
        weights /= weights.sum()
        mu_eff = 1.0 / (weights**2).sum()
        c_sigma = (mu_eff + 2) / (n + mu_eff + 5)
        d_sigma = 1 + c_sigma + 2 * max(0.0, ((mu_eff - 1) / (n + 1)) ** 0.5 - 1)
        c_1 = 2 / ((n + 1.3) ** 2 + mu_eff)
        c_mu = min(1 - c_1, 2 * (mu_eff - 2 + 1 / mu_eff) / ((n + 2) ** 2 + mu_eff))
        mean_norm = n**0.5 * (1 - 1 / (4 * n) + 1 / (21 * n**2))  # Mean length of a normal vector.
        z = np.take_along_axis(self.z, ranking[:, :mu, None], axis=1)
        mean = weights @ z
        step = np.asarray(self.sigma[:, None] * (self.matrix @ mean[:, :, None])[:, :, 0])
        self.path = (1 - c_sigma) * self.path + (mu_eff * c_sigma * (2 - c_sigma)) ** 0.5 * mean
        factor = (
            (1 - (c_1 + c_mu) / 2) * np.eye(n)
            + c_1 / 2 * self.path[:, :, None] * self.path[:, None, :]
            + c_mu / 2 * (z * weights[:, None]).transpose(0, 2, 1) @ z
        )
        self.matrix = self.matrix @ factor
        ratio = np.linalg.norm(self.path, axis=1) / mean_norm
        self.sigma = self.sigma * np.exp(np.minimum(c_sigma / d_sigma * (ratio - 1), 1.0))
        self.n_drawn = 0
        return step
