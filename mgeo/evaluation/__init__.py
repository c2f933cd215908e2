"""Evaluation of candidate solutions, with tolerance for candidates that fail.

`evaluator` has the evaluator of runs, `failures` isolates the failing candidates of a batch,
`dominance` compares objective vectors, `individuals` converts between pymoo individuals and arrays.
"""
