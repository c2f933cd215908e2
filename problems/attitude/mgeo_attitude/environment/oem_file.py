"""Reader of orbit ephemeris messages (OEM of CCSDS 502.0-B, KVN or XML), using the package oem."""

from __future__ import annotations

import warnings
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.ephemeris import (
    DEFAULT_DEGREE,
    TIME_TOLERANCE,
    EphemerisOrbit,
    count_polynomial_samples,
)
from mgeo_attitude.environment.frames import convert_to_gcrs, parse_frame_name
from mgeo_attitude.environment.thrust import find_thrust
from mgeo_attitude.environment.times import as_utc, compute_julian_dates, format_instant

#: Names of time scales in astropy by their names in messages.
_SCALES = {"UTC": "utc", "TAI": "tai", "TT": "tt", "GPS": "tai"}
#: TAI minus GPS time [s].
_GPS_BEHIND_TAI = 19.0
#: Time before and after a run that is searched for maneuvers [s].
_SEARCH_MARGIN = 3600.0


class TimeSpan(NamedTuple):
    """Time span for which an orbit is needed.

    Attributes
    ----------
    epoch : datetime with UTC offset
        Start of the run.
    duration : float
        Duration of the run [s].
    """

    epoch: datetime
    duration: float

    def format_interval(self, start: float, end: float) -> str:
        return f"{format_instant(self.epoch, start)} to {format_instant(self.epoch, end)}"


def read_oem(
    path: Path, object_name: str, run: TimeSpan, interpolation: str | None, degree: int | None
) -> EphemerisOrbit:
    """Read the orbit for a run from an orbit ephemeris message (OEM).

    The orbit contains only the samples that interpolation during the run needs.

    Parameters
    ----------
    path : Path
        File, which may be compressed (``.gz``).
    object_name : str
        Name or designator of the object; empty for any.
    run : TimeSpan
        Time span in which the orbit is needed.
    interpolation : {"hermite", "lagrange"}, optional
        Interpolation method; default: the method in the message, or else Hermite.
    degree : int, optional
        Degree of the polynomials; default: the degree in the message, or else 7.

    Raises
    ------
    ValueError
        If the message is invalid, describes another object, or uses an unsupported frame or time
        system; if no segment covers the whole run; or if a maneuver occurs during the run.
    ImportError
        If the package oem is not installed.
    """
    with warnings.catch_warnings():
        # The package warns about GPS time and about years with unknown leap seconds.
        warnings.simplefilter("ignore")
        segments = _read_segments(path)
        segment, name = _select_segment(segments, run), _find_object_name(segments, object_name)
        meta = segment.metadata
        if meta["CENTER_NAME"].upper() != "EARTH":
            raise ValueError(f"CENTER_NAME = {meta['CENTER_NAME']!r}: expected EARTH")
        if "REF_FRAME_EPOCH" in meta:
            raise ValueError(
                "REF_FRAME_EPOCH: expected no entry, since only axes of date are supported"
            )
        states = list(segment.states)
        times = _compute_seconds([state.epoch for state in states], run.epoch, meta["TIME_SYSTEM"])
    frame = parse_frame_name(meta["REF_FRAME"])
    hints = {key: meta[key] for key in ("INTERPOLATION", "INTERPOLATION_DEGREE") if key in meta}
    method = interpolation or hints.get("INTERPOLATION", "hermite").lower()
    if method not in ("hermite", "lagrange", "linear"):
        raise ValueError(f"INTERPOLATION = {method!r}: expected HERMITE, LAGRANGE or LINEAR")
    default = 1 if method == "linear" else hints.get("INTERPOLATION_DEGREE", DEFAULT_DEGREE)
    degree = degree or default
    margin = count_polynomial_samples(degree, method == "hermite") + 1
    begin, end = np.searchsorted(times, [-_SEARCH_MARGIN, run.duration + _SEARCH_MARGIN])
    selected = slice(max(begin - margin, 0), end + margin)
    times, states = times[selected], states[selected]
    position, velocity = convert_to_gcrs(
        frame,
        compute_julian_dates(run.epoch, times),
        1e3 * np.array([state.position for state in states]),
        1e3 * np.array([state.velocity for state in states]),
    )
    assert velocity is not None  # Messages always have velocities.
    first, last = np.searchsorted(times, [TIME_TOLERANCE, run.duration - TIME_TOLERANCE])
    index = np.arange(len(times))
    needed = (index >= first - 1 - margin) & (index <= last + margin)
    selection = needed & _find_coasting_samples(times, position, velocity, run)
    orbit = EphemerisOrbit(
        source=f"{path.name}, {name}",
        epoch=run.epoch,
        degree=degree,
        times=times[selection].tolist(),
        position=position[selection].tolist(),
        velocity=velocity[selection].tolist() if method == "hermite" else (),
    )
    return orbit.prepare_for_run(run.epoch, run.duration)


