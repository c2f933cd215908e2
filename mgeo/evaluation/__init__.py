"""Evaluations that may fail, and what is nondominated among them.

`evaluator` counts and survives failures, `failures` finds the candidates that fail, `dominance`
says which vectors no other dominates, `individuals` reads pymoo's individuals and designs.
"""
