"""Basilisk's sensor modules with given errors, and conversion of their messages to readings of the
filter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from Basilisk.simulation import coarseSunSensor, imuSensor, magnetometer, starTracker
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.geometry.rotation import rotation_matrix
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.environment_errors import FIELD_UNIT_NT
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.star_tracker import StarTracker
from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor
from scipy.spatial.transform import Rotation

from mgeo_calibration.simulators.basilisk.environment import EnvironmentMessages

#: Bound of noise and readings that is never reached; Basilisk clips at the bound.
LARGE_BOUND = 1e9

#: Propagation matrix of white noise; Basilisk's default is a random walk.
WHITE_NOISE_MATRIX = np.zeros((3, 3)).tolist()

_TESLA = 1e-9 * FIELD_UNIT_NT


@dataclass(frozen=True)
class SensorInputs:
    """Basilisk modules that provide the input messages of the sensor modules.

    Attributes
    ----------
    satellite : module
    environment : EnvironmentMessages
    field, eclipse : modules
        Basilisk's field and eclipse models; None if the scenario needs none.
    """

    satellite: Any
    environment: EnvironmentMessages
    field: Any
    eclipse: Any


class Recorders(NamedTuple):
    """Basilisk recorders of satellite state, Sun position and, with eclipses, illumination
    factor.
    """

    state: Any
    sun: Any
    illumination: Any


@dataclass(frozen=True)
class SensorModule:
    """Basilisk module of a sensor, with a function that converts its messages to filter readings.

    Attributes
    ----------
    module : module
        Module to execute in each step.
    message : message
        Output message of the module.
    convert : function
        Converts the recorded message and the recorders of `Recorders` to readings of the filter,
        shape (n, k, 3); NaN without a reading.
    referenced_objects : sequence
        Objects that the module points to without owning them.
    """

    module: Any
    message: Any
    convert: Callable[[Any, Recorders], Floats]
    referenced_objects: Sequence[Any] = ()


SensorErrors = Mapping[str, Floats]


def build_gyro(
    gyro: Gyro, errors: SensorErrors, step: float, inputs: SensorInputs, seed: int
) -> Any:
    """Build Basilisk's inertial measurement unit with the noise, scale factors and misalignments of
    a gyro.

    The caller sets the bias in each step, before scaling. Basilisk applies scale factors after the
    misalignment, the filter before it. The difference is the product of both errors, 1e-5 of the
    rate.
    """
    imu = imuSensor.ImuSensor()
    imu.ModelTag, imu.RNGSeed = "gyro", seed
    imu.scStateInMsg.subscribeTo(inputs.satellite.scStateOutMsg)
    noise = np.sqrt(np.array(gyro.compute_noise_density()["theta"]) / step)
    scale = 1.0 + errors.get("scale_factor", np.zeros(3))
    imu.setAMatrixGyro(WHITE_NOISE_MATRIX)
    imu.PMatrixGyro = np.diag(noise / scale).tolist()
    imu.setErrorBoundsGyro([LARGE_BOUND] * 3)
    imu.setWalkBoundsGyro([LARGE_BOUND] * 3)
    imu.senRotMax = imu.senTransMax = LARGE_BOUND
    imu.gyroScale = scale.tolist()
    imu.dcm_PB = rotation_matrix(errors.get("misalignment", np.zeros(3))).tolist()
    return imu


def build_magnetometer(
    sensor: Magnetometer, errors: SensorErrors, inputs: SensorInputs, draw_seed: Callable[[], int]
) -> SensorModule:
    """Build Basilisk's magnetometer module with the given bias and misalignment and the noise of
    the sensor.
    """
    tam = magnetometer.Magnetometer()
    tam.ModelTag, tam.RNGSeed = sensor.name, draw_seed()
    tam.stateInMsg.subscribeTo(inputs.satellite.scStateOutMsg)
    tam.magInMsg.subscribeTo(inputs.field.envOutMsgs[0])
    tam.dcm_SB = rotation_matrix(errors.get("misalignment", np.zeros(3))).tolist()
    tam.senBias = (_TESLA * errors["bias"]).tolist()
    tam.senNoiseStd = (_TESLA * np.array(sensor.noise_sigmas())).tolist()
    tam.setAMatrix(WHITE_NOISE_MATRIX)
    tam.walkBounds = [LARGE_BOUND] * 3

    def convert(message: Any, recorders: Recorders) -> Floats:
        result: Floats = message.tam_S[:, None] / _TESLA
        return result

    return SensorModule(tam, tam.tamDataOutMsg, convert)


def build_sun_sensor(
    sensor: SunSensor, errors: SensorErrors, inputs: SensorInputs, draw_seed: Callable[[], int]
) -> SensorModule:
    """Build a Sun vector sensor from six Basilisk coarse Sun sensors, two in opposite directions
    along each axis.

    Each component is the difference of two heads; a head has half of the bias and 1/√2 of the
    noise. Readings are valid in full sunlight only, because the vector is shorter in the penumbra.
    """
    heads, mount = [], rotation_matrix(errors.get("misalignment", np.zeros(3)))
    # A two-axis sensor has two equal values.
    each = (*sensor.noise_sigmas(), sensor.noise_sigmas()[-1])[:3]
    for axis, bias, noise in zip(mount, errors["bias"], each, strict=True):
        for sign in (1.0, -1.0):
            head = _build_head(sign * axis, inputs, draw_seed())
            head.senBias, head.senNoiseStd = float(sign * bias / 2.0), noise / math.sqrt(2.0)
            heads.append(head)
    array = coarseSunSensor.CSSConstellation()
    array.ModelTag, array.sensorList = sensor.name, coarseSunSensor.CSSVector(heads)

    def convert(message: Any, recorders: Recorders) -> Floats:
        cosines = message.CosValue[:, :6]
        result = cosines[:, 0::2] - cosines[:, 1::2]
        reported: Floats = np.where(
            _find_visible_samples(sensor, recorders)[:, None], result, np.nan
        )
        if sensor.has_unit_length:
            reported /= np.linalg.norm(reported, axis=1, keepdims=True)
        return reported[:, None]

    return SensorModule(array, array.constellationOutMsg, convert, heads)


def build_photodiode(
    sensor: Photodiode, errors: SensorErrors, inputs: SensorInputs, draw_seed: Callable[[], int]
) -> SensorModule:
    """Build a photodiode from a Basilisk coarse Sun sensor, with the given errors of gain and
    normal.

    The half-angle of the field of view is 90 deg. Readings beyond the half-angle of the scenario
    are reported, too. Without full sunlight there are no readings.
    """
    along = sensor.axes[2] + errors["sensitivity"] @ sensor.axes
    gain = float(np.linalg.norm(along))
    head = _build_head(along / gain, inputs, draw_seed())
    head.ModelTag, head.scaleFactor = sensor.name, gain
    head.senNoiseStd = sensor.relative_noise / gain  # Basilisk multiplies the noise by the gain.

    def convert(message: Any, recorders: Recorders) -> Floats:
        reported: Floats = np.where(_find_sunlit_samples(recorders), message.OutputData, np.nan)
        return reported[:, None, None]

    return SensorModule(head, head.cssDataOutMsg, convert)


def _build_head(normal: Floats, inputs: SensorInputs, seed: int) -> Any:
    """Build a Basilisk coarse Sun sensor with a hemispherical field of view."""
    head = coarseSunSensor.CoarseSunSensor()
    head.RNGSeed, head.fov, head.nHat_B = seed, math.pi / 2, normal.tolist()
    head.setAMatrix([[0.0]])
    head.walkBounds = head.maxOutput = LARGE_BOUND
    head.minOutput = -LARGE_BOUND
    head.sunInMsg.subscribeTo(inputs.environment.unit_sun)
    head.stateInMsg.subscribeTo(inputs.satellite.scStateOutMsg)
    return head


def _find_sunlit_samples(recorders: Recorders) -> Bools:
    if recorders.illumination is None:
        return np.ones(len(recorders.state.times()), bool)
    whole: Bools = recorders.illumination.illuminationFactor >= 1.0
    return whole


def _find_visible_samples(sensor: SunSensor, recorders: Recorders) -> Bools:
    """Return a boolean mask of the samples in full sunlight with the Sun in the sensor's field of
    view.
    """
    is_visible = _find_sunlit_samples(recorders)
    to_sun = recorders.sun.PositionVector - recorders.state.r_BN_N
    to_sun /= np.linalg.norm(to_sun, axis=1, keepdims=True)
    in_body = Rotation.from_mrp(recorders.state.sigma_BN).inv().apply(to_sun)
    for view in sensor.list_visibility_cones():
        is_visible &= in_body @ view.axis >= np.cos(view.half_angle)
    return is_visible


def build_star_tracker(
    sensor: StarTracker, errors: SensorErrors, inputs: SensorInputs, draw_seed: Callable[[], int]
) -> SensorModule:
    """Build Basilisk's star tracker module with the given misalignment and the noise of the sensor.

    The module always reports; `telemetry.simulate_telemetry` removes invalid readings.
    """
    tracker = starTracker.StarTracker()
    tracker.ModelTag, tracker.RNGSeed = sensor.name, draw_seed()
    tracker.scStateInMsg.subscribeTo(inputs.satellite.scStateOutMsg)
    mount = rotation_matrix(errors.get("misalignment", np.zeros(3)))
    tracker.dcm_CB = mount.tolist()
    # Basilisk's noise is a rotation about body axes, the filter's about the tracker axes.
    tracker.PMatrix = ((sensor.axes @ mount).T @ np.diag(sensor.noise_sigmas())).tolist()
    tracker.setAMatrix(WHITE_NOISE_MATRIX)
    tracker.setWalkBounds([LARGE_BOUND] * 3)

    def convert(message: Any, recorders: Recorders) -> Floats:
        q = message.qInrtl2Case
        attitude: Floats = np.full((len(q), 3, 3), np.nan)
        attitude[1:] = Rotation.from_quat(q[1:], scalar_first=True).as_matrix()
        return attitude

    return SensorModule(tracker, tracker.sensorOutMsg, convert)


SensorBuilder = Callable[[Any, SensorErrors, SensorInputs, Callable[[], int]], SensorModule]

#: Factory of the Basilisk module of each sensor class.
SENSOR_BUILDERS: Mapping[type[Sensor], SensorBuilder] = {
    Magnetometer: build_magnetometer,
    SunSensor: build_sun_sensor,
    TwoAxisSunSensor: build_sun_sensor,
    Photodiode: build_photodiode,
    StarTracker: build_star_tracker,
}
