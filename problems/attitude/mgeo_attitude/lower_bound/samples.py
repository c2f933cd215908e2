"""Information of sensor samples about each 3-vector of the state, at any attitude.

Everything follows from `measure` of the sensors. Whether the information of a sample depends on the
attitude is tested numerically at a few attitudes and samples.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import rotation_matrix, skew
from mgeo_attitude.lower_bound.common_mode import BodyFixedError, CarrierInformation
from mgeo_attitude.lower_bound.faces import bound_joint_information as of_faces
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite

#: Attitudes, as rotation vectors, at which attitude dependence is tested.
_PROBE_ATTITUDES = np.array([[0.4, -1.1, 0.7], [-2.0, 0.3, 0.5], [0.9, 1.3, -1.6], [0.1, 0.2, 2.9]])
#: Largest number of samples at which attitude dependence is tested.
_MAX_PROBE_SAMPLES = 40
#: Difference, relative to the norm, below which a quantity counts as attitude-independent.
_RELATIVE_TOLERANCE = 1e-10


class NoLowerBoundError(ValueError):
    """Raised if no lower bound can be proved; the message names the cause."""


class BlockInformation(NamedTuple):
    """Information about a 3-vector in each sample if all other states are known.

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
    """Information of all sensors in each sample, zero without a sample.

    Attributes
    ----------
    inertial_blocks : tuple of str
        The attitude, and Gauss-Markov errors fixed in GCRS: blocks whose information in GCRS does
        not depend on the attitude.
    joint : array, shape (n_steps + 1, 3 m, 3 m)
        Upper bound on the joint information about these m blocks in GCRS.
    attitude_trace : array, shape (n_steps + 1,)
        Upper bound on the trace of the attitude information.
    blocks : dict of Told
        Information about each other block of the sensors and of the environment.
    carriers : tuple of Look
        Information of each sensor about each inertial block, with the errors that it may confuse
        with the block.
    anisotropic_sensors : tuple of str
        Sensors whose noise differs between axes, so that the bound is a relaxation.
    """

    inertial_blocks: tuple[str, ...]
    joint: Floats
    attitude_trace: Floats
    blocks: dict[str, BlockInformation]
    carriers: tuple[CarrierInformation, ...]
    anisotropic_sensors: tuple[str, ...]


def collect_information(model: FilterModel) -> SampleInformation:
    """Return the information of all samples of a model.

    Raises
    ------
    NoLowerBoundError
        If the information of a sensor depends on the attitude and no bound for it is known.
    """
    for influence in model.suite.gyro.bias_sensitivities:
        raise NoLowerBoundError(
            f"gyro.bias_sensitivities: no lower bound is known, because the effect of "
            f"{influence.channel} on the attitude changes with time. Remove the bias sensitivity"
        )
    diodes = [i for i, each in enumerate(model.suite.sensors) if isinstance(each, Photodiode)]
    other_sensors = [i for i in range(len(model.suite.sensors)) if i not in diodes]
    faces = [_collect_diodes(model, diodes)] if diodes else []
    parts = [_collect_sensor(model, index) for index in other_sensors] + faces
    own = {name for each in parts for name in each.blocks}
    # A block counts as inertial only if it is inertial for every sensor that shares it.
    if shared_blocks := own.intersection(name for each in parts for name in each.inertial_blocks):
        parts = [_collect_sensor(model, index, shared_blocks) for index in other_sensors] + faces
    inertial = tuple(dict.fromkeys(name for each in parts for name in each.inertial_blocks))
    n = len(model.references)
    together = np.zeros((n, 3 * len(inertial), 3 * len(inertial)))
    for each in parts:
        places = np.concatenate(
            [3 * inertial.index(name) + np.arange(3) for name in each.inertial_blocks]
        )
        together[:, places[:, None], places] += each.joint
    return SampleInformation(
        inertial,
        together,
        np.sum([each.attitude_trace for each in parts], axis=0),
        _sum_information(told for each in parts for told in each.blocks.items()),
        tuple(look for each in parts for look in each.carriers),
        tuple(name for each in parts for name in each.anisotropic_sensors),
    )


def _sum_information(items: Iterable[tuple[str, BlockInformation]]) -> dict[str, BlockInformation]:
    total: dict[str, BlockInformation] = {}
    for name, told in items:
        known = total.setdefault(name, told)
        if known is not told:
            parts = [each.matrix for each in (known, told) if each.matrix is not None]
            matrix = np.add(*parts) if len(parts) == 2 else None
            total[name] = BlockInformation(known.trace + told.trace, matrix)
    return total


