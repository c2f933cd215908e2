"""Test problems by name: problems of pymoo and functions of COCO.

`collections` builds a problem from a name with a prefix, `shifted` moves the optima of a problem
away from its bounds, `coco` wraps COCO functions as pymoo problems.
"""
