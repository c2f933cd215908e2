"""Correction parameters invert the measurement models of gyro and sensors."""

from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from mgeo_attitude import Scenario, Suite
from mgeo_calibration.calibration.corrections import compute_corrections
from scipy.spatial.transform import Rotation

from mgeo.validation.documents import collect_documents

from ...attitude.filter.suites import SUITES


def predict_readings(suite: Suite, owner, states, vector):
    """Return readings without noise in telemetry units; varying states are zero."""
    x = {state: states[i : i + 3] for state, i in suite.get_first_indices(owner).items()}
    x |= {"to_body": lambda v: v, "auxiliary_vectors": np.zeros((3, 3))}
    return owner.predict_measurement(SimpleNamespace(**x), vector)


@pytest.mark.parametrize("name", ["every constant", "full gyro", "cubesat_6u_full"])
def test_corrections_invert_measurement_model(name):
    """The errors are as large as a tenth. Varying and considered states are not corrected."""
    suite, rng = SUITES[name], np.random.default_rng(3)
    states = rng.uniform(-0.1, 0.1, suite.n_states)
    varying = slice(suite.n_kinematic, suite.n_dynamic)
    states[varying], vectors = 0.0, rng.standard_normal((5, 3))
    sent = compute_corrections(suite, states)
    for owner in (suite.gyro, *suite.sensors):
        entry = sent[getattr(owner, "name", "gyro")]
        factor = {"deg/s": np.degrees(1.0), "nT": 5e4, "-": 1.0}[entry["unit"]]
        report = factor * predict_readings(suite, owner, states, vectors)
        turned = Rotation.from_quat(
            entry.get("quaternion", [0.0, 0.0, 0.0, 1.0])
        )  # Body to sensor.
        np.testing.assert_allclose(turned.as_matrix().T, entry.get("dcm", np.eye(3)), atol=1e-14)
        correction = np.array(entry.get("correction", np.transpose(entry.get("dcm", np.eye(3)))))
        found = (report - entry["bias"]) @ correction.T / factor
        np.testing.assert_allclose(found, vectors, rtol=0, atol=1e-14)


def test_corrections_satisfy_the_schema_of_the_document():
    sensors = [
        {"kind": "photodiode", "normal": [1.0, 0.0, 0.0]},
        {"kind": "magnetometer", "initial_latency_s": 0.5, "initial_scale_factor": 0.01},
    ]
    suite = Scenario.from_dict({"preset": "cubesat_1u", "sensors": sensors}).suite
    corrections = compute_corrections(suite, np.zeros(suite.n_states))
    definitions = collect_documents()["calibration.json"].build_schema()["$defs"]
    correction = definitions["Correction"]
    for entry in corrections.values():
        jsonschema.validate(entry, {**correction, "$defs": definitions})
    described = correction["properties"]
    assert {"latency_s", "correction"} <= corrections["mag"].keys() <= described.keys()
