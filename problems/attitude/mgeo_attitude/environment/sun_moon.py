"""Positions of Sun and Moon, eclipses and albedo.

Sun: planetary theory of IAU SOFA (VSOP2000, epv00), in GCRS axes. The direction is geometric: light
time and the aberration by the Earth's motion (0.0057°) are omitted, as an ideal Sun sensor model
would remove them. The Earth is a sphere without atmosphere.

Moon: truncated lunar theory of Meeus (Astronomical Algorithms, 2nd edition, 1998, chapter 47), as
in erfa's moon98, in GCRS axes. Its direction differs from ELP/MPP02 by 2.9 arcsec rms and by at
most 18 arcsec (1950 to 2100), less than a hundredth of the disc.
"""

from __future__ import annotations

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import ASTRONOMICAL_UNIT, DAY, EARTH_RADIUS, SUN_RADIUS
from mgeo_attitude.environment.times import JulianDates

#: Number of points of the integral over the illuminated Earth, for a relative error of 1e-4.
_N_EMISSION_ANGLES = 32
#: Number of instants above which the position of the Sun is interpolated.
_MAX_EXACT_INSTANTS = 20000
#: Interval between the nodes of the interpolation [days].
_NODE_SPACING = 600.0 / DAY
#: Smallest angle between the centers of Sun and Earth [rad], which avoids a division by zero.
_MIN_SEPARATION = 1e-9


def sun_position(at: JulianDates) -> Floats:
    """Compute the position of the Sun relative to the Earth [m] in GCRS, shape (n, 3).

    The planetary theory takes 0.04 ms per instant. For many instants, the theory is evaluated every
    ten minutes and interpolated by cubic Hermite polynomials, whose error is below the rounding
    error.
    """
    span = float(at.tt[-1] - at.tt[0]) if len(at.tt) else 0.0
    nodes = int(span / _NODE_SPACING) + 2
    if len(at.tt) <= _MAX_EXACT_INSTANTS or nodes > len(at.tt):
        heliocentric_earth, _ = erfa.epv00(at.midnight, at.tt)
        return np.asarray(-ASTRONOMICAL_UNIT * heliocentric_earth["p"])
    from scipy.interpolate import CubicHermiteSpline  # This import takes long.

    tt = np.linspace(at.tt[0], at.tt[-1], nodes)
    node_states, _ = erfa.epv00(at.midnight, tt)
    earth: Floats = CubicHermiteSpline(tt, node_states["p"], node_states["v"])(
        at.tt
    )  # Units are au and au/day.
    return -ASTRONOMICAL_UNIT * earth


def sun_direction(position: Floats, sun: Floats) -> Floats:
    """Return unit vectors from the satellite to the Sun, shape (n, 3).

    Both input positions are in meters and in the same axes.
    """
    to_sun = sun - position
    return np.asarray(to_sun / np.linalg.norm(to_sun, axis=-1, keepdims=True))


def visible_sun_fraction(position: Floats, sun: Floats) -> Floats:
    """Return the fraction of the Sun's disc that the Earth does not cover, shape (n,).

    The fraction is 1 in sunlight and 0 in the umbra. The discs of Sun and Earth are circles on the
    celestial sphere (Montenbruck & Gill, Satellite Orbits, section 3.4.2). The boundaries of umbra
    and penumbra are exact.

    Parameters
    ----------
    position, sun : arrays, shape (n, 3)
        Positions of satellite and Sun relative to the Earth's center [m].

    Raises
    ------
    ValueError
        If a position is below the Earth's surface.
    """
    distance = np.linalg.norm(position, axis=1)
    if not (distance >= EARTH_RADIUS).all():
        raise ValueError(
            f"position: expected a satellite above the Earth's surface, |r| >= {EARTH_RADIUS} m, "
            f"but the least |r| is {distance.min():.1f} m"
        )
    to_sun = sun - position
    sun_distance = np.linalg.norm(to_sun, axis=1)
    cosine = -np.einsum("ni,ni->n", position, to_sun) / (distance * sun_distance)
    a = np.arcsin(SUN_RADIUS / sun_distance)
    b = np.arcsin(EARTH_RADIUS / distance)
    c = np.maximum(np.arccos(np.clip(cosine, -1.0, 1.0)), _MIN_SEPARATION)
    x = (c * c + a * a - b * b) / (2.0 * c)  # Distance of the chord through the crossings
    half_chord = np.sqrt(np.maximum(a * a - x * x, 0.0))
    sun_sector = a * a * np.arccos(np.clip(x / a, -1.0, 1.0))
    earth_sector = b * b * np.arccos(np.clip((c - x) / b, -1.0, 1.0))
    return np.asarray(1.0 - (sun_sector + earth_sector - c * half_chord) / (a * a * np.pi))


