"""Evaluations that may fail, and evaluations made again.

`evaluator` counts and survives failures, `failures` finds the candidates that fail, `reevaluation`
compares a problem with what a run has of it; the rest reads pymoo's individuals and designs.
"""
