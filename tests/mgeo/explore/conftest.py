"""Run folder of the cantilever problem, with a constraint on the length of the beam."""

import pandas as pd
import pytest

from ..report.conftest import run_cache, solved  # noqa: F401


@pytest.fixture
def folder(solved, monkeypatch):  # noqa: F811
    from stand_in import CantileverView

    def constraints(self):
        columns = {"unit": "m", "bound_type": "at most", "bound_value": 0.5}
        return [
            pd.DataFrame({**columns, "value": length, "margin": 0.5 - length}, index=["length"])
            for length in self.X[:, 1]
        ]

    monkeypatch.setattr(CantileverView, "constraints", constraints, raising=False)
    return solved()
