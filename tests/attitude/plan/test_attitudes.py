"""Attitude files for other programs, each read by an independent library where there is one.

SPICE (spiceypy) reads the C-kernel, and orbit-formats reads the STK file.
"""

import brahe
import brahe.ccsds
import numpy as np
import pytest
from ccsds_ndm.ndm_io import NdmIo
from mgeo_attitude.plan.aem import format_aem
from mgeo_attitude.plan.attitudes import gcrf_to_eme2000
from mgeo_attitude.plan.files import write_plan
from mgeo_attitude.plan.spice import build_ck
from scipy.spatial.transform import Rotation

from .test_aem import build_ramped_plan

#: Leap seconds and constants of TDB - TT, from NAIF's naif0012.tls.
LEAPSECONDS = """KPL/LSK
\\begindata
DELTET/DELTA_T_A = 32.184
DELTET/K = 1.657D-3
DELTET/EB = 1.671D-2
DELTET/M = ( 6.239996D0 1.99096871D-7 )
DELTET/DELTA_AT = ( 36, @2015-JUL-1 37, @2017-JAN-1 )
\\begintext
"""


def to_matrices(q):
    """Return rotation matrices from inertial axes to body for quaternions with the scalar part
    last.
    """
    return np.swapaxes(Rotation.from_quat(q).as_matrix(), -1, -2)


def planned_attitude(plan, second):
    return plan.attitude[plan.to_steps([second])[0]]


def test_frame_bias_equals_that_of_brahe():
    """brahe uses IAU 2000, which differs from IAU 2006 by two micro arc seconds."""
    np.testing.assert_allclose(gcrf_to_eme2000(), brahe.bias_eme2000(), atol=2e-11)
    assert np.degrees(Rotation.from_matrix(gcrf_to_eme2000()).magnitude()) * 3600 == pytest.approx(
        0.0231, abs=1e-4
    )


@pytest.mark.parametrize("rates", ["given", "none"])
def test_ephemeris_in_eme2000_is_read_back(plan, rates):
    """The frame bias of brahe converts the attitudes that ccsds-ndm (1.0) and brahe (2.0) read."""
    first = NdmIo().from_string(format_aem(plan, rates=rates, frame="EME2000"))
    second = brahe.ccsds.AEM.from_str(format_aem(plan, version="2.0", rates=rates, frame="EME2000"))
    for one, two, phase in zip(first.body.segment, second.segments, plan.phases, strict=True):
        meta = one.metadata
        assert (meta.ref_frame_a, two.ref_frame_a) == ("EME2000", "EME2000")
        kinds = {"given": ("QUATERNION/DERIVATIVE", "QUATERNION/ANGVEL")}
        expected = kinds.get(rates, ("QUATERNION", "QUATERNION"))
        assert (meta.attitude_type.value, str(two.attitude_type)) == expected
        state = one.data.attitude_state[-1]
        q = state.quaternion_state if rates == "none" else state.quaternion_derivative
        q = q.quaternion
        C = to_matrices([q.q1, q.q2, q.q3, q.qc])
        np.testing.assert_allclose(
            C @ brahe.bias_eme2000(), planned_attitude(plan, phase.end), atol=3e-11
        )
        assert (
            abs(C - planned_attitude(plan, phase.end)).max() > 1e-8
        )  # Not only the name of the frame differs.
    if rates == "given":  # Angular velocities in body axes do not depend on the inertial frame.
        states = second.segments[0].states
        velocities = [state.angular_velocity for state in states]
        expected = np.tile(np.radians(plan.phases[0].rates_deg_s), (len(states), 1))
        np.testing.assert_allclose(velocities, expected, atol=1e-12)


@pytest.fixture
def kernels(tmp_path):
    """Function that writes the kernels of a plan and loads them into SPICE."""
    spiceypy = pytest.importorskip("spiceypy")

    def load(plan, **options):
        (tmp_path / "leap.tls").write_text(LEAPSECONDS)
        write_plan(plan, tmp_path / "plan.bc", **options)
        write_plan(plan, tmp_path / "plan.tsc", **options)
        for name in ("leap.tls", "plan.tsc", "plan.bc"):
            spiceypy.furnsh(str(tmp_path / name))

    load.spice = spiceypy
    yield load
    spiceypy.kclear()


@pytest.mark.parametrize("ramps", [False, True])
def test_spice_returns_attitude_and_rates_at_utc(plan, problem, kernels, ramps):
    """Between filter steps the attitude rotates at constant rate."""
    plan = build_ramped_plan(problem) if ramps else plan
    kernels(plan, naif_id=-123)
    spiceypy = kernels.spice
    for phase in plan.phases:
        if phase.duration < 3.0 or phase.label.startswith("ramp"):
            continue
        k = int(phase.start) + 1
        for seconds in (k, k + 0.5):
            stamp = f"{plan.scenario.epoch:%Y-%m-%d} 00:{seconds // 60:02.0f}:{seconds % 60:09.6f}"
            ticks = spiceypy.sce2c(-123, spiceypy.str2et(stamp))
            assert ticks == pytest.approx(1e6 * seconds, abs=1.0)  # A tick is a microsecond.
            C, velocity, _ = spiceypy.ckgpav(-123_000, ticks, 0.0, "J2000")
            back = Rotation.from_rotvec(
                -(seconds - k) * np.array(phase.rates_deg_s), degrees=True
            ).as_matrix()
            np.testing.assert_allclose(C, back @ planned_attitude(plan, k), atol=2e-8)
            np.testing.assert_allclose(C @ velocity, np.radians(phase.rates_deg_s), atol=1e-9)
    with pytest.raises(spiceypy.utils.exceptions.NotFoundError):
        spiceypy.ckgpav(-123_000, 1e6 * (plan.duration + 1.0), 0.0, "J2000")


def test_missing_spiceypy_is_reported(plan, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "spiceypy", None)
    with pytest.raises(ImportError, match="needs the package spiceypy: pip install spiceypy"):
        build_ck(plan)


def test_orbit_formats_reads_stk_and_aem_without_rates(plan, tmp_path):
    reader = pytest.importorskip("orbit_formats")
    names = {"plan.a": {}, "one.aem": {}, "two.aem": {"version": "2.0"}}
    for name, options in names.items():
        write_plan(plan, tmp_path / name, rates="none", **options)
        ephemeris = reader.read(tmp_path / name)
        assert ephemeris.attitude_type == "QUATERNION"
        assert ephemeris.frame_a == ("ICRF" if name == "plan.a" else "GCRF")
        times = (ephemeris.epochs - np.datetime64("2018-06-05T00:00:00")) / np.timedelta64(1, "s")
        assert times[[0, -1]].tolist() == [0.0, plan.duration]
        C = to_matrices(ephemeris.records)
        np.testing.assert_allclose(C, plan.attitude[plan.to_steps(times)], atol=1e-14)
    write_plan(plan, tmp_path / "rates.aem")
    # The option rates="none" exists because the reader rejects rates.
    with pytest.raises(reader.MalformedSourceError, match="QUATERNION/DERIVATIVE"):
        reader.read(tmp_path / "rates.aem")


def test_unknown_options_are_rejected(plan, tmp_path):
    with pytest.raises(TypeError, match="unknown keyword 'spacings'; did you mean 'spacing'"):
        write_plan(plan, tmp_path / "plan.a", spacings=3.0)
    for key, value in (("rates", "few"), ("frame", "TEME")):
        with pytest.raises(ValueError, match=rf"{key} = '{value}': expected "):
            write_plan(plan, tmp_path / "plan.aem", **{key: value})
    assert not list(tmp_path.iterdir())