def _read_segments(path: Path) -> list[Any]:
    try:
        from oem import OrbitEphemerisMessage
    except ImportError as error:
        install = "pip install 'mgeo-attitude[orbits]'"
        raise ImportError(f"an ephemeris file needs the package oem: {install}") from error
    try:
        segments: list[Any] = OrbitEphemerisMessage.open(path).segments
    except Exception as error:  # The package raises many kinds of exceptions.
        raise ValueError(f"expected an orbit ephemeris message (OEM): {error}") from error
    return segments


def _find_object_name(segments: list[Any], object_name: str) -> str:
    """Return the name and designator of the satellite whose orbit an OEM contains.

    Raise ValueError if another object is requested.
    """
    name = " ".join(str(segments[0].metadata[key]) for key in ("OBJECT_NAME", "OBJECT_ID"))
    if object_name and object_name.casefold() not in (
        name.casefold(),
        *name.casefold().rsplit(" ", 1),
    ):
        raise ValueError(f"object = {object_name!r}: expected {name}, the object of the message")
    return name


def _select_segment(segments: list[Any], run: TimeSpan) -> Any:
    """Return the first OEM segment with a usable time span that covers the whole run."""
    spans = []
    for segment in segments:
        time_scale = segment.metadata["TIME_SYSTEM"]
        ends = [segment.useable_start_time, segment.useable_stop_time]
        start, end = _compute_seconds(ends, run.epoch, time_scale).tolist()
        if start <= TIME_TOLERANCE and run.duration <= end + TIME_TOLERANCE:
            return segment
        spans.append(run.format_interval(start, end))
    raise ValueError(
        f"expected the whole run, {run.format_interval(0.0, run.duration)}, in one segment; found "
        f"{', '.join(spans[:3])}{' ...' if len(spans) > 3 else ''}. Orbits are not interpolated "
        "across segments, between which there may be a maneuver: start the run later, or shorten it"
    )


def _compute_seconds(epochs: list[Any], since: datetime, time_scale: str) -> Floats:
    """Convert epochs in a given time scale to SI seconds after `since`."""
    from astropy.time import Time

    if time_scale.upper() not in _SCALES:
        raise ValueError(f"TIME_SYSTEM = {time_scale!r}: expected {', '.join(_SCALES)}")
    # The package returns datetimes for GPS time, which astropy does not support.
    times = Time(epochs, scale=_SCALES[time_scale.upper()])
    seconds: Floats = (times - Time(as_utc(since).replace(tzinfo=None), scale="utc")).sec
    return np.round(seconds + (_GPS_BEHIND_TAI if time_scale.upper() == "GPS" else 0.0), 9)


def _find_coasting_samples(
    times: Floats, position: Floats, velocity: Floats, run: TimeSpan
) -> Bools:
    """Select the orbit samples between the last maneuver before a run and the first one after it.

    Return a boolean array with one entry per sample. Raise ValueError if there is thrust during the
    run.
    """
    coasting = np.ones(len(times), dtype=bool)
    for thrust in find_thrust(times, position, velocity):
        if thrust.end <= TIME_TOLERANCE:
            coasting &= times >= thrust.end
        elif thrust.start >= run.duration - TIME_TOLERANCE:
            coasting &= times <= thrust.start
        else:
            raise ValueError(
                "a maneuver, or wrong samples, from "
                f"{run.format_interval(thrust.start, thrust.end)} "
                f"({thrust.acceleration:.2g} m/s² that gravity does not explain): expected a run "
                "without maneuvers. Start the run after the maneuver, or shorten the run"
            )
    return coasting
