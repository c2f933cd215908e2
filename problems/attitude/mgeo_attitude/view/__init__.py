"""Views of plans for display: `ManeuverView` with its tables, summaries, remarks and figures."""
