"""What a plan says of its constraints: against the slow filter's run, and in every file."""

import contextlib
import dataclasses
import io
import json

import brahe.ccsds
import numpy as np
import pandas as pd
import pytest
from ccsds_ndm.ndm_io import NdmIo
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.commands.files import Picked
from mgeo_attitude.commands.show import plan_document, print_plan
from mgeo_attitude.plan import ManeuverPlan, aem_text, from_json, to_csv, to_json
from mgeo_attitude.scenario import FlightErrors
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.describe import two_digits
from scipy.spatial.transform import Rotation

from mgeo.cli.output import Output

from ..between import worst_excess
from ..criteria.test_limits import LIMITED, designs


@pytest.fixture(scope="module")
def plans():
    """Three short plans under limits that some of them violate."""
    problem = AttitudeManeuverProblem(dataclasses.replace(LIMITED, duration=240.0))
    X = designs(9)[[2, 3, 8]]
    X[:, 3::4] *= 0.4
    return [ManeuverPlan.from_design(problem, x) for x in X]


@pytest.fixture(scope="module")
def violating(plans):
    return next(plan for plan in plans if len(plan.violations()) > 1)


def by_hand(plan):
    """Momentum, angles to the Sun and worst 1-sigmas, from the reference filter's attitudes."""
    C, model = plan.history.attitude, plan.problem.model
    turns = Rotation.from_matrix(C[:-1] @ C[1:].transpose(0, 2, 1)).as_rotvec()
    yield np.abs(turns / model.step @ plan.scenario.wheels.matrix()).max()
    for limit in model.path_limits:
        sun, _ = model.direction("sun", slice(len(C)))
        yield -np.degrees(worst_excess(C, sun, limit.cone().axis))
    sigma = (plan.history.sigma[-1] / model.required_sigma).reshape(-1, 3)
    units = block_units(model.suite)
    for block, unit in enumerate(units):
        if sigma[block].any():
            yield sigma[block].max() * model.required_sigma[3 * block] * unit.factor


def test_values_are_those_of_the_reference_filter(plans):
    tables = [plan.constraints() for plan in plans]
    for plan, table in zip(plans, tables, strict=True):
        np.testing.assert_allclose(table["value"], list(by_hand(plan)), rtol=1e-9)
        over = table["value"] - table["limit"]
        signs = table["bound"].map({"at most": -1.0, "at least": 1.0})
        np.testing.assert_allclose(table["margin"], signs * over, atol=1e-12)
        assert (table["kept"] == (table["margin"] >= 0.0)).all()
    kept = np.array([table["kept"] for table in tables])
    assert (~kept).any(axis=0).sum() >= 4  # of the five limits; they mean something here
    assert kept.any(axis=0).sum() >= 4


def test_units_are_those_of_the_limits(plans):
    table = plans[0].constraints()
    assert list(zip(table.index, table["unit"], strict=True)) == [
        ("wheel momentum", "N m s"),
        ("Sun off payload", "deg"),
        ("Sun off second", "deg"),
        ("required 1-sigma of attitude", "deg"),
        ("required 1-sigma of gyro bias", "deg/h"),
    ]
    assert table["limit"].tolist()[:3] == [5e-4, pytest.approx(30.0), pytest.approx(60.0)]


def test_kept_is_what_the_optimizer_takes_for_it(plans):
    problem = plans[0].problem
    G = problem.evaluate(np.array([plan.design for plan in plans]), return_values_of=["G"])
    for plan, g in zip(plans, G, strict=True):
        kept = plan.constraints()["kept"].to_numpy(bool)
        assert [*kept[:3], kept[3:].all()] == (g <= 0.0).tolist()
        assert len(plan.violations()) == (~kept).sum()


def test_no_limits_no_constraints(plan):
    assert plan.violations() == []
    assert len(plan.constraints()) == 0
    assert "VIOLATED" not in aem_text(plan) + to_csv(plan) + to_json(plan)


