"""Reference implementation of a single walker in plain Python, for each published variant.

The classes ...Moves define the encoding and the candidates of a variant: `start(stream)` returns
the first point, `trials(point, stream)` groups of candidates as pairs of coordinate and new value,
and `design(point)` the variables of a point.
"""

import math

import numpy as np
from scipy.special import ndtr, ndtri


class RealMoves:
    """Candidates of MGEO_real: a single group with one step per variable."""

    def __init__(self, problem, sigma, perturbation="absolute", bounds="clip"):
        self.xl, self.xu = problem.xl.tolist(), problem.xu.tolist()
        self.n = self.length = problem.n_var
        self.sigmas = np.broadcast_to(sigma, self.n).tolist()
        self.perturbation, self.bounds = perturbation, bounds

    def start(self, stream):
        uniform = stream.random(self.n).tolist()
        return [
            low + (high - low) * u for low, high, u in zip(self.xl, self.xu, uniform, strict=True)
        ]

    def design(self, point):
        return point

    def step(self, point, i, deviation, noise, uniform):
        scale = {
            "absolute": 1.0,
            "relative": point[i],
            "range": self.xu[i] - self.xl[i],
        }[self.perturbation]
        x, low, high = point[i], self.xl[i], self.xu[i]
        moved = x + deviation * scale * noise
        if low <= moved <= high:
            return moved
        if self.bounds == "reflect":
            over = (moved - low) % (2 * (high - low))
            moved = low + min(over, 2 * (high - low) - over)
        elif self.bounds == "resample":
            unit = abs(deviation * scale)
            below, above = ndtr((low - x) / unit), ndtr((high - x) / unit)
            moved = x + unit * float(ndtri(below + uniform * (above - below)))
        return min(max(moved, low), high)

    def draws(self, stream, n):
        """Return a normal and a uniform random number for each step."""
        # Uniform numbers are drawn for resampling only.
        noise = stream.standard_normal(n).tolist()
        return noise, stream.random(n).tolist() if self.bounds == "resample" else [0.0] * n

    def trials(self, point, stream):
        noise, uniform = self.draws(stream, self.n)
        return [
            [(i, self.step(point, i, self.sigmas[i], noise[i], uniform[i])) for i in range(self.n)]
        ]


class Real2Moves(RealMoves):
    """Candidates of MGEO_real2: one group per variable, with decreasing step sizes."""

    def __init__(self, problem, sigma, perturbation, bounds, n_steps, divisor, schedule):
        super().__init__(problem, sigma, perturbation, bounds)
        self.n_steps, self.divisor, self.schedule = n_steps, divisor, schedule

    def trials(self, point, stream):
        noise, uniform = map(iter, self.draws(stream, self.n * self.n_steps))
        groups = []
        for i in range(self.n):
            deviation, group = self.sigmas[i], []
            for j in range(1, self.n_steps + 1):
                group.append((i, self.step(point, i, deviation, next(noise), next(uniform))))
                if self.schedule == "factorial":
                    deviation = deviation / (self.divisor * j)
                else:
                    deviation = deviation / self.divisor
            groups.append(group)
        return groups


class BitMoves:
    """Candidates of bit strings: one flip per bit, in a single group or one group per variable."""

    def __init__(self, problem, bits, gray, has_groups):
        self.xl, self.xu = problem.xl.tolist(), problem.xu.tolist()
        self.bits = np.broadcast_to(bits, problem.n_var).tolist()
        self.length = sum(self.bits)
        self.gray, self.has_groups = gray, has_groups

    def start(self, stream):
        return [float(bit) for bit in stream.integers(0, 2, self.length)]

    def design(self, point):
        values, rest = [], list(point)
        for low, high, count in zip(self.xl, self.xu, self.bits, strict=True):
            text, rest = rest[:count], rest[count:]
            number, before = 0, 0
            for bit in text:
                before = before ^ int(bit) if self.gray else int(bit)
                number = 2 * number + before
            values.append(min(low + (high - low) * (number / (2**count - 1)), high))
        return values

    def trials(self, point, stream):
        flips = [(i, 1.0 - bit) for i, bit in enumerate(point)]
        if not self.has_groups:
            return [flips]
        groups = []
        for count in self.bits:
            group, flips = flips[:count], flips[count:]
            groups.append(group)
        return groups


