"""Evaluation of candidates, some of which may fail.

`evaluator` counts and survives failures, `failures` finds the failing candidates of a batch,
`dominance` selects nondominated vectors, `individuals` reads pymoo's individuals and designs.
"""
