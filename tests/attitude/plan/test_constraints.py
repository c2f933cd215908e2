"""Constraint tables of plans against the reference filter, and violations in exported files."""

import dataclasses
import io

import brahe.ccsds
import numpy as np
import pandas as pd
import pytest
from ccsds_ndm.ndm_io import NdmIo
from mgeo_attitude import AttitudeManeuverProblem, run_reference_filter
from mgeo_attitude.plan import ManeuverPlan, format_aem, to_csv
from scipy.spatial.transform import Rotation

from ..criteria.test_objectives import LIMITED, designs
from ..filter.path_constraint_reference import path_angles


@pytest.fixture(scope="module")
def plans():
    """Three short plans, some of which violate constraints."""
    problem = AttitudeManeuverProblem(dataclasses.replace(LIMITED, duration=240.0))
    X = designs(9)[[2, 3, 8]]
    X[:, 3::4] *= 0.4
    return [ManeuverPlan.from_design(problem, x) for x in X]


@pytest.fixture(scope="module")
def violating(plans):
    return next(plan for plan in plans if len(plan.list_violations()) > 1)


def compute_reference_values(plan):
    """Yield momentum, Sun angles and worst-axis 1-sigmas of a run of the reference filter."""
    model = plan.problem.model
    run = run_reference_filter(model, plan.design)
    C = run.attitude
    rotations = Rotation.from_matrix(C[:-1] @ C[1:].transpose(0, 2, 1)).as_rotvec()
    yield np.abs(rotations / model.step @ plan.scenario.wheels.inertia_matrix()).max()
    yield from np.degrees(path_angles(model, run, plan.design))
    sigma = run.sigma[-1].reshape(-1, 3).max(axis=1)
    yield from (np.degrees(sigma[0]), np.degrees(sigma[1]) * 3600.0)


def test_values_equal_those_of_the_reference_filter(plans):
    tables = [plan.build_constraint_table() for plan in plans]
    for plan, table in zip(plans, tables, strict=True):
        np.testing.assert_allclose(table["value"], list(compute_reference_values(plan)), rtol=1e-9)
        excess = table["value"] - table["bound_value"]
        signs = table["bound_type"].map({"at most": -1.0, "at least": 1.0})
        np.testing.assert_allclose(table["margin"], signs * excess, atol=1e-12)
        assert (table["satisfied"] == (table["margin"] >= 0.0)).all()
    satisfied = np.array([table["satisfied"] for table in tables])
    # Most of the five constraints are violated by one plan and satisfied by another.
    assert (~satisfied).any(axis=0).sum() >= 4
    assert satisfied.any(axis=0).sum() >= 4


def test_exported_files_list_violations(violating):
    """Independent readers still accept ephemerides with these comments."""
    expected = [f"VIOLATED CONSTRAINT: {violation}" for violation in violating.list_violations()]
    for version in ("1.0", "2.0"):
        text = format_aem(violating, version=version)
        lines = text.partition("CREATION_DATE")[0].splitlines()
        assert lines[2:] == [f"COMMENT {line}" for line in expected]
    assert NdmIo().from_string(format_aem(violating, version="1.0")).header.comment[1:] == expected
    message = brahe.ccsds.AEM.from_str(format_aem(violating, version="2.0"))
    assert len(message.segments) == len(violating.phases)
    text = to_csv(violating)
    assert text.splitlines()[: len(expected)] == [f"# {line}" for line in expected]
    table = pd.read_csv(io.StringIO(text), comment="#")
    assert table["phase"].tolist() == [phase.label for phase in violating.phases]
