"""What samples tell of each 3-vector of the state, whatever the attitude they are taken at.

All is taken from the sensors' own `measure`: whether the information of a sample depends on the
attitude is seen at some of them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.common_mode import Look, Turned
from mgeo_attitude.bound.faces import together as of_faces
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import matrix, skew
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite

#: Attitudes, as vectors of rotation, at which is seen what depends on them.
_PROBES = np.array([[0.4, -1.1, 0.7], [-2.0, 0.3, 0.5], [0.9, 1.3, -1.6], [0.1, 0.2, 2.9]])
#: Samples at which it is seen, at most.
_PROBED = 40
#: What does not depend on the attitude differs by less, relative to its norm.
_ROUNDING = 1e-10


class NoLimit(ValueError):
    """No bound can be proved, and why."""


class Told(NamedTuple):
    """Information about a 3-vector in each sample, if all else is known.

    Attributes
    ----------
    trace : array, shape (n_steps + 1,)
        Its trace, or what that does not exceed.
    matrix : array, shape (n_steps + 1, 3, 3), or None
        The information itself, if no attitude changes it.
    """

    trace: Floats
    matrix: Floats | None


@dataclass(frozen=True)
class Samples:
    """What all sensors' samples tell, zero where there is none.

    Attributes
    ----------
    inertial : tuple of str
        The attitude, and errors that vary with axes along GCRS: of these no attitude changes what
        is told in such axes.
    together : array, shape (n_steps + 1, 3 m, 3 m)
        Information about these m blocks in these axes; not less than there is.
    attitude : array, shape (n_steps + 1,)
        Trace of the information about the attitude; not less than there is.
    own : dict of Told
        Of each other block of sensors and the world.
    looks : tuple of Look
        Of each sensor at each of `inertial`, and what it may mistake for them.
    uneven : tuple of str
        Sensors whose noise differs by axes so that a bound gives something away.
    """

    inertial: tuple[str, ...]
    together: Floats
    attitude: Floats
    own: dict[str, Told]
    looks: tuple[Look, ...]
    uneven: tuple[str, ...]


def samples(model: FilterModel) -> Samples:
    """What the samples of a model tell.

    Raises
    ------
    NoLimit
        If a sensor's samples depend on the attitude in a way for which there is no bound.
    """
    for influence in model.suite.gyro.influences:
        raise NoLimit(
            f"gyro.influences: how {influence.channel} turns the attitude changes with time, and "
            "the limit knows how only of rates"
        )
    diodes = [i for i, each in enumerate(model.suite.sensors) if isinstance(each, Photodiode)]
    every = [i for i in range(len(model.suite.sensors)) if i not in diodes]
    faces = [_of_diodes(model, diodes)] if diodes else []
    found = [_of_sensor(model, index) for index in every] + faces
    own = {name for each in found for name in each.own}
    # what one sensor sees in these axes, and another that shares it does not
    if apart := own.intersection(name for each in found for name in each.inertial):
        found = [_of_sensor(model, index, apart) for index in every] + faces
    inertial = tuple(dict.fromkeys(name for each in found for name in each.inertial))
    n = len(model.references)
    together = np.zeros((n, 3 * len(inertial), 3 * len(inertial)))
    for each in found:
        places = np.concatenate([3 * inertial.index(name) + np.arange(3) for name in each.inertial])
        together[:, places[:, None], places] += each.together
    return Samples(
        inertial,
        together,
        np.sum([each.attitude for each in found], axis=0),
        _added(told for each in found for told in each.own.items()),
        tuple(look for each in found for look in each.looks),
        tuple(name for each in found for name in each.uneven),
    )


def _added(found: Iterable[tuple[str, Told]]) -> dict[str, Told]:
    """What all sensors tell of each block: of the world's more than one may."""
    total: dict[str, Told] = {}
    for name, told in found:
        known = total.setdefault(name, told)
        if known is not told:
            parts = [each.matrix for each in (known, told) if each.matrix is not None]
            matrix = np.add(*parts) if len(parts) == 2 else None
            total[name] = Told(known.trace + told.trace, matrix)
    return total


