"""Interactive figures of plans."""