def test_the_files_of_a_plan_that_violates_them_say_so(violating):
    """Comments in both editions of the ephemeris, which others still read, and in CSV."""
    named = [f"VIOLATED CONSTRAINT: {violation}" for violation in violating.violations()]
    for version in ("1.0", "2.0"):
        text = aem_text(violating, version=version)
        lines = text.partition("CREATION_DATE")[0].splitlines()
        assert lines[2:] == [f"COMMENT {line}" for line in named]
    assert NdmIo().from_string(aem_text(violating, version="1.0")).header.comment[1:] == named
    message = brahe.ccsds.AEM.from_str(aem_text(violating, version="2.0"))
    assert len(message.segments) == len(violating.phases)
    text = to_csv(violating)
    assert text.splitlines()[: len(named)] == [f"# {line}" for line in named]
    table = pd.read_csv(io.StringIO(text), comment="#")
    assert table["phase"].tolist() == [phase.label for phase in violating.phases]


def test_a_plan_read_back_computes_them_anew(violating):
    back = from_json(to_json(violating))
    pd.testing.assert_frame_equal(back.constraints(), violating.constraints(), check_exact=True)
    assert back.violations() == violating.violations()


def test_names_that_no_line_of_an_ephemeris_holds(violating):
    """Neither other scripts nor long ones."""
    first, *others = violating.scenario.path_limits
    named = [dataclasses.replace(cone, name="câmera " * 50) for cone in (first, *others)]
    scenario = dataclasses.replace(violating.scenario, path_limits=tuple(named))
    text = aem_text(ManeuverPlan(scenario, violating.design))
    assert text.isascii()
    assert "COMMENT VIOLATED CONSTRAINT: Sun off c?mera" in text
    assert max(map(len, text.splitlines())) <= 254


@pytest.mark.slow
def test_the_attitude_is_one_number_everywhere(plans):
    """What answers, tables and files tell of it is what the requirement is compared with."""
    for plan in plans:
        compared = plan.constraints()["value"]["required 1-sigma of attitude"]
        rotated = np.degrees(np.sqrt(np.linalg.eigvalsh(plan.history.covariance[:3, :3])[-1]))
        assert rotated > 1.005 * compared  # about some other axis it is known worse
        assert f" attitude {two_digits(compared)} deg" in plan.answer
        (row,) = plan.problem.view([plan.design]).describe().to_dict("records")
        document = plan_document(Picked(plan, "plan"))
        predicted = json.loads(to_json(plan))["predicted"]
        of_each_axis = plan.accuracy()["after"][["attitude x", "attitude y", "attitude z"]]
        told = {
            "table of solutions": row["attitude 1-sigma [deg]"],
            "document": document["attitude_sigma_deg"],
            "file": predicted["attitude 1-sigma [deg]"],
            "accuracy": of_each_axis.max(),
            "plan": plan.attitude_sigma_deg,
        }
        assert told == pytest.approx(dict.fromkeys(told, compared), rel=1e-9)
        assert not [name for name in (*row, *document, *predicted) if "accuracy [" in name]
        with pytest.warns(DeprecationWarning, match="use attitude_sigma_deg"):
            assert plan.attitude_accuracy_deg == pytest.approx(rotated, rel=1e-9)


def test_values_over_flights_are_told_apart_from_those_flown_exactly(plans):
    """The requirement is compared with what most flights keep, the answer is of one flown."""
    plan = plans[0]
    flights = FlightErrors(count=20, kept=0.9)
    robust = ManeuverPlan(dataclasses.replace(plan.scenario, flight=flights), plan.design)
    name = "required 1-sigma of attitude"
    assert robust.constraints()["value"][name] != plan.constraints()["value"][name]
    for each, expected in ((plan, 0), (robust, 1)):
        with contextlib.redirect_stdout(shown := io.StringIO()):
            print_plan(Picked(each, "plan"), Output())
        text = " ".join(shown.getvalue().split())
        said = "values until t_end: what 90% of 20 flights keep; all other tables: flown exactly"
        assert text.count(said) == expected
