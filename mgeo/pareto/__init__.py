"""Sets of nondominated points.

`dominance` compares points, `archive` keeps the nondominated ones, `truncation` gives up those that
stand closest.
"""
