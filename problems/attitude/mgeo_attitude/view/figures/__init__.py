"""Interactive plotly figures of maneuver plans."""
