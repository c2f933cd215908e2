"""Catalogs of sensor grades, and error messages for invalid ones."""

import copy

import pytest
from mgeo_suite import Catalog


def test_better_grades_of_the_default_catalog_cost_more():
    for section in ("gyros", "magnetometers", "sun_sensors", "star_trackers"):
        prices = [grade.cost.price_keur for grade in getattr(Catalog.default(), section)]
        assert prices == sorted(prices)


def test_catalog_survives_conversion_to_a_table(table):
    for catalog in (Catalog.default(), Catalog.from_dict(table)):
        assert Catalog.from_dict(catalog.to_dict()) == catalog
        assert hash(Catalog.from_dict(catalog.to_dict())) == hash(catalog)


def replace_entry(table, place, value):
    """Return a copy of nested dicts with another value at a path; None removes the entry."""
    table = copy.deepcopy(table)
    *path, last = place
    inner = table
    for key in path:
        inner = inner[key]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return table


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("gyroes",), [], r"gyroes: unknown key; did you mean 'gyros'"),
        (("gyros",), None, r"gyros = \[\]: expected at least one entry \[\[gyros\]\]"),
        (("gyros", 1, "mass_g"), None, r"gyros\[1\]\.mass_g: missing; expected a number >= 0 \[g"),
        (("gyros", 1, "mass_g"), "5 g", r"gyros\[1\]\.mass_g = '5 g': expected a number"),
        (("gyros", 1, "name"), "poor", r"gyros\[1\]\.name = 'poor': expected a name other than"),
        (("sun_sensors", 0, "name"), "none", r"sun_sensors\[0\]\.name = 'none': expected a name"),
        (
            ("sun_sensors", 1, "half_angle_deg"),
            180.0,
            r"sun_sensors\[1\], exclusions and field of view = \[\]: expected \['sun'\], as",
        ),
        (
            ("sun_sensors", 1, "initial_bias"),
            0.01,
            r"sun_sensors\[1\], states = \['misalignment', 'bias'\]: expected \['misal",
        ),
        (
            ("sun_sensors", 1, "sample_interval"),
            20.0,
            r"sun_sensors\[1\], sample_interval = 20\.0: expected None, as in sun_sensors\[0\]",
        ),
        (("faces",), ["+x", "up"], r"faces = \['\+x', 'up'\]: expected a list of '\+x', '-x'"),
    ],
)
def test_error_names_the_invalid_key(table, place, value, message):
    with pytest.raises(ValueError, match=message):
        Catalog.from_dict(replace_entry(table, place, value))


@pytest.mark.parametrize(
    ("text", "message"),
    [("[[gyros]\n", "mine.toml: .*line 1"), ("gyros = 1\n", "mine.toml: gyros = 1: expected ent")],
)
def test_error_names_the_invalid_file(tmp_path, text, message):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        Catalog.from_toml(path)
