"""Basilisk's sensors with errors that were drawn, and what they report in the filter's units."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

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


@dataclass(frozen=True)
class Instrument:
    """A sensor of Basilisk.

    Attributes
    ----------
    modules : sequence
        To be run in each step.
    records : mapping
        Recorders of their messages.
    vectors : function
        What they report as the filter takes it, shape (n, k, 3), from the records; NaN for nothing.
    parts : sequence
        What modules point to, and nothing else keeps.
    """

    modules: Sequence[Any]
    records: Mapping[str, Any]
    vectors: Callable[[Mapping[str, Any]], Floats]
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

    def vectors(of: Mapping[str, Any]) -> Floats:
        found: Floats = of[sensor.name].tam_S[:, None] / _TESLA
        return found

    return Instrument([tam], {sensor.name: tam.tamDataOutMsg.recorder()}, vectors)


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
    records = _records(sensor, array.constellationOutMsg, sources)
    records[f"{sensor.name} Sun"] = sources.surroundings.unit_sun.recorder()

    def vectors(of: Mapping[str, Any]) -> Floats:
        cosines = of[sensor.name].CosValue[:, :6]
        found = cosines[:, 0::2] - cosines[:, 1::2]
        reported: Floats = np.where(_seen(sensor, of)[:, None], found, np.nan)
        if sensor.unit_length:
            reported /= np.linalg.norm(reported, axis=1, keepdims=True)
        return reported[:, None]

    return Instrument([array], records, vectors, heads)


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

    def vectors(of: Mapping[str, Any]) -> Floats:
        reported: Floats = np.where(_in_light(sensor, of), of[sensor.name].OutputData, np.nan)
        return reported[:, None, None]

    return Instrument([head], _records(sensor, head.cssDataOutMsg, sources), vectors)


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


def _records(sensor: Sensor, message: Any, sources: Sources) -> dict[str, Any]:
    """Of its own message, of the satellite, and of the shadow if there is one."""
    records = {
        sensor.name: message.recorder(),
        f"{sensor.name} state": sources.satellite.scStateOutMsg.recorder(),
    }
    if sources.shadow is not None:
        records[f"{sensor.name} light"] = sources.shadow.eclipseOutMsgs[0].recorder()
    return records


def _in_light(sensor: Sensor, of: Mapping[str, Any]) -> Bools:
    """Where the Sun shines, whole."""
    light = of.get(f"{sensor.name} light")
    if light is None:
        return np.ones(len(of[sensor.name].times()), bool)
    whole: Bools = light.illuminationFactor >= 1.0
    return whole


def _seen(sensor: SunSensor, of: Mapping[str, Any]) -> Bools:
    """Where it does so within the field of view."""
    seen = _in_light(sensor, of)
    for view in sensor.views():
        state, sun = of[f"{sensor.name} state"], of[f"{sensor.name} Sun"]
        to_sun = sun.PositionVector - state.r_BN_N
        to_sun /= np.linalg.norm(to_sun, axis=1, keepdims=True)
        in_body = Rotation.from_mrp(state.sigma_BN).inv().apply(to_sun)
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

    def vectors(of: Mapping[str, Any]) -> Floats:
        q = of[sensor.name].qInrtl2Case
        turned: Floats = np.full((len(q), 3, 3), np.nan)
        turned[1:] = Rotation.from_quat(q[1:], scalar_first=True).as_matrix()
        return turned

    return Instrument([tracker], {sensor.name: tracker.sensorOutMsg.recorder()}, vectors)


Maker = Callable[[Any, Errors, Sources, Callable[[], int]], Instrument]

#: What Basilisk has for each class of sensors.
INSTRUMENTS: Mapping[type[Sensor], Maker] = {
    Magnetometer: three_axis_magnetometer,
    SunSensor: coarse_sun_sensors,
    TwoAxisSunSensor: coarse_sun_sensors,
    Photodiode: photodiode,
    StarTracker: star_tracker,
}
