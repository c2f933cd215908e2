"""Plans made better without a global search: good starts, local polish, no unneeded maneuvers."""
