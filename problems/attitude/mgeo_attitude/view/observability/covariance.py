"""Correlations and least observable directions of a filter covariance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.sensors.suite import Suite, list_block_units


class StateLabels(NamedTuple):
    """Names, display units and conversion factors of the filter states.

    Attributes
    ----------
    names : list of str
        Names such as ``attitude x`` or ``sun misalignment z``.
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
        states = [(block, axis) for block in list_block_units(suite) for axis in "xyz"]
        return cls(
            names=[f"{block.label} {axis}" for block, axis in states],
            units=[block.unit for block, _ in states],
            factors=np.array([block.factor for block, _ in states]),
        )


#: Smallest share of the squared norm of a direction for which a state block is mentioned.
_MIN_SHARE = 0.1
#: Two rotations count as equal if they differ by less than this fraction of the first one.
_ROTATION_TOLERANCE = 0.4
#: A vector within 15 degrees of a body axis is named after it.
_MIN_AXIS_COSINE = np.cos(np.radians(15.0))


def describe_direction(suite: Suite, initial_sigma: Floats, direction: Floats) -> str:
    """Describe a direction in the state space of the filter in words.

    An example is ``common rotation of attitude and both sensors about body z``. Misalignments of
    sensors with the same rotation vector are grouped, together with the attitude if it has the same
    rotation: vector measurements in body axes alone do not observe a common rotation. All other
    3-vectors of the state follow in the order of their shares.

    Parameters
    ----------
    suite : Suite
    initial_sigma : array, shape (n_states,)
        Initial 1-sigma of every state, in the filter's units.
    direction : array, shape (n_states,)
        Nonzero direction with every state in units of its initial 1-sigma; its sign is arbitrary.

    Returns
    -------
    str
    """
    blocks = dict(zip(suite.blocks, list_block_units(suite), strict=True))
    share = (direction.reshape(-1, 3) ** 2).sum(axis=1) / (direction @ direction)
    vector = dict(zip(blocks, (direction * initial_sigma).reshape(-1, 3), strict=True))
    order = np.argsort(-share, kind="stable")
    min_share = min(_MIN_SHARE, share[order[0]])
    mentioned = [suite.blocks[i] for i in order if share[i] >= min_share]
    # The misalignment of the gyro rotates its rates, so that it takes no part in a common rotation.
    sensors = [f"{sensor.name}.misalignment" for sensor in suite.sensors]
    sensors = [name for name in sensors if name in blocks]
    grouped = _group_rotations(sensors, mentioned, vector)
    ungrouped = [name for name in mentioned if name not in grouped]
    first = vector[(grouped or ungrouped)[0]]
    sign = np.sign(first[np.argmax(np.abs(first))])
    phrases = []
    if grouped:
        mean = sign * np.mean([vector[name] for name in grouped], axis=0)
        phrases = [
            f"common rotation of {_join_names(grouped, len(sensors))} about {_format_axis(mean)}"
        ]
    for name in ungrouped:
        is_rotation = name.endswith(("attitude", ".misalignment")) or name == "gyro.bias"
        axis = f"{'about' if is_rotation else 'along'} {_format_axis(sign * vector[name])}"
        phrases.append(f"{blocks[name].label} {axis}")
    return " with ".join(phrases)


def _group_rotations(
    sensors: Sequence[str], blocks: Sequence[str], vector: dict[str, Floats]
) -> list[str]:
    """Group the attitude and the sensor misalignments whose rotation vectors are nearly equal.

    The result is a list of names: the first sensor misalignment in `blocks`, and the 3-vectors that
    are nearly equal to it. The list is empty if there are no such 3-vectors.
    """
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
    """Join the names of grouped sensors, as in "attitude and both sensors".

    `n_misaligned` is the number of sensors with a misalignment.
    """
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
    """Convert a covariance to a correlation matrix with state names as labels.

    Parameters
    ----------
    model : FilterModel
    covariance : array, shape (n_states, n_states)
        In the filter's units.

    Returns
    -------
    DataFrame
    """
    P = covariance
    sigma = np.sqrt(np.diag(P))
    correlation = np.clip(P / np.outer(sigma, sigma), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    names = StateLabels.from_suite(model.suite).names
    return pd.DataFrame(correlation, names, names)


def normalize_covariance(model: FilterModel, covariance: Floats) -> Floats:
    """Scale a covariance to units of the initial 1-sigma of each state.

    The normalization makes states of different units comparable (Ham & Brown, "Observability,
    Eigenvalues, and Kalman Filtering", IEEE Transactions on Aerospace and Electronic Systems 19
    (1983) 269-273). An eigenvalue is the ratio of the final to the initial variance along its
    eigenvector: 1 marks an unobservable direction. Normalization by the final 1-sigma would give
    the correlation matrix, which does not show the reduction of the uncertainty.

    Parameters
    ----------
    model : FilterModel
    covariance : array, shape (n, n)
        Covariance in the filter's units.

    Returns
    -------
    array, shape (n, n)
    """
    sigma = model.initial_sigma
    return covariance / np.outer(sigma, sigma)


def find_least_observable(
    model: FilterModel, covariance: Floats, n_directions: int = 3
) -> pd.DataFrame:
    """Return the directions in state space with the largest remaining uncertainty.

    The remaining uncertainty is the ratio of the final to the initial 1-sigma along the direction.
    The directions are eigenvectors of the covariance in units of the initial 1-sigmas; see
    `normalize_covariance`. Gauss-Markov states and considered states are left out. Process noise
    may raise a ratio above one.

    Parameters
    ----------
    model : FilterModel
    covariance : array, shape (n_states, n_states)
        Final covariance in the filter's units.
    n_directions : int
        Number of directions.

    Returns
    -------
    DataFrame
        One row per direction, the least observable first. Columns: ``direction``, as a phrase (see
        `describe_direction`); ``remaining [-]``, the ratio of the final to the initial 1-sigma
        along the direction; and, for each 3-vector of the state, the norm of its part of a 1-sigma
        error along the direction.
    """
    states = model.suite.calibrated_indices
    values, vectors = np.linalg.eigh(
        normalize_covariance(model, covariance)[states[:, None], states]
    )
    worst = np.argsort(values)[::-1][:n_directions]
    remaining = np.sqrt(np.maximum(values[worst], 0.0))  # Rounding errors may be negative.
    directions = np.zeros((len(worst), model.suite.n_states))
    directions[:, states] = vectors.T[worst]
    columns: dict[str, object] = {
        "direction": [describe_direction(model.suite, model.initial_sigma, v) for v in directions],
        "remaining [-]": remaining,
    }
    one_sigma = remaining[:, None] * directions * model.initial_sigma
    lengths = np.linalg.norm(one_sigma.reshape(len(worst), -1, 3), axis=2)
    for block, length in zip(list_block_units(model.suite), lengths.T, strict=True):
        columns[f"{block.label} [{block.unit}]"] = length * block.factor
    return pd.DataFrame(columns)
