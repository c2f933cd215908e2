"""The calibration filter: a declared error model, a reference filter and a generated kernel."""
