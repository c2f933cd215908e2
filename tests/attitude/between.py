"""Where between samples a direction is nearest to a body axis, by scipy's root finder."""

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

#: Steps looked into: those at whose ends the angle is worst.
LOOKED_INTO = 8


def worst_excess(C, directions, axis, radii=0.0, covariances=None, inside=False):
    """Greatest 1-sigma less angle [rad] of a run, or to keep inside of both together.

    Parameters
    ----------
    C, directions, radii, covariances
        At n samples: GCRS to body, shape (n, 3, 3), unit vectors (n, 3), apparent radii [rad], and
        covariance of the attitude error before each sample (n, 3, 3), none for no margin. In each
        step the body turns at constant rate, and the direction moves along a chord.
    """
    axis, sign = np.array(axis, float), 1.0 if inside else -1.0
    radii = np.broadcast_to(radii, len(C))
    P = np.zeros_like(C) if covariances is None else covariances

    def excess(attitude, direction, radius, sigma=0.0):
        angle = np.arccos(np.clip(attitude @ direction @ axis, -1.0, 1.0)) - radius
        return sigma + sign * angle

    def sigma(attitude, direction, known):
        normal = np.cross(axis, attitude @ direction)
        normal /= np.linalg.norm(normal)
        return np.sqrt(normal @ known @ normal)

    def at(k, part):
        turn = Rotation.from_matrix(C[k] @ C[k + 1].T).as_rotvec()
        s = (1.0 - part) * directions[k] + part * directions[k + 1]
        since = Rotation.from_rotvec((1.0 - part) * turn).as_matrix()
        attitude = Rotation.from_rotvec(-part * turn).as_matrix() @ C[k]
        radius = (1.0 - part) * radii[k] + part * radii[k + 1]
        return attitude, s / np.linalg.norm(s), radius, since @ P[k + 1] @ since.T

    def rises(k, part):
        """Slope of the excess in step k. A minimizer knows its place to a root of the precision."""
        turn = Rotation.from_matrix(C[k] @ C[k + 1].T).as_rotvec()
        attitude, s, *_ = at(k, part)
        chord = directions[k + 1] - directions[k]
        length = np.linalg.norm((1.0 - part) * directions[k] + part * directions[k + 1])
        moves = (chord - s * (s @ chord)) / length
        body = attitude @ s
        cosine = axis @ (attitude @ moves - np.cross(turn, body))
        return -sign * (cosine / np.linalg.norm(np.cross(axis, body)) + radii[k + 1] - radii[k])

    samples = zip(C, directions, radii, P, strict=True)
    ends = [excess(*each, sigma(*each[:2], known)) for *each, known in samples]
    found = [max(ends)]
    worst = np.argsort(ends)[::-1][:LOOKED_INTO, None]
    for k in np.unique(np.clip(worst - [1, 0], 0, len(C) - 2)):
        slopes = [rises(k, part) for part in (0.0, 1.0)]
        if slopes[0] > 0.0 > slopes[1]:
            best = brentq(lambda part, k=k: rises(k, part), 0.0, 1.0, xtol=1e-15)
            *there, known = at(k, best)
            margin = max(sigma(*there[:2], known), sigma(C[k + 1], directions[k + 1], P[k + 1]))
            found.append(excess(*there, margin))
    return max(found)