def _of_sensor(model: FilterModel, index: int, apart: Collection[str] = ()) -> Samples:
    """The same of one sensor, without some errors that vary among those `inertial`."""
    suite, sensor = model.suite, model.suite.sensors[index]
    probed = _Probed(model, index)
    precision = 1.0 / np.array(sensor.noise())
    most = np.full(len(precision), precision.max())  # noise that is nowhere more than it is
    own = list(suite.blocks_of(sensor).values())
    varying = [name for name in own if name in suite.processes and name not in apart]
    inertial, together = _in_these_axes(probed, varying, most)
    attitude, _, same = probed.told(["attitude"], precision)
    if not same:
        attitude = together[:, :3, :3]
    each = {name: _of_error(probed, name, precision, most) for name in own if name not in inertial}
    constants = {name: told.trace for name, told in each.items() if name not in suite.processes}
    blocks = np.split(np.diagonal(together, axis1=1, axis2=2), len(inertial), axis=1)
    return Samples(
        inertial,
        probed.where_seen(together),
        probed.where_seen(np.trace(attitude, axis1=1, axis2=2)),
        each,
        tuple(
            Look(name, probed.where_seen(block.sum(axis=1)), probed.mistaken(name, constants))
            for name, block in zip(inertial, blocks, strict=True)
        ),
        (sensor.name,) if (precision != most).any() else (),
    )


def _in_these_axes(
    probed: _Probed, varying: list[str], most: Floats
) -> tuple[tuple[str, ...], Floats]:
    """Attitude and errors that vary, or else the attitude alone: names and information."""
    for names in (["attitude", *varying], ["attitude"]):
        together, same, _ = probed.told(names, most)
        if same:
            return tuple(names), together
    raise NoLimit(_reason(probed.sensor, "attitude"))


def _of_error(probed: _Probed, name: str, precision: Floats, most: Floats) -> Told:
    """Of one of the sensor's errors; if turns change its trace, with the best axis' noise."""
    for weights in (precision, most):
        information, same, same_trace = probed.told([name], weights)
        if same_trace:
            trace = probed.where_seen(np.trace(information, axis1=1, axis2=2))
            return Told(trace, probed.where_seen(information) if same else None)
    raise NoLimit(_reason(probed.sensor, name))


def _of_diodes(model: FilterModel, indices: Sequence[int]) -> Samples:
    """The same of all photodiodes together; of its own errors each tells w s sᵀ, all else known."""
    sensors = [model.suite.sensors[index] for index in indices]
    lit = [sensor for sensor in sensors if isinstance(sensor, Photodiode)]
    world = model.suite.world
    for sensor in lit:
        if sensor.delay():
            raise NoLimit(_reason(sensor, f"{sensor.name}.delay"))
        if sensor.sees_albedo and (world.earth_albedo or world.albedo):
            raise NoLimit(
                f"{sensor.name}: how much light from the Earth it sees depends on the attitude; "
                "with sees_albedo = false there is a limit"
            )
    seen = model.available[:, indices].copy()
    seen[0] = False
    sun = model.references[:, indices[0]]
    across = np.eye(3) - sun[:, :, None] * sun[:, None]
    most = np.where(seen.any(axis=1), of_faces(lit), 0.0)
    return Samples(
        ("attitude",),
        most[:, None, None] * across,
        2.0 * most,
        {
            f"{sensor.name}.sensitivity": Told(there / sensor.relative_noise**2, None)
            for sensor, there in zip(lit, seen.T, strict=True)
        },
        (Look("attitude", 2.0 * most, {}),),
        (),
    )


