"""Test problems by name, of pymoo and of COCO, beside those that plugins bring.

`collections` knows the prefixes of their names; `shifted` moves optima off the bounds; `coco` makes
pymoo problems of COCO's functions.
"""
