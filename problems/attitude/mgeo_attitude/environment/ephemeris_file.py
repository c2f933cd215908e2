"""An ephemeris in a file of another tool: the samples that a run needs."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from mgeo_attitude.environment.ephemeris import (
    DEFAULT_DEGREE,
    SAME_INSTANT,
    EphemerisOrbit,
    points,
)
from mgeo_attitude.environment.ephemeris_formats import Origin, Segment
from mgeo_attitude.environment.frames import frame_name, to_gcrs
from mgeo_attitude.environment.times import instants, utc_text


@dataclass(frozen=True)
class Run:
    """What an ephemeris is for: a run of `duration` [s] from an epoch with a UTC offset, and how
    one interpolates, if not as a file says."""

    epoch: datetime
    duration: float
    interpolation: str | None = None
    degree: int | None = None


def ephemeris_of(segments: Sequence[Segment], run: Run, origin: Origin) -> EphemerisOrbit:
    """The samples for a run, with those before and after it that interpolation takes.

    A run that is in no segment alone is in some that meet at instants, with jumps there.

    Raises
    ------
    ValueError
        Naming what is wrong or missing, such as a part of the run.
    """
    segment = _covering(segments, run.epoch, run.duration)
    method = run.interpolation or segment.interpolation
    velocity = None if method == "lagrange" else segment.velocity
    if method == "hermite" and velocity is None:
        raise ValueError("interpolation = 'hermite': expected a table with velocities")
    degree = run.degree or segment.degree or DEFAULT_DEGREE
    margin = points(degree, velocity is not None)
    first, last = np.searchsorted(segment.times, [SAME_INSTANT, run.duration - SAME_INSTANT])
    kept = slice(max(0, first - 1 - margin), last + 1 + margin)
    times, frozen = segment.times[kept], segment.frame_epoch
    position, velocity = to_gcrs(
        frame_name(segment.frame),
        instants(run.epoch, times),
        segment.position[kept],
        None if velocity is None else velocity[kept],
        None if frozen is None else instants(run.epoch, [frozen]),
    )
    orbit = EphemerisOrbit(
        source=origin.of(segment.name),
        epoch=run.epoch,
        degree=degree,
        times=times.tolist(),
        position=position.tolist(),
        velocity=() if velocity is None else velocity.tolist(),
    )
    return orbit.for_run(run.epoch, run.duration)


def one_object(segments: Sequence[Segment], wanted: str) -> list[Segment]:
    """The segments of the object whose name or designator is wanted, or of the only one.

    Raises
    ------
    ValueError
        Naming the objects that there are.
    """
    words = wanted.casefold()
    found = [
        each
        for each in segments
        if not words or words in (each.name.casefold(), *each.name.casefold().rsplit(" ", 1))
    ]
    names = list(dict.fromkeys(each.name for each in found or segments))
    if not found or len(names) > 1:
        said = f"no object {wanted!r}" if wanted else f"{len(names)} objects"
        raise ValueError(f"{said}: expected object, a name, of {', '.join(names[:10])}")
    return found


def _grown(segment: Segment, others: Sequence[Segment], duration: float) -> Segment:
    """The segment with those of its kind that go on where it ends, as far as a run needs them.

    They meet at the first instant that both have a sample of and are good at. It is there twice,
    before and after a jump.
    """
    left = [each for each in others if each is not segment and _same_kind(segment, each)]
    while _span(segment)[1] + SAME_INSTANT < duration:
        for k, each in enumerate(left):
            shared = np.intersect1d(segment.times, each.times)
            shared = shared[(shared >= each.start) & (shared <= segment.stop)]
            if len(shared) and segment.times[0] < shared[0] and _span(each)[1] > _span(segment)[1]:
                segment = _after(segment, left.pop(k), shared[0])
                break
        else:
            break
    return segment


def _span(segment: Segment) -> tuple[float, float]:
    """From when to when it is good [s]."""
    return max(segment.times[0], segment.start), min(segment.times[-1], segment.stop)


def _same_kind(one: Segment, other: Segment) -> bool:
    keys = ("name", "frame", "frame_epoch", "interpolation", "degree")
    return all(getattr(one, key) == getattr(other, key) for key in keys)


def _after(before: Segment, segment: Segment, instant: float) -> Segment:
    own, others = before.times <= instant, segment.times >= instant
    velocity = None
    if before.velocity is not None and segment.velocity is not None:
        velocity = np.concatenate([before.velocity[own], segment.velocity[others]])
    return dataclasses.replace(
        before,
        stop=segment.stop,
        times=np.concatenate([before.times[own], segment.times[others]]),
        position=np.concatenate([before.position[own], segment.position[others]]),
        velocity=velocity,
    )


def _covering(segments: Sequence[Segment], epoch: datetime, duration: float) -> Segment:
    """The one that reaches from start to end of a run, or those that do so together."""
    for grow in (False, True):
        for segment in segments:
            start, _ = _span(segment)
            if start <= SAME_INSTANT:
                found = _grown(segment, segments, duration) if grow else segment
                if duration <= _span(found)[1] + SAME_INSTANT:
                    return found
    spans = [" to ".join(utc_text(epoch, end) for end in _span(segment)) for segment in segments]
    more = f" and {len(spans) - 3} more" if len(spans) > 3 else ""
    raise ValueError(
        f"expected samples for the whole run, from {utc_text(epoch, 0.0)} to "
        f"{utc_text(epoch, duration)}, in one segment, or in some that share an instant; "
        f"found from {' and from '.join(spans[:3])}{more}"
    )
