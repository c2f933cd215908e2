"""Names of the sections about a plan.

`mgeo_attitude.plan.tables` defines the sections. The names are here, so that help and completion of
the command line need no other imports.
"""

#: Section of text that comes first.
SUMMARY = "summary"

#: Sections of the first page.
FIRST_PAGE = (SUMMARY, "constraints", "timeline", "accuracy", "drivers")

#: Names of all sections, in the order in which terminal and pages show them.
SECTION_KEYS = (
    *FIRST_PAGE,
    "axes",
    "budget",
    "improvements",
    "phases",
    "directions",
    "measurements",
    "comparison",
    "bound",
    "objectives",
    "attitudes",
    "satellite",
    "instruments",
)