def _collect_sensor(
    model: FilterModel, index: int, excluded: Collection[str] = ()
) -> SampleInformation:
    """Return the information of one sensor; blocks in `excluded` do not count as inertial."""
    suite, sensor = model.suite, model.suite.sensors[index]
    probed = _SensorProbe(model, index)
    precision = 1.0 / np.array(sensor.noise_sigmas())
    best_precision = np.full(len(precision), precision.max())
    own = list(suite.list_blocks(sensor).values())
    varying = [name for name in own if name in suite.processes and name not in excluded]
    inertial, together = _collect_inertial(probed, varying, best_precision)
    attitude, _, same = probed.compute_information(["attitude"], precision)
    if not same:
        attitude = together[:, :3, :3]
    each = {
        name: _collect_error(probed, name, precision, best_precision)
        for name in own
        if name not in inertial
    }
    constants = {name: told.trace for name, told in each.items() if name not in suite.processes}
    blocks = np.split(np.diagonal(together, axis1=1, axis2=2), len(inertial), axis=1)
    return SampleInformation(
        inertial,
        probed.mask_unmeasured(together),
        probed.mask_unmeasured(np.trace(attitude, axis1=1, axis2=2)),
        each,
        tuple(
            CarrierInformation(
                name,
                probed.mask_unmeasured(block.sum(axis=1)),
                probed.find_similar_errors(name, constants),
            )
            for name, block in zip(inertial, blocks, strict=True)
        ),
        (sensor.name,) if (precision != best_precision).any() else (),
    )


def _collect_inertial(
    probe: _SensorProbe, varying: list[str], best_precision: Floats
) -> tuple[tuple[str, ...], Floats]:
    for names in (["attitude", *varying], ["attitude"]):
        together, same, _ = probe.compute_information(names, best_precision)
        if same:
            return tuple(names), together
    raise NoLowerBoundError(_format_reason(probe.sensor, "attitude"))


def _collect_error(
    probe: _SensorProbe, name: str, precision: Floats, best_precision: Floats
) -> BlockInformation:
    """Return the information about one error of a sensor.

    If its trace depends on the attitude, all axes count with the noise of the best axis.
    """
    for weights in (precision, best_precision):
        information, same, same_trace = probe.compute_information([name], weights)
        if same_trace:
            trace = probe.mask_unmeasured(np.trace(information, axis1=1, axis2=2))
            return BlockInformation(trace, probe.mask_unmeasured(information) if same else None)
    raise NoLowerBoundError(_format_reason(probe.sensor, name))


def _collect_diodes(model: FilterModel, indices: Sequence[int]) -> SampleInformation:
    """Return the joint information of all photodiodes.

    Each diode has the information w s sᵀ about its own errors if all other states are known.
    """
    sensors = [model.suite.sensors[index] for index in indices]
    lit = [sensor for sensor in sensors if isinstance(sensor, Photodiode)]
    world = model.suite.environment_errors
    for sensor in lit:
        if sensor.latency_states():
            raise NoLowerBoundError(_format_reason(sensor, f"{sensor.name}.latency"))
        if sensor.includes_albedo and (world.earth_albedo or world.albedo):
            raise NoLowerBoundError(
                f"{sensor.name}: no lower bound is known, because the albedo depends on the "
                "attitude. Set includes_albedo = false"
            )
    seen = model.available[:, indices].copy()
    seen[0] = False
    sun = model.references[:, indices[0]]
    across = np.eye(3) - sun[:, :, None] * sun[:, None]
    largest = np.where(seen.any(axis=1), of_faces(lit), 0.0)
    return SampleInformation(
        ("attitude",),
        largest[:, None, None] * across,
        2.0 * largest,
        {
            f"{sensor.name}.sensitivity": BlockInformation(
                is_available / sensor.relative_noise**2, None
            )
            for sensor, is_available in zip(lit, seen.T, strict=True)
        },
        (CarrierInformation("attitude", 2.0 * largest, {}),),
        (),
    )


