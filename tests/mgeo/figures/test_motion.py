"""The form of the motion of a figure."""

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.figures.motion import validate_motion

TURN = {"times": [0.0, 10.0], "x": [0.0], "y": [0.0], "z": [90.0]}
MOTION = {"end": 10.0, "rotations": {"wheel": TURN}}


def moving(motion, meta=None, kind=go.Scatter3d):
    return go.Figure(kind(x=[1.0], y=[0.0], meta=meta), {"meta": {"motion": motion}})


def test_still_figures_and_valid_motions_pass():
    validate_motion(go.Figure(go.Scatter(y=[1], meta=["any", "thing"]), {"meta": {"own": 1}}))
    validate_motion(moving(MOTION, {"rotation": "wheel", "faint": "never"}))
    arrays = {key: np.array(values) for key, values in TURN.items()}
    validate_motion(
        moving({"end": 1, "rotations": {"wheel": arrays}}, {"rotation": "wheel"}, go.Mesh3d)
    )


@pytest.mark.parametrize(
    ("key", "value"), [("times", [0.0, 10.0, 5.0]), ("x", [0.0, 1.0]), ("y", [np.nan])]
)
def test_a_turn_of_another_form_is_refused(key, value):
    motion = {"end": 10.0, "rotations": {"wheel": TURN | {key: value}}}
    with pytest.raises(ValueError, match=r"rotations\['wheel'\]"):
        validate_motion(moving(motion))


@pytest.mark.parametrize(
    ("turn", "kind", "message"),
    [
        ("reel", go.Scatter3d, "rotation of a trace = 'reel'"),
        ("wheel", go.Scatter, "type of a rotating trace = 'scatter': expected scatter3d or mesh3d"),
    ],
)
def test_traces_must_be_able_to_turn(turn, kind, message):
    with pytest.raises(ValueError, match=message):
        validate_motion(moving(MOTION, {"rotation": turn}, kind))
