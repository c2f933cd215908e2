"""What is told of designs: `ManeuverView`, and its tables, answers, remarks and figures."""
