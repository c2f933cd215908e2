"""The loops of the smoother, one sample after the other, compiled."""

from __future__ import annotations

from functools import cache
from importlib import resources
from types import ModuleType

from mgeo_attitude.filter import discretization, polynomials
from mgeo_attitude.filter.kernel import load_module

from mgeo_calibration.estimation.kernels import algebra, signatures


@cache
def load(name: str) -> ModuleType:
    """Compiled module of the text of a file beside this one, by its name."""
    source = resources.files(__package__).joinpath(f"{name}.py").read_text(encoding="utf-8")
    ingredients = [algebra, signatures, discretization, polynomials]
    return load_module("smoother", source, ingredients, name.replace("_", " "))
