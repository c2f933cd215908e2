"""Information of sensor samples about each 3-vector of the state, valid for any attitude.

The information follows from `Sensor.linearize_measurement`. Whether the information of a sample
depends on the attitude is tested numerically at a few attitudes and samples.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import rotation_matrix, skew
from mgeo_attitude.lower_bound.common_mode import BodyFixedError, InertialErrorInformation
from mgeo_attitude.lower_bound.faces import bound_joint_information
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite

#: Attitudes, as rotation vectors, at which the dependence on the attitude is tested.
_PROBE_ATTITUDES = np.array([[0.4, -1.1, 0.7], [-2.0, 0.3, 0.5], [0.9, 1.3, -1.6], [0.1, 0.2, 2.9]])
#: Largest number of samples at which the dependence on the attitude is tested.
_MAX_PROBE_SAMPLES = 40
#: Difference, relative to the norm, below which a quantity is considered independent of the
#: attitude.
_RELATIVE_TOLERANCE = 1e-10


class NoLowerBoundError(ValueError):
    """Raised if no lower bound can be proved for a scenario.

    The message names the cause.
    """


class BlockInformation(NamedTuple):
    """Fisher information that measurements provide about one state block in each filter sample.

    All other states are assumed known.

    Attributes
    ----------
    trace : array, shape (n_steps + 1,)
        Trace of the information, or an upper bound on it.
    matrix : array, shape (n_steps + 1, 3, 3), or None
        The information itself, if it does not depend on the attitude.
    """

    trace: Floats
    matrix: Floats | None


@dataclass(frozen=True)
class SampleInformation:
    """Fisher information that the sensors provide in each filter sample, as matrices or traces.

    The information is zero in samples without a measurement.

    Attributes
    ----------
    inertial_blocks : tuple of str
        Names of the attitude and of the Gauss-Markov errors fixed in GCRS, about which the
        information in GCRS does not depend on the attitude.
    joint : array, shape (n_steps + 1, 3 m, 3 m)
        Upper bound on the joint information about these m blocks in GCRS.
    attitude_trace : array, shape (n_steps + 1,)
        Upper bound on the trace of the attitude information.
    blocks : dict of str to BlockInformation
        Information about each other block of the sensors and of the environment.
    inertial_errors : tuple of InertialErrorInformation
        Information of each sensor about each inertial block, with the body-fixed errors of the
        sensor that cannot be distinguished from the block at rest.
    anisotropic_sensors : tuple of str
        Sensors whose noise differs between axes, so that the bound is a relaxation.
    """

    inertial_blocks: tuple[str, ...]
    joint: Floats
    attitude_trace: Floats
    blocks: dict[str, BlockInformation]
    inertial_errors: tuple[InertialErrorInformation, ...]
    anisotropic_sensors: tuple[str, ...]


def collect_information(model: FilterModel) -> SampleInformation:
    """Compute upper bounds on the Fisher information that the sensors provide in each filter
    sample.

    The bounds hold at every attitude.

    Raises
    ------
    NoLowerBoundError
        If the information of a sensor depends on the attitude and no bound for it is known.
    """
    for sensitivity in model.suite.gyro.bias_sensitivities:
        raise NoLowerBoundError(
            f"gyro.bias_sensitivities: no lower bound is known, because the effect of "
            f"{sensitivity.channel} on the attitude changes with time. Remove the bias sensitivity"
        )
    diodes = [i for i, sensor in enumerate(model.suite.sensors) if isinstance(sensor, Photodiode)]
    other_sensors = [i for i in range(len(model.suite.sensors)) if i not in diodes]
    diode_parts = [_collect_diodes(model, diodes)] if diodes else []
    parts = [_collect_sensor(model, index) for index in other_sensors] + diode_parts
    body_fixed = {name for part in parts for name in part.blocks}
    # A block counts as inertial only if it is inertial for every sensor that shares it.
    if shared_blocks := body_fixed.intersection(
        name for part in parts for name in part.inertial_blocks
    ):
        parts = [
            _collect_sensor(model, index, shared_blocks) for index in other_sensors
        ] + diode_parts
    inertial = tuple(dict.fromkeys(name for part in parts for name in part.inertial_blocks))
    n = len(model.references)
    joint = np.zeros((n, 3 * len(inertial), 3 * len(inertial)))
    for part in parts:
        indices = np.concatenate(
            [3 * inertial.index(name) + np.arange(3) for name in part.inertial_blocks]
        )
        joint[:, indices[:, None], indices] += part.joint
    return SampleInformation(
        inertial,
        joint,
        np.sum([part.attitude_trace for part in parts], axis=0),
        _sum_information(item for part in parts for item in part.blocks.items()),
        tuple(error for part in parts for error in part.inertial_errors),
        tuple(name for part in parts for name in part.anisotropic_sensors),
    )


def _sum_information(items: Iterable[tuple[str, BlockInformation]]) -> dict[str, BlockInformation]:
    total: dict[str, BlockInformation] = {}
    for name, information in items:
        previous = total.setdefault(name, information)
        if previous is not information:
            parts = [each.matrix for each in (previous, information) if each.matrix is not None]
            matrix = np.add(*parts) if len(parts) == 2 else None
            total[name] = BlockInformation(previous.trace + information.trace, matrix)
    return total


def _collect_sensor(
    model: FilterModel, index: int, excluded: Collection[str] = ()
) -> SampleInformation:
    """Return the Fisher information that one sensor provides in each filter sample.

    Errors in `excluded` are not treated as fixed in inertial axes.
    """
    suite, sensor = model.suite, model.suite.sensors[index]
    probe = _SensorProbe(model, index)
    precision = 1.0 / np.array(sensor.noise_sigmas())
    best_precision = np.full(len(precision), precision.max())
    sensor_blocks = list(suite.list_blocks(sensor).values())
    varying = [name for name in sensor_blocks if name in suite.processes and name not in excluded]
    inertial, joint = _collect_inertial(probe, varying, best_precision)
    attitude, _, is_independent = probe.compute_information(["attitude"], precision)
    if not is_independent:
        attitude = joint[:, :3, :3]
    errors = {
        name: _collect_error(probe, name, precision, best_precision)
        for name in sensor_blocks
        if name not in inertial
    }
    constants = {
        name: information.trace
        for name, information in errors.items()
        if name not in suite.processes
    }
    blocks = np.split(np.diagonal(joint, axis1=1, axis2=2), len(inertial), axis=1)
    return SampleInformation(
        inertial,
        probe.mask_unmeasured(joint),
        probe.mask_unmeasured(np.trace(attitude, axis1=1, axis2=2)),
        errors,
        tuple(
            InertialErrorInformation(
                name,
                probe.mask_unmeasured(block.sum(axis=1)),
                probe.find_similar_errors(name, constants),
            )
            for name, block in zip(inertial, blocks, strict=True)
        ),
        (sensor.name,) if (precision != best_precision).any() else (),
    )


def _collect_inertial(
    probe: _SensorProbe, varying: list[str], best_precision: Floats
) -> tuple[tuple[str, ...], Floats]:
    for names in (["attitude", *varying], ["attitude"]):
        joint, is_independent, _ = probe.compute_information(names, best_precision)
        if is_independent:
            return tuple(names), joint
    raise NoLowerBoundError(_format_reason(probe.sensor, "attitude"))


def _collect_error(
    probe: _SensorProbe, name: str, precision: Floats, best_precision: Floats
) -> BlockInformation:
    # If the trace depends on the attitude, the noise of the best axis is used for all axes.
    for weights in (precision, best_precision):
        information, is_independent, is_trace_independent = probe.compute_information(
            [name], weights
        )
        if is_trace_independent:
            trace = probe.mask_unmeasured(np.trace(information, axis1=1, axis2=2))
            return BlockInformation(
                trace, probe.mask_unmeasured(information) if is_independent else None
            )
    raise NoLowerBoundError(_format_reason(probe.sensor, name))


def _collect_diodes(model: FilterModel, indices: Sequence[int]) -> SampleInformation:
    """Return upper bounds on the Fisher information that all photodiodes provide in each filter
    sample.

    The bounds hold at every attitude. A diode also has information about its own errors, for which
    all other states are assumed known.
    """
    sensors = [model.suite.sensors[index] for index in indices]
    diodes = [sensor for sensor in sensors if isinstance(sensor, Photodiode)]
    errors = model.suite.environment_errors
    for sensor in diodes:
        if sensor.latency_states():
            raise NoLowerBoundError(_format_reason(sensor, f"{sensor.name}.latency"))
        if sensor.includes_albedo and (errors.earth_albedo or errors.albedo):
            raise NoLowerBoundError(
                f"{sensor.name}: no lower bound is known, because the albedo depends on the "
                "attitude. Set includes_albedo = false"
            )
    is_available_in_sample = model.available[:, indices].copy()
    is_available_in_sample[0] = False
    sun = model.references[:, indices[0]]
    projection = np.eye(3) - sun[:, :, None] * sun[:, None]
    bound = np.where(is_available_in_sample.any(axis=1), bound_joint_information(diodes), 0.0)
    return SampleInformation(
        ("attitude",),
        bound[:, None, None] * projection,
        2.0 * bound,
        {
            f"{sensor.name}.sensitivity": BlockInformation(
                is_available / sensor.relative_noise**2, None
            )
            for sensor, is_available in zip(diodes, is_available_in_sample.T, strict=True)
        },
        (InertialErrorInformation("attitude", 2.0 * bound, {}),),
        (),
    )


class _SensorProbe:
    """Probe that tests whether the information from a sensor depends on the attitude.

    The measurement matrices of the sensor are computed at the identity attitude in all samples, and
    at a few test attitudes in some samples.
    """

    def __init__(self, model: FilterModel, index: int) -> None:
        self.sensor = model.suite.sensors[index]
        self._suite = Suite(model.suite.gyro, (self.sensor,), model.suite.environment_errors)
        self._vectors = model.references[:, model.suite.list_vector_indices(index)]
        self._sensitivity_factors = model.sensitivity_factors[
            :, model.suite.find_sensitivity_columns(self.sensor)
        ]
        self._is_measured = model.available[:, index].copy()
        self._is_measured[0] = False  # The first measurement is one step after the start.
        measured = np.flatnonzero(self._is_measured)
        positions = np.linspace(
            0, len(measured) - 1, min(len(measured), _MAX_PROBE_SAMPLES)
        ).astype(int)
        self._probe_samples = measured[positions]
        self._unrotated_columns = self._compute_columns(np.eye(3))
        self._rotated_columns = [
            self._compute_columns(rotation_matrix(probe), self._probe_samples, probe)
            for probe in _PROBE_ATTITUDES
        ]

    def _compute_columns(
        self, C: Floats, samples: slice | np.ndarray = slice(None), rate: Floats | None = None
    ) -> dict[str, Floats]:
        """Return a dict that maps each state block to its columns of the measurement matrix at the
        attitude C.

        The attitude error is expressed in GCRS.
        """
        v, *auxiliary_vectors = np.moveaxis(self._vectors[samples] @ C.T, 1, 0)
        rates = None if rate is None else np.broadcast_to(rate, v.shape)
        deviations = [*self._sensitivity_factors[samples].T]
        H = self._suite.measurement_matrix(self.sensor, v, C, auxiliary_vectors, rates, deviations)
        blocks = {name: H[..., 3 * i : 3 * i + 3] for i, name in enumerate(self._suite.blocks)}
        return blocks | {"attitude": blocks["attitude"] @ C}

    def compute_information(self, names: list[str], weights: Floats) -> tuple[Floats, bool, bool]:
        """Return the information matrix of several state blocks at each sample, and whether it
        depends on the attitude.

        The first flag is True if the matrix is the same at all test attitudes. The second flag is
        True if at least its trace is the same.
        """
        information = _compute_information(self._unrotated_columns, names, weights)
        rotated = np.array(
            [_compute_information(each, names, weights) for each in self._rotated_columns]
        )
        return information, *_compare_information(rotated, information[self._probe_samples])

    def mask_unmeasured(self, values: Floats) -> Floats:
        """Return a copy of an array with zeros at the samples without a measurement."""
        return np.where(self._is_measured.reshape(-1, *[1] * (values.ndim - 1)), values, 0.0)

    def find_similar_errors(
        self, inertial_error: str, traces: dict[str, Floats]
    ) -> dict[str, BodyFixedError]:
        """Find the body-fixed errors that measurements cannot distinguish from an inertial error.

        The errors can be distinguished only if the body rotates. The result is a dict keyed by
        state block.
        """
        unrotated = {name: H[self._probe_samples] for name, H in self._unrotated_columns.items()}
        attitudes = [
            (np.eye(3), unrotated),
            *zip(map(rotation_matrix, _PROBE_ATTITUDES), self._rotated_columns, strict=True),
        ]
        v = self._vectors[:, 0]
        return {
            block: BodyFixedError(trace, vectors)
            for block, trace in traces.items()
            for vectors in (None, v)
            if _is_similar(
                attitudes,
                block,
                inertial_error,
                None if vectors is None else vectors[self._probe_samples],
            )
        }


def _compute_information(columns: dict[str, Floats], names: list[str], precision: Floats) -> Floats:
    H = np.concatenate([columns[name] for name in names], axis=2) * precision[:, None]
    information: Floats = np.einsum("kia,kib->kab", H, H)
    return information


def _compare_information(probe_information: Floats, information: Floats) -> tuple[bool, bool]:
    tolerance = _RELATIVE_TOLERANCE * np.trace(information, axis1=1, axis2=2)
    difference = np.abs(probe_information - information).max(axis=(0, 2, 3), initial=0.0)
    traces = np.trace(probe_information - information, axis1=2, axis2=3)
    return bool((difference <= tolerance).all()), bool((np.abs(traces) <= tolerance).all())


def _is_similar(
    attitudes: Sequence[tuple[Floats, dict[str, Floats]]],
    block: str,
    inertial_error: str,
    v: Floats | None,
) -> bool:
    """Return True if a body-fixed error affects measurements like a rotated inertial error at all
    test attitudes.

    See `InertialErrorInformation`.
    """
    G = np.eye(3) if v is None else np.moveaxis(skew(v.T), -1, 0)
    matches = []
    for C, columns in attitudes:
        body_fixed_columns, inertial_columns = columns[block], columns[inertial_error] @ G @ C.T
        tolerance = _RELATIVE_TOLERANCE * np.linalg.norm(
            body_fixed_columns, axis=(1, 2), keepdims=True
        )
        matches.append(
            [
                (np.abs(body_fixed_columns - sign * inertial_columns) <= tolerance).all()
                for sign in (1.0, -1.0)
            ]
        )
    return bool(np.all(matches, axis=0).any())


def _format_reason(sensor: Sensor, block: str) -> str:
    return (
        f"{sensor.name}: no lower bound is known, because the information about {block} depends "
        "on the attitude in a way other than a rotation"
    )
