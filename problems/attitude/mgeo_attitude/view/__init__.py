"""What is told of designs: `ManeuverView`, and its tables, answers, remarks and figures."""

from mgeo_attitude.view.maneuver_view import ManeuverView

__all__ = ["ManeuverView"]
