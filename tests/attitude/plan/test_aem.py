"""Attitude ephemeris messages as two independent readers understand them.

ccsds-ndm validates version 1.0, the default, against its schema. brahe reads version 2.0 and
rotates vectors with it. Each of them rejects the other version.
"""

import dataclasses
from datetime import UTC, datetime

import brahe
import brahe.ccsds
import numpy as np
import pytest
from ccsds_ndm.ndm_io import NdmIo
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.plan import ManeuverPlan, format_aem
from scipy.spatial.transform import Rotation

from .conftest import DESIGN

CREATED = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
NAMES = {"object_name": "AMAZONIA-1", "object_id": "2021-015A", "originator": "INPE"}


def to_epoch(plan, seconds):
    """Return an instant of a plan as an epoch of brahe; the scenario starts at midnight."""
    epoch = plan.scenario.epoch
    return brahe.Epoch.from_datetime(
        epoch.year, epoch.month, epoch.day, 0, 0, float(seconds), 0.0, brahe.TimeSystem.UTC
    )


def rotation_matrix(segment, epoch):
    """Return brahe's rotation matrix from GCRF to body at an epoch."""
    return np.array(segment.rotation_matrix(epoch).to_matrix())


def read_version_2(plan, **keywords):
    return brahe.ccsds.AEM.from_str(format_aem(plan, version="2.0", **keywords))


@pytest.fixture(scope="module")
def message(plan):
    return read_version_2(plan, creation_time=CREATED, **NAMES)


def test_metadata_are_read_back(plan, message):
    assert message.format_version == 2.0
    assert message.originator == "INPE"
    assert str(message.creation_date).startswith("2026-01-02 03:04:05.000 UTC")
    assert len(message.segments) == len(plan.phases) == 3
    for segment, phase in zip(message.segments, plan.phases, strict=True):
        assert (segment.object_name, segment.object_id) == ("AMAZONIA-1", "2021-015A")
        assert segment.center_name == "EARTH"
        assert (segment.ref_frame_a, segment.ref_frame_b) == ("GCRF", "SC_BODY_1")
        assert (str(segment.time_system), str(segment.attitude_type)) == (
            "UTC",
            "QUATERNION/ANGVEL",
        )
        assert segment.angvel_frame == "SC_BODY_1"
        assert (segment.interpolation_method, segment.interpolation_degree) == ("LINEAR", 1)
        assert segment.start_time == to_epoch(plan, phase.start)
        assert segment.stop_time == to_epoch(plan, phase.end)
        assert len(segment.states) == phase.duration + 1
        assert phase.label in segment.metadata_comments[0]


def test_attitudes_equal_those_of_the_filter(plan, message):
    """Between filter steps, the interpolation error is below 0.03 arc seconds."""
    for i, phase in enumerate(plan.phases):
        segment = message.segment_to_attitude_trajectory(i)
        for k in np.unique(np.rint(np.linspace(phase.start, phase.end, 9)).astype(int)):
            C = plan.history.attitude[k]
            np.testing.assert_allclose(rotation_matrix(segment, to_epoch(plan, k)), C, atol=1e-14)
        k = int(phase.start)
        rotation = Rotation.from_rotvec(
            -0.5 * np.array(phase.rates_deg_s), degrees=True
        ).as_matrix()
        between = (
            rotation_matrix(segment, to_epoch(plan, k + 0.5))
            @ (rotation @ plan.history.attitude[k]).T
        )
        assert Rotation.from_matrix(between).magnitude() < np.radians(0.03 / 3600.0)


def build_ramped_plan(problem):
    """Return a plan with ramps between maneuvers, as slew limits require."""
    paper = problem.scenario
    limits = dataclasses.replace(paper.maneuvers, max_acceleration_deg_s2=0.05, count=3)
    return ManeuverPlan(dataclasses.replace(paper, maneuvers=limits), DESIGN)


