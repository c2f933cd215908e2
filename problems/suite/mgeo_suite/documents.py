"""Declarations of the JSON documents of ``mgeo suite``."""

from __future__ import annotations

from typing_extensions import TypedDict

from mgeo.validation.documents import Document, extensible


class BudgetRow(TypedDict):
    """Most accurate suite within a budget."""

    budget_keur: float
    """Budget."""
    solution: int | None
    """Number of the suite in the front, from 0; null if no suite is within the budget."""
    price_keur: float | None
    """Price of the suite."""
    attitude_1sigma_deg: float | None
    """Attitude accuracy, 1-sigma about the worst of all axes."""
    suite: str | None
    """Instruments of the suite."""


class PriceRow(TypedDict):
    """Lowest price of the suites that reach an attitude accuracy."""

    attitude_1sigma_deg: float
    """Attitude accuracy, 1-sigma about the worst of all axes."""
    price_keur: float | None
    """Lowest price of a suite of this accuracy; null if the front has none."""
    price_without_star_tracker_keur: float | None
    """Lowest price of such a suite without star tracker; null if the front has none."""


class ConcludeDocument(TypedDict):
    """Best suites and lowest prices on a front of sensor suites."""

    folder: str
    """Run folder."""
    budgets: list[BudgetRow]
    """Most accurate suite within each budget."""
    accuracies: list[PriceRow]
    """Lowest price of each accuracy."""


@extensible
class GradeRow(TypedDict):
    """Gyro or sensor in a catalog.

    Further keys are those of the gyro or the sensor in a scenario file, such as `noise_nt`.
    """

    name: str
    """Name of the product."""
    price_keur: float
    """Price."""
    mass_g: float
    """Mass."""
    power_mw: float
    """Power consumption."""
    source: str
    """Source of the values."""


class CatalogDocument(TypedDict):
    """Catalog of sensors, with the same keys as a catalog file in TOML."""

    faces: list[str]
    """Faces of the satellite on which Sun sensors can be mounted."""
    gyros: list[GradeRow]
    """Gyros."""
    magnetometers: list[GradeRow]
    """Magnetometers."""
    star_trackers: list[GradeRow]
    """Star trackers."""
    sun_sensors: list[GradeRow]
    """Sun sensors."""


DOCUMENTS = {
    "suite-catalog": Document("mgeo suite catalog", (CatalogDocument,)),
    "suite-conclude": Document("mgeo suite conclude", (ConcludeDocument,)),
}
