#!/usr/bin/python3
"""Writes atoms and bonds of chains of touching grains that stand above a bed: make_chains.py CHAINS GRAINS > file."""
import sys

chains, grains = int(sys.argv[1]), int(sys.argv[2])
diameter, width, side = 0.01, 0.1, 0.013
per_row = int((width - 0.02) / side)
print(f"chains of grains\n\n{chains * grains} atoms\n{chains * (grains - 1)} bonds\n1 atom types\n1 bond types")
print("2 extra bond per atom\n")
print(f"0 {width} xlo xhi\n0 {width} ylo yhi\n0 0.5 zlo zhi\n\nAtoms\n")
for c in range(chains):
    row, column = divmod(c, per_row)
    for k in range(grains):
        # a zigzag, so that no chain stands like a column
        x, y = 0.015 + side * column + 0.003 * (k % 2), 0.015 + side * row
        z = 0.12 + k * (diameter ** 2 - 0.003 ** 2) ** 0.5
        print(c * grains + k + 1, 1, x, y, z, diameter, 2500, c + 1)
print("\nBonds\n")
for c in range(chains):
    for k in range(1, grains):
        print(c * (grains - 1) + k, 1, c * grains + k, c * grains + k + 1)