@pytest.mark.cases(1)
@pytest.mark.parametrize("ramps", [False, True])
def test_rates_in_both_versions_equal_planned_rates(plan, problem, ramps):
    """Version 2.0 has angular velocities; version 1.0 has derivatives of its quaternions."""
    plan = build_ramped_plan(problem) if ramps else plan
    first, second = NdmIo().from_string(format_aem(plan)), read_version_2(plan)
    segments = zip(first.body.segment, second.segments, plan.phases, strict=True)
    for one, two, phase in segments:
        is_steady = not phase.label.startswith("ramp")
        velocities = np.array([state.angular_velocity for state in two.states])
        mean = np.radians(phase.rates_deg_s)
        if is_steady:
            np.testing.assert_allclose(velocities, np.tile(mean, (len(velocities), 1)), atol=1e-12)
        states = [state.quaternion_derivative for state in one.data.attitude_state]
        q = np.array([[getattr(s.quaternion, k) for k in ("q1", "q2", "q3", "qc")] for s in states])
        names = ("q1_dot", "q2_dot", "q3_dot", "qc_dot")
        dots = np.array([[getattr(s.quaternion_rate, k).value for k in names] for s in states])
        if len(q) > 2:
            at = np.linspace(phase.start, phase.end, len(q))
            differences = np.gradient(q, at, axis=0, edge_order=2)
            np.testing.assert_allclose(dots, differences, atol=2e-6 if is_steady else 3e-5)
        np.testing.assert_allclose(np.einsum("ki,ki->k", q, dots), 0.0, atol=1e-14)


@pytest.mark.parametrize("spacing", [0.3, 7.0, 1e6])
def test_any_spacing_includes_filter_attitudes_at_phase_ends(plan, spacing):
    aem = read_version_2(plan, spacing=spacing)
    for i, (segment, phase) in enumerate(zip(aem.segments, plan.phases, strict=True)):
        assert len(segment.states) == np.ceil(phase.duration / spacing) + 1
        trajectory = aem.segment_to_attitude_trajectory(i)
        for k in (int(phase.start), int(phase.end)):
            attitude = rotation_matrix(trajectory, to_epoch(plan, k))
            np.testing.assert_allclose(attitude, plan.history.attitude[k], atol=1e-14)


def test_version_1_conforms_to_schema(plan):
    message = NdmIo().from_string(format_aem(plan, creation_time=CREATED, **NAMES))
    assert message.version == "1.0"
    assert len(message.body.segment) == len(plan.phases)
    for segment, phase in zip(message.body.segment, plan.phases, strict=True):
        meta = segment.metadata
        assert (meta.ref_frame_a, meta.ref_frame_b) == ("GCRF", "SC_BODY_1")
        assert (meta.attitude_dir.value, meta.quaternion_type.value) == ("A2B", "LAST")
        assert (meta.time_system.value, meta.attitude_type.value) == (
            "UTC",
            "QUATERNION/DERIVATIVE",
        )
        assert [meta.start_time, meta.stop_time] == format_time_stamps(
            plan.scenario.epoch, [phase.start, phase.end]
        )
        states = segment.data.attitude_state
        assert len(states) == phase.duration + 1
        last = states[-1].quaternion_derivative.quaternion
        C = Rotation.from_quat([last.q1, last.q2, last.q3, last.qc]).inv().as_matrix()
        np.testing.assert_allclose(C, plan.history.attitude[int(phase.end)], atol=1e-14)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"version": "3.0"}, r"version = '3\.0': expected one of 1\.0, 2\.0"),
        ({"object_name": "SAT\nORIGINATOR = X"}, "object_name = "),
        ({"object_id": "2021-015Aa"}, "all upper or all lower case"),
        ({"creation_time": datetime(2026, 1, 1)}, "UTC offset"),
    ],
)
def test_invalid_arguments_are_rejected(plan, keywords, message):
    with pytest.raises(ValueError, match=message):
        format_aem(plan, **keywords)
