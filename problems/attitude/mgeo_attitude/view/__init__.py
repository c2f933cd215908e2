"""What is told of designs: tables, answers, remarks and figures."""