def sun_limb_angle(position: Floats, sun: Floats) -> Floats:
    """Return the angle [rad] from the Earth's limb to the Sun's center, as seen from the satellite.

    The angle, shape (n,), is positive where the Sun's center is visible. The angle is negative if
    the Earth covers the Sun's center. Where the angle is zero to within 3e-6 rad,
    `visible_sun_fraction` is one half.

    Parameters
    ----------
    position : array, shape (n, 3)
        Position of the satellite [m].
    sun : array, shape (n, 3)
        Unit vectors to the Sun, in the same axes.
    """
    distance = np.linalg.norm(position, axis=1)
    cosine = -np.einsum("ni,ni->n", position, sun) / distance
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)) - np.arcsin(EARTH_RADIUS / distance))


def albedo_vector(position: Floats, sun: Floats) -> Floats:
    """Compute the sunlight that the Earth reflects to the satellite, as one vector per sample.

    The vectors, shape (n, 3), are in units of direct sunlight. The component along a direction is
    the cosine-law signal of a flat cell that faces the direction, minus the signal of a cell that
    faces the opposite direction. The vector is added to the measurement of a coarse Sun sensor. The
    Earth is a Lambert sphere of reflectivity 1: D. D. V. Bhanderi, T. Bak, Modeling Earth Albedo
    for Satellites in Earth Orbit, AIAA GNC 2005, with a constant reflectivity instead of maps. The
    mean reflectivity of the Earth is 0.29 (G. L. Stephens et al., The albedo of Earth, Reviews of
    Geophysics 53, 2015).

    Parameters
    ----------
    position : array, shape (n, 3)
        Position of the satellite [m].
    sun : array, shape (n, 3)
        Unit vectors to the Sun, in the same axes.
    """
    r = np.linalg.norm(position, axis=1, keepdims=True)
    up = position / r
    cosine = np.sum(
        up * sun, axis=1, keepdims=True
    )  # Cosine of the Sun's zenith angle at the subsatellite point
    ahead = sun - cosine * up
    sine = np.linalg.norm(ahead, axis=1, keepdims=True)
    ahead = ahead / np.maximum(sine, _MIN_SEPARATION)
    # Integrate over rings of the visible cap by the emission angle. A ring about nadir has the
    # angular radius `nadir` seen from the satellite and `arc` seen from the Earth's center.
    nodes, weights = np.polynomial.legendre.leggauss(_N_EMISSION_ANGLES)
    emission = 0.25 * np.pi * (nodes + 1.0)
    nadir = np.arcsin(EARTH_RADIUS / r * np.sin(emission))
    arc = emission - nadir
    derivative = EARTH_RADIUS / r * np.cos(emission) / np.cos(nadir)  # Derivative of `nadir`
    # The irradiance of a ring is a + b cos φ where it is positive, that is, for |φ| below `lit`.
    a, b = cosine * np.cos(arc), sine * np.sin(arc)
    half_width = np.arccos(np.clip(-a / np.maximum(b, 1e-300), -1.0, 1.0))
    mean_irradiance = 2.0 * (a * half_width + b * np.sin(half_width))
    forward_irradiance = 2.0 * a * np.sin(half_width) + b * (
        half_width + 0.5 * np.sin(2.0 * half_width)
    )
    ring = (
        0.25 * weights * derivative * np.sin(nadir)
    )  # This includes the factor 1/π of a Lambert surface.
    down = np.sum(ring * mean_irradiance * np.cos(nadir), axis=1, keepdims=True)
    along = np.sum(ring * forward_irradiance * np.sin(nadir), axis=1, keepdims=True)
    return np.asarray(along * ahead - down * up)


def moon_position(at: JulianDates) -> Floats:
    """Compute the position of the Moon relative to the Earth [m] in GCRS, shape (n, 3).

    The position is geometric: light time is not included.
    """
    return np.asarray(ASTRONOMICAL_UNIT * erfa.moon98(at.midnight, at.tt)["p"])
