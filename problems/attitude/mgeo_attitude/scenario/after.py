"""Scenarios that go on from a calibration: its time, attitude and covariance are their start."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from datetime import timedelta
from typing import Any

import numpy as np

from mgeo_attitude.environment.time_frames import elapsed
from mgeo_attitude.fields import InvalidType, InvalidValue, KeyProblem, expect, to_table
from mgeo_attitude.scenario.presets import Table, overridden
from mgeo_attitude.scenario.prior import Prior, prior_of

#: What a calibration's document says of where a run goes on.
ENTRIES: Mapping[str, Any] = {
    "scenario": Mapping,
    "time_s": int | float,
    "quaternion": list,
    "rate_deg_s": list,
    "states": Mapping,
    "covariance": list,
}

#: Keys that follow from the calibration, or from its scenario.
GIVEN = ("preset", "epoch", "prior")

#: What a calibration concludes if neither innovations nor prior are against it.
SUPPORTED = "the innovations support it"

#: Key that goes on from a calibration which concludes otherwise.
ACCEPT = "accept_unsupported"

#: Latest time of a calibration [s].
_LATEST = 1e9
#: A measured rate that is above its limit by less than so many 1-sigmas is at the limit.
_SIGMAS = 6.0


def going_on(table: Mapping[str, Any], read: Callable[[Any], Any]) -> Table:
    """The table over the scenario that goes on from the calibration that its ``after`` is.

    Parameters
    ----------
    read : function
        A scenario from its table.

    Raises
    ------
    InvalidValue
        For a document that is no calibration's or of one that is not supported, unless `ACCEPT` is
        true; or a key that follows from it.
    """
    overrides = dict(table)
    document = _checked(overrides.pop("after"))
    _check_support(document, overrides.pop(ACCEPT, False))
    for key in GIVEN:
        if key in overrides:
            expected = f"expected no {key} beside a calibration to go on from, which has its own"
            raise InvalidValue(key, overrides[key], expected)
    try:
        before = read(document["scenario"])
        prior = prior_of(document, before.suite)
    except InvalidValue as error:
        raise error.under("after") from None
    time = float(document["time_s"])
    epoch = before.epoch + timedelta(seconds=time)
    epoch -= timedelta(seconds=elapsed(before.epoch, epoch) - time)  # leap seconds
    base = before.to_dict()
    base["epoch"] = epoch.isoformat()
    base["orbit"] |= to_table(before.orbit.later(time))
    base["prior"] = to_table(_within_limits(prior, before))
    return overridden(base, overrides)


def _checked(document: Any) -> Mapping[str, Any]:
    """A document that has the `ENTRIES`."""
    if not isinstance(document, Mapping):
        raise InvalidType("after", document, "expected a calibration's document")
    for key, kind in ENTRIES.items():
        if key not in document:
            raise KeyProblem(f"after.{key}", None, "missing; expected a calibration's document")
        found = document[key]
        if not isinstance(found, kind) or isinstance(found, bool):
            raise InvalidType(f"after.{key}", found, "expected what a calibration's document has")
    time = document["time_s"]
    expect(0.0 <= time <= _LATEST, "after.time_s", time, f"a number in [0, {_LATEST:g}] s")
    return document


def _check_support(document: Mapping[str, Any], accept: Any) -> None:
    """Refuse a calibration that nobody should believe, unless one says to do so."""
    if not isinstance(accept, bool):
        raise InvalidType(ACCEPT, accept, "expected true or false")
    said = document.get("conclusion", SUPPORTED)
    if said != SUPPORTED and not accept:
        expected = f"expected {SUPPORTED!r}; {ACCEPT} = true goes on all the same"
        raise InvalidValue("after.conclusion", said, expected)


def _within_limits(prior: Prior, scenario: Any) -> Prior:
    """With a rate that maneuvers may have: at their limit noise makes it look greater."""
    rate, wheels = np.array(prior.rate_deg_s), scenario.wheels
    shares = [np.abs(rate).max() / scenario.maneuvers.max_rate_deg_s]
    if wheels is not None and wheels.max_momentum is not None and not wheels.initial_momentum:
        momentum = wheels.greatest_share(np.radians(rate) @ wheels.matrix())
        shares.append(momentum / wheels.max_momentum)
    share = max(shares)
    noise = scenario.gyro.angle_random_walk_deg_per_sqrt_h / 60.0 / math.sqrt(scenario.step)
    if not 1.0 < share <= 1.0 + _SIGMAS * noise / np.abs(rate).max():
        return prior
    return dataclasses.replace(prior, rate_deg_s=tuple((rate / share).tolist()))
