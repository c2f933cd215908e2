"""Models of gyro, sensors and environment errors for the independent simulator.

The models follow the equations of the documentation and use SciPy's rotations. They share no code
with the sensors of `mgeo_attitude`, of which they read the parameters only.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.sun_moon import albedo_vector
from scipy.spatial.transform import Rotation

#: Units of the states of magnetometer [nT] and orbit error [m].
FIELD_UNIT, POSITION_UNIT = 50_000.0, 1000.0


def gauss_markov(sigma, correlation_time, n, step, rng) -> np.ndarray:
    """Return n samples of a stationary Gauss-Markov process of three components."""
    decay = np.exp(-step / correlation_time)
    kicks = np.asarray(sigma) * rng.standard_normal((n, 3))
    kicks[1:] *= np.sqrt(1.0 - decay**2)
    for k in range(1, n):
        kicks[k] += decay * kicks[k - 1]
    return kicks


def build_symmetric_matrix(own) -> np.ndarray:
    """Return the matrix I + diag k + N of scale factors k and the non-orthogonality elements yz, zx
    and xy.
    """
    yz, zx, xy = own.get("nonorthogonality", np.zeros(3))
    stretch = np.diag(own.get("scale_factor", np.zeros(3)))
    return np.eye(3) + stretch + np.array([[0.0, xy, zx], [xy, 0.0, yz], [zx, yz, 0.0]])


def gibbs_vector(rotation: Rotation) -> np.ndarray:
    """Return twice the Gibbs vector of a rotation, the representation of rotations in a truth."""
    q = rotation.as_quat(canonical=True)
    return 2.0 * q[:3] / q[3]


def normalized(vectors) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def frame(axis) -> np.ndarray:
    """Return right-handed axes as rows, of which z is the given unit vector."""
    y = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    y /= np.linalg.norm(y)
    return np.array([np.cross(y, axis), y, axis])


def draw_environment_errors(world, n, step, rng) -> dict[str, np.ndarray]:
    """Draw the states of the environment errors of a scenario over n steps, as a dict by name."""
    return {
        state: gauss_markov(process.sigma, process.correlation_time, n, step, rng)
        for state, process in world.states().items()
    }


def displace_environment(scenario: Scenario, around: Environment, orbit_error) -> Environment:
    """Return the environment at positions that are displaced by an orbit error."""
    moved = orbit_error
    if scenario.environment_errors.orbit_error_axes == "orbital":
        up = normalized(around.position)
        normal = normalized(np.cross(up, around.velocity))
        axes = np.stack([np.cross(normal, up), normal, up], axis=1)
        moved = np.einsum("nk,nkj->nj", orbit_error, axes)
    there = Environment.from_times(scenario, around.times, around.position + POSITION_UNIT * moved)
    return there if around.has_eclipses else there.without_eclipses()


@dataclass(frozen=True)
class SensorEnvironment:
    """Environment of a run with its errors in GCRS, one row per sample.

    Attributes
    ----------
    errors : mapping of str to array, shape (n, 3)
        True states of the environment errors.
    """

    around: Environment
    errors: dict[str, np.ndarray]
    earth_albedo: float = 0.0

    @property
    def sun(self) -> np.ndarray:
        return np.array(self.around.sun)

    @property
    def sunlit(self) -> np.ndarray:
        return self.around.sunlit

    @cached_property
    def light(self) -> np.ndarray:
        """Mean albedo light in units of direct sunlight."""
        return self.earth_albedo * albedo_vector(self.around.position, self.sun)

    @property
    def all_light(self) -> np.ndarray:
        return self.light + self.errors.get("albedo", 0.0)

    @property
    def field(self) -> np.ndarray:
        """Magnetic field at the satellite [nT]."""
        return self.around.field + FIELD_UNIT * self.errors.get("field_error", 0.0)


def is_near(vectors, axis, angle_deg) -> np.ndarray:
    """Return a boolean array, True for vectors within an angle of an axis."""
    axis = np.asarray(axis) / np.linalg.norm(axis)
    length = np.linalg.norm(vectors, axis=1)
    return vectors @ axis > np.cos(np.radians(angle_deg)) * length


def sun_sensor(sensor, own, at: SensorEnvironment, to_body: Rotation, rng) -> np.ndarray:
    """Return the vectors of a Sun sensor with albedo, normalized if the sensor reports two
    angles.
    """
    seen = at.sun + at.all_light if sensor.includes_albedo else at.sun
    y = own["turn"].apply(to_body.apply(seen)) + own["bias"]
    if sensor.has_unit_length:
        y = normalized(y)
    y += np.resize(sensor.noise_sigmas(), 3) * rng.standard_normal(y.shape)
    y[~at.sunlit] = np.nan
    if sensor.half_angle_deg < 180.0:
        y[~is_near(to_body.apply(at.sun), sensor.boresight, sensor.half_angle_deg)] = np.nan
    return normalized(y) if sensor.has_unit_length else y


def magnetometer(sensor, own, at: SensorEnvironment, to_body: Rotation, rng) -> np.ndarray:
    field = to_body.apply(at.field) @ build_symmetric_matrix(own).T
    y = own["turn"].apply(field) + FIELD_UNIT * own["bias"]
    return y + FIELD_UNIT * np.array(sensor.noise_sigmas()) * rng.standard_normal(y.shape)


def photodiode(sensor, own, at: SensorEnvironment, to_body: Rotation, rng) -> np.ndarray:
    """Return the readings of a photodiode by the cosine law; albedo counts only from the front of
    the face.
    """
    normal = np.asarray(sensor.normal) / np.linalg.norm(sensor.normal)
    sensitivity = normal + own["sensitivity"] @ frame(normal)
    sun = to_body.apply(at.sun)
    before = to_body.apply(at.light) @ normal >= 0.0
    light = to_body.apply(at.all_light) * (before & sensor.includes_albedo)[:, None]
    y = (sun + light) @ sensitivity + sensor.relative_noise * rng.standard_normal(len(sun))
    y[~(at.sunlit & is_near(sun, normal, sensor.half_angle_deg))] = np.nan
    return y[:, None]


def horizon_sensor(sensor, own, at: SensorEnvironment, to_body: Rotation, rng) -> np.ndarray:
    nadir, sun = (to_body.apply(v) for v in (-normalized(at.around.position), at.sun))
    y = own["turn"].apply(nadir) + own["bias"]
    y = normalized(y + np.radians(sensor.noise_deg) * rng.standard_normal(y.shape))
    if sensor.sun_exclusion_deg is not None:
        y[at.sunlit & is_near(sun, sensor.boresight, sensor.sun_exclusion_deg)] = np.nan
    if sensor.half_angle_deg < 180.0:
        y[~is_near(nadir, sensor.boresight, sensor.half_angle_deg)] = np.nan
    return y


def star_tracker(sensor, own, at: SensorEnvironment, to_body: Rotation, rng) -> np.ndarray:
    """Return quaternions from GCRF to body; NaN near the Sun and the Earth's limb."""
    noise = (np.array(sensor.noise_sigmas()) * rng.standard_normal((len(at.sun), 3))) @ frame(
        np.asarray(sensor.boresight) / np.linalg.norm(sensor.boresight)
    )
    y = (to_body.inv() * own["turn"].inv() * Rotation.from_rotvec(noise)).as_quat(canonical=True)
    position = at.around.position
    limb = np.degrees(np.arcsin(EARTH_RADIUS / np.linalg.norm(position, axis=1)))
    nadir, sun = (to_body.apply(v) for v in (-position, at.sun))
    if sensor.sun_exclusion_deg is not None:
        y[at.sunlit & is_near(sun, sensor.boresight, sensor.sun_exclusion_deg)] = np.nan
    if sensor.earth_exclusion_deg is not None:
        y[is_near(nadir, sensor.boresight, limb + sensor.earth_exclusion_deg)] = np.nan
    return y


#: Sensor models: functions of sensor, errors, environment, rotation to body axes and generator.
SENSORS = {
    "sun-sensor": sun_sensor,
    "two-axis-sun-sensor": sun_sensor,
    "photodiode": photodiode,
    "horizon-sensor": horizon_sensor,
    "magnetometer": magnetometer,
    "star-tracker": star_tracker,
}
