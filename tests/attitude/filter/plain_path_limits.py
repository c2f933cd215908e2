"""Independent computation of path constraints in NumPy, to verify the compiled filter."""

import numpy as np
from mgeo_attitude.geometry.rotation import exponential_map
from mgeo_attitude.maneuvers.motion import Motion

PARALLEL = 1e-6


def nearest(cone, turn, passage):
    before, after, radius_before, radius_after, appears = passage
    axis, sign = np.array(cone.axis), -1.0 if cone.keep_in else 1.0
    angle, moved = np.linalg.norm(turn, axis=1), after - before
    started = np.einsum("ijk,i->kj", exponential_map(turn.T), axis)
    first, last = (
        sign * np.einsum("ki,ki->k", np.cross(turn, a), v) + sign * np.einsum("ki,ki->k", a, moved)
        for a, v in ((started, before), (np.broadcast_to(axis, turn.shape), after))
    )
    within = (first > 0.0) & (last < 0.0)
    left = np.arctan2(-last * np.sin(angle), first - last * np.cos(angle))
    at_first, at_last = np.einsum("ki,ki->k", started, before), after @ axis
    begins = appears & ~within & (sign * at_first > sign * at_last)
    theta = np.where(within, left, np.where(begins, angle, 0.0))
    theta = theta / np.where(angle > 0.0, angle, 1.0)
    share = np.where(within, last, begins) / np.where(within, last - first, 1.0)
    back = np.moveaxis(exponential_map((theta[:, None] * turn).T), -1, 0)
    seen = np.einsum("kij,kj->ki", back, after - share[:, None] * moved)
    length = np.linalg.norm(seen, axis=1, keepdims=True)
    radius = radius_after - share * (radius_after - radius_before)
    return seen / np.where(length > 0.0, length, 1.0), radius, back


def excess(cone, sigmas, turn, passage, covariance):
    (seen, radius, back), axis = nearest(cone, turn, passage), np.array(cone.axis)
    sine = np.linalg.norm(np.cross(axis, seen), axis=-1)
    angle = np.arctan2(sine, seen @ axis) - radius
    known = back @ covariance @ back.swapaxes(1, 2)
    margin = sigmas * np.maximum(
        angle_sigma(axis, seen, known), angle_sigma(axis, passage.end, covariance)
    )
    found = margin + angle if cone.keep_in else margin - angle
    return np.where(seen.any(axis=-1), found, -np.inf)


def angle_sigma(axis, direction, covariance):
    normal = np.cross(axis, direction)
    sine = np.linalg.norm(normal, axis=-1)
    parallel = sine < PARALLEL
    unit = normal / np.where(parallel, 1.0, sine)[:, None]
    variance = np.einsum("ki,kij,kj->k", unit, covariance, unit)
    across = np.eye(3) - np.outer(axis, axis)
    variance[parallel] = np.linalg.eigvalsh(across @ covariance[parallel] @ across)[:, -1]
    return np.sqrt(variance)


def path_angles(model, run, x):
    """Return the worst angle [rad] of each path constraint along a run of the reference filter."""
    n, found = len(run.times), []
    turn = np.vstack(
        [np.zeros(3), model.step * Motion.from_design(model, x, model.n_steps).rates[: n - 1]]
    )
    for limit in model.path_constraints:
        cone = limit.build_cone()
        passage = model.compute_direction_motion(cone.direction, slice(n)).rotate_to_body(
            run.attitude
        )
        worst = excess(
            cone, limit.attitude_sigmas, turn, passage, run.predicted_attitude_covariance
        ).max()
        found.append(worst if limit.keep_in else -worst)
    return found
