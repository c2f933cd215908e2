"""What a covariance says of a plan: correlations, and the directions it has learned least of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.sensors.suite import Suite, block_units


class States(NamedTuple):
    """Names of the n states of a suite, in the order of the filter.

    Attributes
    ----------
    names : list of str
        ``attitude x``, ``sun misalignment z``...
    units : list of str
        Unit in which each is shown; that of `describe.block_units`.
    factors : array, shape (n,)
        From the filter's unit to that.
    """

    names: list[str]
    units: list[str]
    factors: Floats

    @classmethod
    def of(cls, suite: Suite) -> States:
        """States of a suite."""
        each = [(block, axis) for block in block_units(suite) for axis in "xyz"]
        return cls(
            names=[f"{block.label} {axis}" for block, axis in each],
            units=[block.unit for block, _ in each],
            factors=np.array([block.factor for block, _ in each]),
        )


#: Share of the squared direction, in initial sigmas, from which a 3-vector is worth a word.
_SHARE = 0.1
#: Rotations count as alike if they differ by less than this fraction of the first one.
_ALIKE = 0.4
#: A vector within 15 degrees of a body axis is named after it.
_ON_AXIS = np.cos(np.radians(15.0))


def in_words(suite: Suite, initial_sigma: Floats, direction: Floats) -> str:
    """Name a direction, such as ``common rotation of attitude and both sensors about body z``.

    Sensors that are rotated alike are named together, with the attitude if it turns with them: that
    is what vectors measured in body axes cannot see by themselves. The rest follows by its share.

    Parameters
    ----------
    initial_sigma : array, shape (n_states,)
        1-sigma of every state at the start, in the filter's units.
    direction : array, shape (n_states,)
        Not zero, every state in units of its initial 1-sigma; its sign means nothing.
    """
    blocks = dict(zip(suite.blocks, block_units(suite), strict=True))
    share = (direction.reshape(-1, 3) ** 2).sum(axis=1) / (direction @ direction)
    vector = dict(zip(blocks, (direction * initial_sigma).reshape(-1, 3), strict=True))
    order = np.argsort(-share, kind="stable")
    least = min(_SHARE, share[order[0]])
    named = [suite.blocks[i] for i in order if share[i] >= least]
    # the gyro's misalignment turns with its rates, not with vectors
    sensors = [f"{sensor.name}.misalignment" for sensor in suite.sensors]
    sensors = [name for name in sensors if name in blocks]
    together = _rotated_alike(sensors, named, vector)
    rest = [name for name in named if name not in together]
    first = vector[(together or rest)[0]]
    sign = np.sign(first[np.argmax(np.abs(first))])
    phrases = []
    if together:
        mean = sign * np.mean([vector[name] for name in together], axis=0)
        phrases = [f"common rotation of {_joined(together, len(sensors))} about {_axis(mean)}"]
    for name in rest:
        turns = name.endswith(("attitude", ".misalignment")) or name == "gyro.bias"
        where = f"{'about' if turns else 'along'} {_axis(sign * vector[name])}"
        phrases.append(f"{blocks[name].label} {where}")
    return " with ".join(phrases)


def _rotated_alike(
    sensors: Sequence[str], named: Sequence[str], vector: dict[str, Floats]
) -> list[str]:
    """What turns like the most prominent misalignment: sensors and attitude, or nothing else."""
    tilts = [vector[name] for name in named if name in sensors]
    if not tilts:
        return []
    alike = [
        name
        for name in ("attitude", *sensors)
        if np.linalg.norm(vector[name] - tilts[0]) < _ALIKE * np.linalg.norm(tilts[0])
    ]
    return alike if len(alike) > 1 else []


def _joined(names: Sequence[str], every: int) -> str:
    """``attitude and both sensors``, or names of sensors, `every` of which there are."""
    sensors = [name.partition(".")[0] for name in names if name != "attitude"]
    if len(sensors) == every > 1:
        text = "both sensors" if every == 2 else f"all {every} sensors"
    else:
        text = " and ".join(sensors)
    return f"attitude and {text}" if "attitude" in names else text


def _axis(vector: Floats) -> str:
    unit = vector / np.linalg.norm(vector)
    largest = int(np.argmax(np.abs(unit)))
    if abs(unit[largest]) >= _ON_AXIS:
        return f"body {'-' if unit[largest] < 0.0 else ''}{'xyz'[largest]}"
    # adding zero makes -0.00 a 0.00
    return f"body ({', '.join(f'{component:.2f}' for component in unit.round(2) + 0.0)})"


def correlations(model: FilterModel, covariance: Floats) -> pd.DataFrame:
    """Return the correlation of every pair of states, rows and columns by name, in [-1, 1].

    Parameters
    ----------
    covariance : array, shape (n_states, n_states)
    """
    P = covariance
    sigma = np.sqrt(np.diag(P))
    correlation = np.clip(P / np.outer(sigma, sigma), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    names = States.of(model.suite).names
    return pd.DataFrame(correlation, names, names)


def normalized(model: FilterModel, covariance: Floats) -> Floats:
    """The covariance with every state in units of its initial 1-sigma, shape (n, n).

    Ham & Brown, "Observability, Eigenvalues, and Kalman Filtering", IEEE Transactions on Aerospace
    and Electronic Systems 19 (1983) 269-273. States in rad, rad/s and of no dimension can only be
    combined in some such unit. The initial one makes an eigenvalue the share of what was unknown
    that is still unknown: 1 is a direction of which nothing was learned. (In units of the *final*
    sigma it would be the correlation matrix, which no longer knows what was learned.)
    """
    sigma = model.initial_sigma
    return covariance / np.outer(sigma, sigma)


def least_observable(model: FilterModel, covariance: Floats, count: int = 3) -> pd.DataFrame:
    """The `count` directions of the error state of which least was learned, the worst first.

    They are eigenvectors of the `normalized` covariance, by falling eigenvalue; errors that vary,
    and those that are considered, are left out. Process noise may lift an eigenvalue above one.

    Returns
    -------
    DataFrame
        ``direction``, in words (see `in_words`); ``remaining [-]``, the 1-sigma along it over the
        initial one; and for each 3-vector of the state the length that an error of 1-sigma along
        the direction has in it.
    """
    of = model.suite.calibrated
    values, vectors = np.linalg.eigh(normalized(model, covariance)[of[:, None], of])
    worst = np.argsort(values)[::-1][:count]
    remaining = np.sqrt(np.maximum(values[worst], 0.0))  # rounding may leave -1e-17
    directions = np.zeros((len(worst), model.suite.n_states))
    directions[:, of] = vectors.T[worst]
    columns: dict[str, object] = {
        "direction": [in_words(model.suite, model.initial_sigma, v) for v in directions],
        "remaining [-]": remaining,
    }
    one_sigma = remaining[:, None] * directions * model.initial_sigma
    lengths = np.linalg.norm(one_sigma.reshape(len(worst), -1, 3), axis=2)
    for block, length in zip(block_units(model.suite), lengths.T, strict=True):
        columns[f"{block.label} [{block.unit}]"] = length * block.factor
    return pd.DataFrame(columns)
