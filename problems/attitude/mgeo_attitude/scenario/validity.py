"""Where the linear covariance can be believed."""

from __future__ import annotations

from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors import Photodiode


class OutsideValidity(UserWarning):
    """A scenario's initial errors are larger than those for which the filter was found true."""


#: Largest initial 1-sigma per axis in the map of docs/consistency.md up to which the NEES of the
#: shipped estimator is within its 99 % bounds for both presets.
MAX_ATTITUDE_DEG = 20.0
MAX_MISALIGNMENT_DEG = 1.0
MAX_GYRO_BIAS_DEG_S = 0.01

#: With photodiodes, of which few see the Sun at a time: from 10 deg `cubesat_1u` has a NEES of 1.2,
#: from 5 deg of 1.04.
MAX_ATTITUDE_OF_FACES_DEG = 5.0

#: Of the orbit, along which the field's derivative changes. In 50 flights of Basilisk, with IGRF
#: where the satellite is, NEES is 1.07 with an error of 30 km along track, within its 99 % bounds;
#: 1.14 with one of 50 is not.
MAX_ORBIT_ERROR_M = 30_000.0


def examined(scenario: Scenario) -> list[tuple[str, float, float]]:
    """Initial uncertainties by key, each with the largest at which the map has found it true."""
    faces = any(isinstance(sensor, Photodiode) for sensor in scenario.sensors)
    attitude = MAX_ATTITUDE_OF_FACES_DEG if faces else MAX_ATTITUDE_DEG
    limits = [
        ("initial.attitude_deg", scenario.initial.attitude_deg, attitude),
        ("gyro.initial_bias_deg_s", scenario.gyro.initial_bias_deg_s, MAX_GYRO_BIAS_DEG_S),
        (
            "gyro.initial_misalignment_deg",
            scenario.gyro.initial_misalignment_deg,
            MAX_MISALIGNMENT_DEG,
        ),
    ]
    if scenario.world.has_orbit_error and scenario.needs_field:
        along = max(scenario.world.orbit_error_m)
        limits.append(("world.orbit_error_m", along, MAX_ORBIT_ERROR_M))
    for index, sensor in enumerate(scenario.sensors):
        if isinstance(sensor, Photodiode):  # whose readings are linear in the tilts of its normal
            continue
        misalignment = getattr(sensor, "initial_misalignment_deg", 0.0)
        limits.append(
            (f"sensors[{index}].initial_misalignment_deg", misalignment, MAX_MISALIGNMENT_DEG)
        )
    return limits


def validity(scenario: Scenario) -> tuple[str, ...]:
    """Why the linear covariance may promise more than a filter achieves; empty if it need not.

    Compares initial uncertainties with the map of docs/consistency.md, which sweeps one at a time
    from the presets. A scenario within it is no proof; `simulate` is.

    Parameters
    ----------
    scenario : Scenario

    Examples
    --------
    >>> from mgeo_attitude import Scenario, validity
    >>> wild = Scenario.from_dict({"preset": "paper", "initial": {"attitude_deg": 60.0}})
    >>> validity(Scenario.paper()), len(validity(wild))
    ((), 1)
    """
    if scenario.prior is not None:  # a calibration is better than all of these
        return ()
    return tuple(
        f"{key} = {value:g}: the linear covariance was found true up to {limit:g}"
        for key, value, limit in examined(scenario)
        if value > limit
    )