class _Probed:
    """H of one sensor: at each sample of an unturned body, at some of others, `_PROBES`."""

    def __init__(self, model: FilterModel, index: int) -> None:
        self.sensor = model.suite.sensors[index]
        self._suite = Suite(model.suite.gyro, (self.sensor,), model.suite.world)
        self._vectors = model.references[:, model.suite.looks(index)]
        self._follows = model.influences[:, model.suite.influence_columns(self.sensor)]
        self._seen = model.available[:, index].copy()
        self._seen[0] = False  # the filter's first update is a step after the start
        here = np.flatnonzero(self._seen)
        self._some = here[np.linspace(0, len(here) - 1, min(len(here), _PROBED)).astype(int)]
        self._unturned = self._at(np.eye(3))
        self._turned = [self._at(matrix(probe), self._some, probe) for probe in _PROBES]

    def _at(
        self, C: Floats, which: slice | np.ndarray = slice(None), rate: Floats | None = None
    ) -> dict[str, Floats]:
        """Columns of H by blocks, those of the attitude error in axes of GCRS."""
        v, *gradient = np.moveaxis(self._vectors[which] @ C.T, 1, 0)
        rates = None if rate is None else np.broadcast_to(rate, v.shape)
        follows = [*self._follows[which].T]
        H = self._suite.measurement_matrix(self.sensor, v, C, gradient, rates, follows)
        blocks = {name: H[..., 3 * i : 3 * i + 3] for i, name in enumerate(self._suite.blocks)}
        return blocks | {"attitude": blocks["attitude"] @ C}

    def told(self, names: list[str], weights: Floats) -> tuple[Floats, bool, bool]:
        """Information about blocks; whether all attitudes leave it, and its trace, the same."""
        information = _gram(self._unturned, names, weights)
        others = np.array([_gram(each, names, weights) for each in self._turned])
        return information, *_same(others, information[self._some])

    def where_seen(self, values: Floats) -> Floats:
        """Zero where there is no sample."""
        return np.where(self._seen.reshape(-1, *[1] * (values.ndim - 1)), values, 0.0)

    def mistaken(self, carrier: str, traces: dict[str, Floats]) -> dict[str, Turned]:
        """Errors, of what is told of each, that read as one along GCRS does: see `Look`."""
        unturned = {name: H[self._some] for name, H in self._unturned.items()}
        attitudes = [(np.eye(3), unturned), *zip(map(matrix, _PROBES), self._turned, strict=True)]
        v = self._vectors[:, 0]
        return {
            block: Turned(trace, field)
            for block, trace in traces.items()
            for field in (None, v)
            if _alike(attitudes, block, carrier, None if field is None else field[self._some])
        }


def _gram(looks: dict[str, Floats], names: list[str], precision: Floats) -> Floats:
    """Hᵀ R⁻¹ H over some blocks."""
    H = np.concatenate([looks[name] for name in names], axis=2) * precision[:, None]
    information: Floats = np.einsum("kia,kib->kab", H, H)
    return information


def _same(others: Floats, information: Floats) -> tuple[bool, bool]:
    """Whether matrices are alike at all probes, and whether their traces are."""
    size = _ROUNDING * np.trace(information, axis1=1, axis2=2)
    difference = np.abs(others - information).max(axis=(0, 2, 3), initial=0.0)
    traces = np.trace(others - information, axis1=2, axis2=3)
    return bool((difference <= size).all()), bool((np.abs(traces) <= size).all())


def _alike(
    attitudes: Sequence[tuple[Floats, dict[str, Floats]]],
    block: str,
    carrier: str,
    v: Floats | None,
) -> bool:
    """Whether an error reads as one along GCRS, `carrier`, that turns with the body: see `Look`."""
    G = np.eye(3) if v is None else np.moveaxis(skew(v.T), -1, 0)
    found = []
    for C, looks in attitudes:
        own, turned = looks[block], looks[carrier] @ G @ C.T
        size = _ROUNDING * np.linalg.norm(own, axis=(1, 2), keepdims=True)
        found.append([(np.abs(own - sign * turned) <= size).all() for sign in (1.0, -1.0)])
    return bool(np.all(found, axis=0).any())


def _reason(sensor: Sensor, block: str) -> str:
    return (
        f"{sensor.name}: what a sample tells of {block} depends on the attitude, and the limit "
        "knows how only of vectors that turn with the body"
    )
