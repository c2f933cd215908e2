"""Names and contents of the sections about a plan.

`mgeo_attitude.plan.tables` defines the sections. The names are here, so that help and completion of
the command line need no other imports.
"""

from collections.abc import Mapping

#: Section of text that comes first.
SUMMARY = "summary"

#: Contents of each section in a few words, in the order in which terminal and pages show them.
SECTION_CONTENTS: Mapping[str, str] = {
    SUMMARY: "end of the plan, attitude accuracy, warnings",
    "constraints": "value, bound and margin of each constraint",
    "timeline": "start, duration and rates of each maneuver",
    "accuracy": "predicted 1-sigma and its lower bound",
    "drivers": "largest error sources of the attitude",
    "axes": "1-sigma about body x, y and z",
    "budget": "share of every error source in the variances",
    "improvements": "1-sigma with less noise, or with a longer plan",
    "reduction": "1-sigma at the end of each maneuver",
    "directions": "combinations of errors that the plan observes least",
    "measurements": "time during which each sensor measures",
    "comparison": "1-sigma after simple maneuvers of equal duration",
    "bound": "trace of the covariance and its lower bound",
    "objectives": "objectives as predicted and in Monte Carlo runs",
    "attitudes": "quaternion at the end of each maneuver",
    "satellite": "orbit, Sun, eclipses, magnetic field, maneuvers",
    "instruments": "noise and initial errors of gyro and sensors",
}

#: Names of all sections.
SECTION_KEYS = tuple(SECTION_CONTENTS)

#: Sections of the first page.
FIRST_PAGE = SECTION_KEYS[:5]
