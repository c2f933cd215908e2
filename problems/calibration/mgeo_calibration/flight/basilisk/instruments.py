"""Basilisk's sensors with errors that were drawn, and what they report in the filter's units."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from Basilisk.simulation import coarseSunSensor, imuSensor, magnetometer, starTracker
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.geometry.rotation import matrix
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.star_tracker import StarTracker
from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor
from mgeo_attitude.sensors.world import FIELD_UNIT_NT
from scipy.spatial.transform import Rotation

from mgeo_calibration.flight.basilisk.surroundings import Surroundings

#: A bound of noise that is never reached: Basilisk clips at it.
NO_BOUND = 1e9

#: A Gauss-Markov process that forgets at once: Basilisk's own default never does.
WHITE = np.zeros((3, 3)).tolist()

_TESLA = 1e-9 * FIELD_UNIT_NT


@dataclass(frozen=True)
class Sources:
    """What sensors look at.

    Attributes
    ----------
    field, shadow : modules
        Of Basilisk; None where the scenario needs none.
    """

    satellite: Any
    surroundings: Surroundings
    field: Any
    shadow: Any


class Log(NamedTuple):
    """Recorders of the satellite, of the Sun, and of the Earth's shadow, None without one."""

    state: Any
    sun: Any
    light: Any


@dataclass(frozen=True)
class Instrument:
    """A sensor of Basilisk.

    Attributes
    ----------
    module : module
        To be run in each step.
    message : message
        What it reports.
    vectors : function
        The filter's readings, shape (n, k, 3), of what was recorded of the message and of all
        else; NaN where there is none.
    parts : sequence
        What the module points to, and nothing else keeps.
    """

    module: Any
    message: Any
    vectors: Callable[[Any, Log], Floats]
    parts: Sequence[Any] = ()


Errors = Mapping[str, Floats]


def rate_gyro(gyro: Gyro, errors: Errors, step: float, sources: Sources, seed: int) -> Any:
    """Basilisk's inertial measurement unit; the bias is set from step to step, before scaling.

    Its axes are scaled after they are misaligned, ours before: k ∘ R(μ) ω is R(μ) (k ∘ ω) but for
    the product of both errors, 1e-5 of the rate.
    """
    imu = imuSensor.ImuSensor()
    imu.ModelTag, imu.RNGSeed = "gyro", seed
    imu.scStateInMsg.subscribeTo(sources.satellite.scStateOutMsg)
    noise = np.sqrt(np.array(gyro.diffusion()["theta"]) / step)
    scale = 1.0 + errors.get("scale_factor", np.zeros(3))
    imu.setAMatrixGyro(WHITE)
    imu.PMatrixGyro = np.diag(noise / scale).tolist()
    imu.setErrorBoundsGyro([NO_BOUND] * 3)
    imu.setWalkBoundsGyro([NO_BOUND] * 3)
    imu.senRotMax = imu.senTransMax = NO_BOUND
    imu.gyroScale = scale.tolist()
    imu.dcm_PB = matrix(errors.get("misalignment", np.zeros(3))).tolist()
    return imu


def three_axis_magnetometer(
    sensor: Magnetometer, errors: Errors, sources: Sources, seeds: Callable[[], int]
) -> Instrument:
    """Basilisk's magnetometer."""
    tam = magnetometer.Magnetometer()
    tam.ModelTag, tam.RNGSeed = sensor.name, seeds()
    tam.stateInMsg.subscribeTo(sources.satellite.scStateOutMsg)
    tam.magInMsg.subscribeTo(sources.field.envOutMsgs[0])
    tam.dcm_SB = matrix(errors.get("misalignment", np.zeros(3))).tolist()
    tam.senBias = (_TESLA * errors["bias"]).tolist()
    tam.senNoiseStd = (_TESLA * np.array(sensor.noise())).tolist()
    tam.setAMatrix(WHITE)
    tam.walkBounds = [NO_BOUND] * 3

    def vectors(own: Any, log: Log) -> Floats:
        found: Floats = own.tam_S[:, None] / _TESLA
        return found

    return Instrument(tam, tam.tamDataOutMsg, vectors)


