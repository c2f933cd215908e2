"""Matrix adaptation evolution strategies that some walkers of `MGEODirected` run in parallel."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from mgeo._typing import FloatArray, IntArray


@dataclass(kw_only=True, eq=False, slots=True)
class SearchDistributions:
    """Normal distributions of k walkers, and the samples of them that are not judged yet.

    A step is sigma M z of the bounds' widths, z standard normal. When a sample is full, the means
    move to what was best in it, and sigma and M learn from that: the matrix adaptation evolution
    strategy (Beyer & Sendhoff, "Simplify your covariance matrix adaptation evolution strategy",
    IEEE Trans. Evol. Comput. 21, 2017, figure 3), with the weights, rates and damping of the CMA-ES
    (Hansen, "The CMA evolution strategy: a tutorial", 2016).

    Attributes
    ----------
    sigma : (k,) step sizes, as a share of the bounds' widths; 0 before a distribution begins.
    matrix : (k, n_var, n_var) M; the covariance is sigma^2 M M^T.
    path : (k, n_var) which way the means have gone of late.
    z, F, violation : (k, size, ...) the sample: steps, objectives, constraint violations.
    n_drawn : how many of each sample are evaluated.
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
        """None has begun; samples are of 4 + 3 ln n_var at least, `n_candidates` at a time."""
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
        """Let some distributions begin anew, as wide in all directions."""
        self.sigma[rows] = sigma
        self.matrix[rows] = np.eye(self.path.shape[1])
        self.path[rows] = 0.0

    @property
    def max_sigma(self) -> FloatArray:
        """(k,) the largest standard deviation of a variable, of the bounds' width."""
        return np.asarray(self.sigma * np.sqrt((self.matrix**2).sum(axis=2).max(axis=1)))

    def draw_steps(self, n_candidates: int, rng: np.random.Generator) -> FloatArray:
        """(k, together, n_var) the next steps of each sample, of the bounds' widths."""
        k, _, n_var = self.z.shape
        z = rng.standard_normal((k, n_candidates, n_var))
        self.z[:, self.n_drawn : self.n_drawn + n_candidates] = z
        return self.sigma[:, None, None] * (z @ self.matrix.transpose(0, 2, 1))

    def add_evaluations(self, F: FloatArray, violation: FloatArray) -> bool:
        """What the last steps were worth, (k, together, ...); whether samples are full now."""
        now = slice(self.n_drawn, self.n_drawn + F.shape[1])
        self.F[:, now], self.violation[:, now] = F, violation
        self.n_drawn = now.stop
        return bool(self.n_drawn == self.z.shape[1])

    def adapt(self, ranking: IntArray) -> FloatArray:
        """(k, n_var) steps of the means, of the bounds' widths, by (k, size) places, best first."""
        n = self.path.shape[1]
        half = self.z.shape[1] // 2
        weights = np.log(half + 0.5) - np.log(np.arange(1, half + 1))
        weights /= weights.sum()
        many = 1.0 / (weights**2).sum()
        rate = (many + 2) / (n + many + 5)
        damping = 1 + rate + 2 * max(0.0, ((many - 1) / (n + 1)) ** 0.5 - 1)
        of_path = 2 / ((n + 1.3) ** 2 + many)
        of_sample = min(1 - of_path, 2 * (many - 2 + 1 / many) / ((n + 2) ** 2 + many))
        length = n**0.5 * (1 - 1 / (4 * n) + 1 / (21 * n**2))  # mean of a normal vector's
        z = np.take_along_axis(self.z, ranking[:, :half, None], axis=1)
        mean = weights @ z
        step = np.asarray(self.sigma[:, None] * (self.matrix @ mean[:, :, None])[:, :, 0])
        self.path = (1 - rate) * self.path + (many * rate * (2 - rate)) ** 0.5 * mean
        turned = (
            (1 - (of_path + of_sample) / 2) * np.eye(n)
            + of_path / 2 * self.path[:, :, None] * self.path[:, None, :]
            + of_sample / 2 * (z * weights[:, None]).transpose(0, 2, 1) @ z
        )
        self.matrix = self.matrix @ turned
        ratio = np.linalg.norm(self.path, axis=1) / length
        self.sigma = self.sigma * np.exp(np.minimum(rate / damping * (ratio - 1), 1.0))
        self.n_drawn = 0
        return step
