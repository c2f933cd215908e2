"""Format of animated figures."""

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.figures.motion import validate_motion

ROTATION = {"times": [0.0, 10.0], "x": [0.0], "y": [0.0], "z": [90.0]}
MOTION = {"end": 10.0, "rotations": {"wheel": ROTATION}}


def build_animated_figure(motion, meta=None, kind=go.Scatter3d):
    return go.Figure(kind(x=[1.0], y=[0.0], meta=meta), {"meta": {"motion": motion}})


def test_static_figures_and_valid_animations_are_accepted():
    validate_motion(go.Figure(go.Scatter(y=[1], meta=["any", "thing"]), {"meta": {"own": 1}}))
    validate_motion(build_animated_figure(MOTION, {"rotation": "wheel", "faint": "never"}))
    arrays = {key: np.array(values) for key, values in ROTATION.items()}
    validate_motion(
        build_animated_figure(
            {"end": 1, "rotations": {"wheel": arrays}}, {"rotation": "wheel"}, go.Mesh3d
        )
    )


@pytest.mark.parametrize(
    ("key", "value"), [("times", [0.0, 10.0, 5.0]), ("x", [0.0, 1.0]), ("y", [np.nan])]
)
def test_invalid_rotation_is_rejected(key, value):
    motion = {"end": 10.0, "rotations": {"wheel": ROTATION | {key: value}}}
    with pytest.raises(ValueError, match=r"rotations\['wheel'\]"):
        validate_motion(build_animated_figure(motion))


@pytest.mark.parametrize(
    ("rotation", "kind", "message"),
    [
        ("reel", go.Scatter3d, "rotation of a trace = 'reel'"),
        ("wheel", go.Scatter, "type of a rotating trace = 'scatter': expected scatter3d or mesh3d"),
    ],
)
def test_invalid_rotating_trace_is_rejected(rotation, kind, message):
    with pytest.raises(ValueError, match=message):
        validate_motion(build_animated_figure(MOTION, {"rotation": rotation}, kind))