class Walk:
    """Run of one walker.

    Attributes
    ----------
    path : list of list
        Point after each generation.
    taus : list of list
        Adaptive tau of each objective after each generation.
    X, F, violation : list
        Variables, objectives and constraint violations of all evaluated points, in order.
    """

    def __init__(self, problem, moves, tau, seed, walker, evaluates_walker=False):
        self.problem, self.moves, self.tau = problem, moves, tau
        self.evaluates_walker = evaluates_walker
        self.stream = np.random.default_rng(np.random.SeedSequence(seed).spawn(walker + 1)[walker])
        self.point = moves.start(self.stream)
        self.path, self.taus, self.X, self.F, self.violation = [], [], [], [], []
        n_obj = problem.n_obj
        self.adaptive_tau = [0.5] * n_obj
        self.chance = [1.0 / math.sqrt(problem.n_var)] * n_obj
        # The first point has not been evaluated, and counts as failed.
        self.current = self.best = [(2, 0.0)] * n_obj

    def evaluate(self, point):
        """Return the fitness of a point for each objective, as tuples that sort by quality."""
        x = self.moves.design(point)
        out = self.problem.evaluate(
            np.array([x]), return_values_of=["F", "G", "H"], return_as_dictionary=True
        )
        violation = sum(max(0.0, g) for g in out["G"][0].tolist())
        violation += sum(max(0.0, abs(h) - 1e-4) for h in out["H"][0].tolist())
        f = out["F"][0].tolist()
        self.X.append(list(x))
        self.F.append(f)
        self.violation.append(violation)
        if not all(math.isfinite(v) for v in f) or math.isnan(violation):
            return [(2, 0.0)] * len(f)
        return [(1, violation) if violation > 0 else (0, v) for v in f]

    def generation(self):
        if self.evaluates_walker:
            self.current = self.evaluate(self.point)
            self.update_best([self.current])
        groups = self.moves.trials(self.point, self.stream)
        values = []
        for group in groups:
            values.append([])
            for coordinate, value in group:
                trial = list(self.point)
                trial[coordinate] = value
                values[-1].append(self.evaluate(trial))
        objective = int(self.stream.random() * self.problem.n_obj)
        ties = [self.stream.random(len(group)).tolist() for group in groups]
        draws = [self.stream.random() for _ in groups]
        every = [value for group in values for value in group]
        tau = self.adapt(objective, every) if isinstance(self.tau, str) else self.tau
        self.update_best(every)
        for group, value, tie, draw in zip(groups, values, ties, draws, strict=True):
            ranking = sorted(range(len(group)), key=lambda i: (value[i][objective], tie[i]))
            accepted = ranking[inverse_of_power_law(draw, len(group), tau) - 1]
            self.point[group[accepted][0]] = group[accepted][1]
            self.current = value[accepted]
        self.path.append(list(self.point))
        return self

    def adapt(self, objective, values):
        reference = (self.best if self.tau == "a-geo1" else self.current)[objective]
        chance = sum(value[objective] < reference for value in values) / len(values)
        uniform, normal = self.stream.random(), self.stream.standard_normal()
        if chance == 0:
            self.adaptive_tau[objective] = 0.5 * math.exp(normal / math.sqrt(self.moves.length))
        elif chance <= self.chance[objective]:
            self.adaptive_tau[objective] += (0.5 + chance) * uniform
        self.chance[objective] = chance
        self.taus.append(list(self.adaptive_tau))
        return self.adaptive_tau[objective]

    def update_best(self, values):
        self.best = [min(column) for column in zip(self.best, *values, strict=True)]


def inverse_of_power_law(u, n, tau):
    """Return the rank in 1..n at which the cumulative probability of k^-tau exceeds u."""
    total = sum(k**-tau for k in range(1, n + 1))
    cumulative = 0.0
    for k in range(1, n + 1):
        cumulative += k**-tau
        if u * total < cumulative:
            return k
    return n
