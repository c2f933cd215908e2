"""Sets of nondominated points.

`dominance` compares points, `archive` keeps the nondominated ones, `truncation` removes the most
crowded.
"""
