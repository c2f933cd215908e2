"""Interactive figures of a set of solutions."""
