"""Correlations and least observable directions of a covariance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.sensors.suite import Suite, list_block_units


class StateLabels(NamedTuple):
    """Names, units and unit factors of the n states of a suite, in the order of the filter.

    Attributes
    ----------
    names : list of str
        Such as ``attitude x`` or ``sun misalignment z``.
    units : list of str
        Display units, as in `list_block_units`.
    factors : array, shape (n,)
        Factors from the filter's units to the display units.
    """

    names: list[str]
    units: list[str]
    factors: Floats

    @classmethod
    def from_suite(cls, suite: Suite) -> StateLabels:
        """Return names, units and factors of the states of a suite."""
        each = [(block, axis) for block in list_block_units(suite) for axis in "xyz"]
        return cls(
            names=[f"{block.label} {axis}" for block, axis in each],
            units=[block.unit for block, _ in each],
            factors=np.array([block.factor for block, _ in each]),
        )


#: Least share of the squared norm of a direction from which a state block is named.
_MIN_SHARE = 0.1
#: Two rotations count as equal if they differ by less than this fraction of the first one.
_ROTATION_TOLERANCE = 0.4
#: A vector within 15 degrees of a body axis is named after it.
_MIN_AXIS_COSINE = np.cos(np.radians(15.0))


def describe_direction(suite: Suite, initial_sigma: Floats, direction: Floats) -> str:
    """Describe a direction of the error state in words.

    An example is ``common rotation of attitude and both sensors about body z``. Sensors that rotate
    by equal angles are grouped, including the attitude if it has the same rotation: vector
    measurements in body axes alone do not observe a common rotation. All other blocks follow in the
    order of their shares.

    Parameters
    ----------
    suite : Suite
    initial_sigma : array, shape (n_states,)
        Initial 1-sigma of every state, in the filter's units.
    direction : array, shape (n_states,)
        Nonzero direction with every state in units of its initial 1-sigma; its sign is arbitrary.
    """
    blocks = dict(zip(suite.blocks, list_block_units(suite), strict=True))
    share = (direction.reshape(-1, 3) ** 2).sum(axis=1) / (direction @ direction)
    vector = dict(zip(blocks, (direction * initial_sigma).reshape(-1, 3), strict=True))
    order = np.argsort(-share, kind="stable")
    least = min(_MIN_SHARE, share[order[0]])
    named = [suite.blocks[i] for i in order if share[i] >= least]
    # The gyro's misalignment rotates its rates, so that it is no part of a common rotation.
    sensors = [f"{sensor.name}.misalignment" for sensor in suite.sensors]
    sensors = [name for name in sensors if name in blocks]
    grouped = _group_rotations(sensors, named, vector)
    rest = [name for name in named if name not in grouped]
    first = vector[(grouped or rest)[0]]
    sign = np.sign(first[np.argmax(np.abs(first))])
    phrases = []
    if grouped:
        mean = sign * np.mean([vector[name] for name in grouped], axis=0)
        phrases = [
            f"common rotation of {_join_names(grouped, len(sensors))} about {_format_axis(mean)}"
        ]
    for name in rest:
        turns = name.endswith(("attitude", ".misalignment")) or name == "gyro.bias"
        where = f"{'about' if turns else 'along'} {_format_axis(sign * vector[name])}"
        phrases.append(f"{blocks[name].label} {where}")
    return " with ".join(phrases)


def _group_rotations(
    sensors: Sequence[str], blocks: Sequence[str], vector: dict[str, Floats]
) -> list[str]:
    """Return the blocks that rotate like the most prominent misalignment."""
    tilts = [vector[name] for name in blocks if name in sensors]
    if not tilts:
        return []
    alike = [
        name
        for name in ("attitude", *sensors)
        if np.linalg.norm(vector[name] - tilts[0]) < _ROTATION_TOLERANCE * np.linalg.norm(tilts[0])
    ]
    return alike if len(alike) > 1 else []


def _join_names(names: Sequence[str], n_misaligned: int) -> str:
    """Join the names of blocks; `n_misaligned` is the total number of sensors with a misalignment."""
    sensors = [name.partition(".")[0] for name in names if name != "attitude"]
    if len(sensors) == n_misaligned > 1:
        text = "both sensors" if n_misaligned == 2 else f"all {n_misaligned} sensors"
    else:
        text = " and ".join(sensors)
    return f"attitude and {text}" if "attitude" in names else text


def _format_axis(vector: Floats) -> str:
    unit = vector / np.linalg.norm(vector)
    largest = int(np.argmax(np.abs(unit)))
    if abs(unit[largest]) >= _MIN_AXIS_COSINE:
        return f"body {'-' if unit[largest] < 0.0 else ''}{'xyz'[largest]}"
    # Adding zero converts -0.00 to 0.00.
    return f"body ({', '.join(f'{component:.2f}' for component in unit.round(2) + 0.0)})"


def compute_correlations(model: FilterModel, covariance: Floats) -> pd.DataFrame:
    """Return the correlation matrix of the states, with names as rows and columns.

    Parameters
    ----------
    model : FilterModel
    covariance : array, shape (n_states, n_states)
    """
    P = covariance
    sigma = np.sqrt(np.diag(P))
    correlation = np.clip(P / np.outer(sigma, sigma), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    names = StateLabels.from_suite(model.suite).names
    return pd.DataFrame(correlation, names, names)


def normalize_covariance(model: FilterModel, covariance: Floats) -> Floats:
    """Return the covariance with every state in units of its initial 1-sigma, shape (n, n).

    The normalization makes states of different units comparable (Ham & Brown, "Observability,
    Eigenvalues, and Kalman Filtering", IEEE Transactions on Aerospace and Electronic Systems 19
    (1983) 269-273). An eigenvalue is the ratio of the final to the initial variance along its
    eigenvector: 1 marks an unobservable direction. Normalizing by the final 1-sigma would give the
    correlation matrix, which does not show the reduction of the uncertainty.
    """
    sigma = model.initial_sigma
    return covariance / np.outer(sigma, sigma)


def find_least_observable(
    model: FilterModel, covariance: Floats, n_directions: int = 3
) -> pd.DataFrame:
    """Return the `n_directions` least observable directions of the error state, the worst first.

    The directions are the eigenvectors of the `normalize_covariance` covariance with the largest eigenvalues.
    Gauss-Markov errors and considered states are left out. Process noise may raise an eigenvalue
    above one.

    Returns
    -------
    DataFrame
        ``direction``, in words (see `describe_direction`); ``remaining [-]``, the ratio of the final to the
        initial 1-sigma along the direction; and, for each 3-vector of the state, the norm of its
        part of a 1-sigma error along the direction.
    """
    of = model.suite.calibrated_indices
    values, vectors = np.linalg.eigh(normalize_covariance(model, covariance)[of[:, None], of])
    worst = np.argsort(values)[::-1][:n_directions]
    remaining = np.sqrt(np.maximum(values[worst], 0.0))  # rounding may leave -1e-17
    directions = np.zeros((len(worst), model.suite.n_states))
    directions[:, of] = vectors.T[worst]
    columns: dict[str, object] = {
        "direction": [describe_direction(model.suite, model.initial_sigma, v) for v in directions],
        "remaining [-]": remaining,
    }
    one_sigma = remaining[:, None] * directions * model.initial_sigma
    lengths = np.linalg.norm(one_sigma.reshape(len(worst), -1, 3), axis=2)
    for block, length in zip(list_block_units(model.suite), lengths.T, strict=True):
        columns[f"{block.label} [{block.unit}]"] = length * block.factor
    return pd.DataFrame(columns)