class _SensorProbe:
    """Measurement matrices of one sensor, unrotated in all samples and at `_PROBES` in some."""

    def __init__(self, model: FilterModel, index: int) -> None:
        self.sensor = model.suite.sensors[index]
        self._suite = Suite(model.suite.gyro, (self.sensor,), model.suite.environment_errors)
        self._vectors = model.references[:, model.suite.list_vector_indices(index)]
        self._sensitivity_factors = model.sensitivity_factors[
            :, model.suite.find_sensitivity_columns(self.sensor)
        ]
        self._is_measured = model.available[:, index].copy()
        self._is_measured[0] = False  # The first update is one step after the start.
        measured = np.flatnonzero(self._is_measured)
        places = np.linspace(0, len(measured) - 1, min(len(measured), _MAX_PROBE_SAMPLES)).astype(
            int
        )
        self._probe_samples = measured[places]
        self._unrotated_columns = self._compute_columns(np.eye(3))
        self._rotated_columns = [
            self._compute_columns(rotation_matrix(probe), self._probe_samples, probe)
            for probe in _PROBE_ATTITUDES
        ]

    def _compute_columns(
        self, C: Floats, rows: slice | np.ndarray = slice(None), rate: Floats | None = None
    ) -> dict[str, Floats]:
        """Return the columns of H of each block at attitude C, with the attitude error in GCRS."""
        v, *gradient = np.moveaxis(self._vectors[rows] @ C.T, 1, 0)
        rates = None if rate is None else np.broadcast_to(rate, v.shape)
        follows = [*self._sensitivity_factors[rows].T]
        H = self._suite.measurement_matrix(self.sensor, v, C, gradient, rates, follows)
        blocks = {name: H[..., 3 * i : 3 * i + 3] for i, name in enumerate(self._suite.blocks)}
        return blocks | {"attitude": blocks["attitude"] @ C}

    def compute_information(self, names: list[str], weights: Floats) -> tuple[Floats, bool, bool]:
        """Return the information about blocks; whether no attitude changes it, or its trace."""
        information = _compute_information(self._unrotated_columns, names, weights)
        others = np.array(
            [_compute_information(each, names, weights) for each in self._rotated_columns]
        )
        return information, *_compare_information(others, information[self._probe_samples])

    def mask_unmeasured(self, table: Floats) -> Floats:
        """Return the values with zeros at samples without a measurement."""
        return np.where(self._is_measured.reshape(-1, *[1] * (table.ndim - 1)), table, 0.0)

    def find_similar_errors(
        self, carrier: str, traces: dict[str, Floats]
    ) -> dict[str, BodyFixedError]:
        """Return the errors that look like a carrier, with the information about each."""
        unturned = {name: H[self._probe_samples] for name, H in self._unrotated_columns.items()}
        attitudes = [
            (np.eye(3), unturned),
            *zip(map(rotation_matrix, _PROBE_ATTITUDES), self._rotated_columns, strict=True),
        ]
        v = self._vectors[:, 0]
        return {
            block: BodyFixedError(trace, field)
            for block, trace in traces.items()
            for field in (None, v)
            if _is_similar(
                attitudes, block, carrier, None if field is None else field[self._probe_samples]
            )
        }


def _compute_information(columns: dict[str, Floats], names: list[str], precision: Floats) -> Floats:
    H = np.concatenate([columns[name] for name in names], axis=2) * precision[:, None]
    information: Floats = np.einsum("kia,kib->kab", H, H)
    return information


def _compare_information(probe_information: Floats, information: Floats) -> tuple[bool, bool]:
    size = _RELATIVE_TOLERANCE * np.trace(information, axis1=1, axis2=2)
    difference = np.abs(probe_information - information).max(axis=(0, 2, 3), initial=0.0)
    traces = np.trace(probe_information - information, axis1=2, axis2=3)
    return bool((difference <= size).all()), bool((np.abs(traces) <= size).all())


def _is_similar(
    attitudes: Sequence[tuple[Floats, dict[str, Floats]]],
    block: str,
    carrier: str,
    v: Floats | None,
) -> bool:
    """Return whether a body-fixed error looks like a rotated carrier; see `Look`."""
    G = np.eye(3) if v is None else np.moveaxis(skew(v.T), -1, 0)
    matches = []
    for C, looks in attitudes:
        own, rotated = looks[block], looks[carrier] @ G @ C.T
        size = _RELATIVE_TOLERANCE * np.linalg.norm(own, axis=(1, 2), keepdims=True)
        matches.append([(np.abs(own - sign * rotated) <= size).all() for sign in (1.0, -1.0)])
    return bool(np.all(matches, axis=0).any())


def _format_reason(sensor: Sensor, block: str) -> str:
    return (
        f"{sensor.name}: no lower bound is known, because the information about {block} depends "
        "on the attitude in a way other than a rotation"
    )
