"""Plugin for the tests: a problem that defines all optional methods and can be checked by hand.

The diameter and length of a steel cantilever with an end load minimize mass and deflection (first
example of Deb, "Multi-Objective Optimization using Evolutionary Algorithms").
"""

import math
import os
import time

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from pymoo.core.problem import Problem

from mgeo import View

DENSITY, MODULUS = 7800.0, 207e9  # kg/m^3, Pa
PRESETS = {"light": 500.0, "heavy": 2000.0}  # load [N]
DESCRIPTIONS = {name: f"load of {load:g} N" for name, load in PRESETS.items()}


class CantileverView(View):
    def describe(self):
        mass, deflection = self.F.T
        return pd.DataFrame({"mass [kg]": mass, "deflection [mm]": 1000 * deflection})

    def summaries(self):
        mass, deflection = self.F.T
        return [
            f"{m:.3g} kg that sag {1000 * d:.3g} mm" for m, d in zip(mass, deflection, strict=True)
        ]

    def warnings(self):
        return [f"{len(self.X)} beams, of steel"]

    def figures(self):
        mass, deflection = self.F.T
        figure = go.Figure(go.Scatter(x=mass, y=deflection, mode="markers"))
        return {"front": figure.update_layout(title="drawn by the plugin")}


class Cantilever(Problem):
    var_names = ("diameter [m]", "length [m]")
    obj_names = ("mass [kg]", "deflection [m]")
    preset_descriptions = DESCRIPTIONS

    def __init__(self, load=1000.0):
        if not load > 0:
            raise ValueError(f"load = {load!r}: expected > 0 N")
        self.load = float(load)
        super().__init__(n_var=2, n_obj=2, xl=[0.01, 0.2], xu=[0.05, 1.0])

    @classmethod
    def from_options(cls, options):
        remaining = dict(options)
        preset = remaining.pop("preset", None)
        if preset is not None and preset not in PRESETS:
            raise ValueError(f"preset = {preset!r}: expected one of {', '.join(PRESETS)}")
        loads = {"load": PRESETS[preset]} if preset else {}
        unknown = set(remaining) - {"load"}
        if unknown:
            raise ValueError(f"{min(unknown)}: unknown key, expected load")
        return cls(**(loads | remaining))

    def to_options(self):
        return {"load": self.load}

    def _evaluate(self, X, out, *args, **kwargs):
        diameter, length = X.T
        mass = DENSITY * math.pi / 4 * diameter**2 * length
        deflection = 64 * self.load * length**3 / (3 * MODULUS * math.pi * diameter**4)
        out["F"] = np.column_stack([mass, deflection])

    def map_to_indicator_space(self, F):
        return np.asarray(F) / [4.0, 0.01]

    def view(self, X):
        return CantileverView(self, X)

    def to_robust(self):
        """Return the problem with a load that is larger by the load uncertainty of 10 %."""
        return type(self)(1.1 * self.load)

    def suggest_initial_designs(self, n, random_state):
        return np.column_stack([random_state.uniform(0.01, 0.05, n), np.full(n, 0.2)])

    def refine(self, X):
        # One beam after the other becomes shorter in two steps. The shortest beam is the best.
        X = X.copy()
        for row in range(len(X)):
            for length in (0.5 * (X[row, 1] + 0.2), 0.2):
                X[row, 1] = length
                yield X


class SlowCantilever(Cantilever):
    """Cantilever whose batches take the time in STAND_IN_SECONDS [s], by default 0.02 s."""

    def _evaluate(self, X, out, *args, **kwargs):
        time.sleep(float(os.environ.get("STAND_IN_SECONDS", "0.02")))
        super()._evaluate(X, out, *args, **kwargs)
