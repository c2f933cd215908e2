"""What a plan's turns are: designs as rates over time, ramps between them, and phases for people.

Nothing here knows of a filter; `filter` runs along a `Schedule`.
"""
