"""Independent computation of path constraints in NumPy, to verify the compiled filter."""

import numpy as np
from mgeo_attitude.geometry.rotation import exponential_map
from mgeo_attitude.maneuvers.motion import Motion

PARALLEL = 1e-6


def find_extreme(cone, rotation_vectors, motion):
    start, end, start_radius, end_radius, appears = motion
    axis, sign = np.array(cone.axis), -1.0 if cone.keep_in else 1.0
    angle, change = np.linalg.norm(rotation_vectors, axis=1), end - start
    start_axes = np.einsum("ijk,i->kj", exponential_map(rotation_vectors.T), axis)
    first, last = (
        sign * np.einsum("ki,ki->k", np.cross(rotation_vectors, a), v)
        + sign * np.einsum("ki,ki->k", a, change)
        for a, v in ((start_axes, start), (np.broadcast_to(axis, rotation_vectors.shape), end))
    )
    within = (first > 0.0) & (last < 0.0)
    extreme_angle = np.arctan2(-last * np.sin(angle), first - last * np.cos(angle))
    start_cosine, end_cosine = np.einsum("ki,ki->k", start_axes, start), end @ axis
    is_start = appears & ~within & (sign * start_cosine > sign * end_cosine)
    theta = np.where(within, extreme_angle, np.where(is_start, angle, 0.0))
    theta = theta / np.where(angle > 0.0, angle, 1.0)
    share = np.where(within, last, is_start) / np.where(within, last - first, 1.0)
    rotations = np.moveaxis(exponential_map((theta[:, None] * rotation_vectors).T), -1, 0)
    direction = np.einsum("kij,kj->ki", rotations, end - share[:, None] * change)
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    radius = end_radius - share * (end_radius - start_radius)
    return direction / np.where(length > 0.0, length, 1.0), radius, rotations


def compute_monitored_angle(cone, sigmas, rotation_vectors, motion, covariance):
    (direction, radius, rotations), axis = (
        find_extreme(cone, rotation_vectors, motion),
        np.array(cone.axis),
    )
    sine = np.linalg.norm(np.cross(axis, direction), axis=-1)
    angle = np.arctan2(sine, direction @ axis) - radius
    extreme_covariance = rotations @ covariance @ rotations.swapaxes(1, 2)
    margin = sigmas * np.maximum(
        angle_sigma(axis, direction, extreme_covariance), angle_sigma(axis, motion.end, covariance)
    )
    monitored_angle = margin + angle if cone.keep_in else margin - angle
    return np.where(direction.any(axis=-1), monitored_angle, -np.inf)


def angle_sigma(axis, direction, covariance):
    normal = np.cross(axis, direction)
    sine = np.linalg.norm(normal, axis=-1)
    parallel = sine < PARALLEL
    unit = normal / np.where(parallel, 1.0, sine)[:, None]
    variance = np.einsum("ki,kij,kj->k", unit, covariance, unit)
    projection = np.eye(3) - np.outer(axis, axis)
    variance[parallel] = np.linalg.eigvalsh(projection @ covariance[parallel] @ projection)[:, -1]
    return np.sqrt(variance)


def path_angles(model, history, x):
    """Return the worst angle [rad] of each path constraint along a run of the reference filter."""
    n, angles = len(history.times), []
    rotation_vectors = np.vstack(
        [np.zeros(3), model.step * Motion.from_design(model, x, model.n_steps).rates[: n - 1]]
    )
    for constraint in model.path_constraints:
        cone = constraint.build_cone()
        motion = model.compute_direction_motion(cone.direction, slice(n)).rotate_to_body(
            history.attitude
        )
        monitored_angle = compute_monitored_angle(
            cone,
            constraint.attitude_sigmas,
            rotation_vectors,
            motion,
            history.predicted_attitude_covariance,
        ).max()
        angles.append(monitored_angle if constraint.keep_in else -monitored_angle)
    return angles
