"""Compiled loops of the smoother over the samples of a batch."""

from __future__ import annotations

from functools import cache
from importlib import resources
from types import ModuleType

from mgeo_attitude.filter import discretization, polynomials
from mgeo_attitude.filter.kernel import load_module

from mgeo_calibration.estimation.kernels import algebra, signatures


@cache
def load_compiled_module(name: str) -> ModuleType:
    """Load the compiled version of a module in this package. The result is cached."""
    source = resources.files(__package__).joinpath(f"{name}.py").read_text(encoding="utf-8")
    ingredients = [algebra, signatures, discretization, polynomials]
    return load_module("smoother", source, ingredients, name.replace("_", " "))