def coarse_sun_sensors(
    sensor: SunSensor, errors: Errors, sources: Sources, seeds: Callable[[], int]
) -> Instrument:
    """Six of Basilisk's coarse Sun sensors, looking both ways along three axes, as one vector.

    Each component is the difference of two heads, so that each has half of its bias and 1/√2 of its
    noise. They report in full sunlight: in the penumbra the vector would be short. Of a sensor that
    measures two angles the length says nothing.
    """
    heads, mount = [], matrix(errors.get("misalignment", np.zeros(3)))
    each = (*sensor.noise(), sensor.noise()[-1])[:3]  # of two angles they are alike
    for axis, bias, noise in zip(mount, errors["bias"], each, strict=True):
        for sign in (1.0, -1.0):
            head = _head(sign * axis, sources, seeds())
            head.senBias, head.senNoiseStd = float(sign * bias / 2.0), noise / math.sqrt(2.0)
            heads.append(head)
    array = coarseSunSensor.CSSConstellation()
    array.ModelTag, array.sensorList = sensor.name, coarseSunSensor.CSSVector(heads)

    def vectors(own: Any, log: Log) -> Floats:
        cosines = own.CosValue[:, :6]
        found = cosines[:, 0::2] - cosines[:, 1::2]
        reported: Floats = np.where(_seen(sensor, log)[:, None], found, np.nan)
        if sensor.unit_length:
            reported /= np.linalg.norm(reported, axis=1, keepdims=True)
        return reported[:, None]

    return Instrument(array, array.constellationOutMsg, vectors, heads)


def photodiode(
    sensor: Photodiode, errors: Errors, sources: Sources, seeds: Callable[[], int]
) -> Instrument:
    """One of Basilisk's coarse Sun sensors, which reads zero in the dark, but for noise.

    Its cosine is that of any angle to 90 deg: what is beyond the half-angle is told, too. It does
    not report while it is not in full sunlight.
    """
    along = sensor.axes[2] + errors["sensitivity"] @ sensor.axes
    gain = float(np.linalg.norm(along))
    head = _head(along / gain, sources, seeds())
    head.ModelTag, head.scaleFactor = sensor.name, gain
    head.senNoiseStd = sensor.relative_noise / gain  # which is scaled, too

    def vectors(own: Any, log: Log) -> Floats:
        reported: Floats = np.where(_in_light(log), own.OutputData, np.nan)
        return reported[:, None, None]

    return Instrument(head, head.cssDataOutMsg, vectors)


def _head(normal: Floats, sources: Sources, seed: int) -> Any:
    """One of Basilisk's coarse Sun sensors, which sees half of the sky, without any bound."""
    head = coarseSunSensor.CoarseSunSensor()
    head.RNGSeed, head.fov, head.nHat_B = seed, math.pi / 2, normal.tolist()
    head.setAMatrix([[0.0]])
    head.walkBounds = head.maxOutput = NO_BOUND
    head.minOutput = -NO_BOUND
    head.sunInMsg.subscribeTo(sources.surroundings.unit_sun)
    head.stateInMsg.subscribeTo(sources.satellite.scStateOutMsg)
    return head


def _in_light(log: Log) -> Bools:
    """Return where the whole Sun shines."""
    if log.light is None:
        return np.ones(len(log.state.times()), bool)
    whole: Bools = log.light.illuminationFactor >= 1.0
    return whole


def _seen(sensor: SunSensor, log: Log) -> Bools:
    """Return where the whole Sun shines within the field of view."""
    seen = _in_light(log)
    to_sun = log.sun.PositionVector - log.state.r_BN_N
    to_sun /= np.linalg.norm(to_sun, axis=1, keepdims=True)
    in_body = Rotation.from_mrp(log.state.sigma_BN).inv().apply(to_sun)
    for view in sensor.views():
        seen &= in_body @ view.axis >= np.cos(view.half_angle)
    return seen


def star_tracker(
    sensor: StarTracker, errors: Errors, sources: Sources, seeds: Callable[[], int]
) -> Instrument:
    """Basilisk's star tracker, which reports always: `fly` leaves out where it sees no stars."""
    tracker = starTracker.StarTracker()
    tracker.ModelTag, tracker.RNGSeed = sensor.name, seeds()
    tracker.scStateInMsg.subscribeTo(sources.satellite.scStateOutMsg)
    mount = matrix(errors.get("misalignment", np.zeros(3)))
    tracker.dcm_CB = mount.tolist()
    # its noise is a rotation about body axes, ours about the tracker's
    tracker.PMatrix = ((sensor.axes @ mount).T @ np.diag(sensor.noise())).tolist()
    tracker.setAMatrix(WHITE)
    tracker.setWalkBounds([NO_BOUND] * 3)

    def vectors(own: Any, log: Log) -> Floats:
        q = own.qInrtl2Case
        turned: Floats = np.full((len(q), 3, 3), np.nan)
        turned[1:] = Rotation.from_quat(q[1:], scalar_first=True).as_matrix()
        return turned

    return Instrument(tracker, tracker.sensorOutMsg, vectors)


Maker = Callable[[Any, Errors, Sources, Callable[[], int]], Instrument]

#: What Basilisk has for each class of sensors.
INSTRUMENTS: Mapping[type[Sensor], Maker] = {
    Magnetometer: three_axis_magnetometer,
    SunSensor: coarse_sun_sensors,
    TwoAxisSunSensor: coarse_sun_sensors,
    Photodiode: photodiode,
    StarTracker: star_tracker,
}
