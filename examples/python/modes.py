#!/usr/bin/python3
"""A chain between two supports: where it rests, and how it swings there.

    modes.py [PICTURE.png]
"""

import sys

import matplotlib
import numpy
import tanor

matplotlib.use("Agg")
import matplotlib.pyplot as plt

n, width, length = 41, 3.0, 0.1
start = numpy.zeros((n, 3))
start[:, 0] = numpy.linspace(0, width, n)  # straight, with rods too short: the search mends that
chain = tanor.System(start, numpy.full(n, 0.1), supports=[tanor.Support([0, n - 1], name="nails")],
                     constraints=[tanor.Rods([[i, i + 1] for i in range(n - 1)], length=length, name="links")],
                     forces=[tanor.Gravity((0, 0, -9.81))])
rest = tanor.find_equilibrium(chain)
if not rest.ok:
    sys.exit(rest.outcome.what)
modes = tanor.modes(chain, rest.positions, count=6, multipliers=rest.multipliers)
if not modes.ok:
    sys.exit(modes.outcome.what)

figure = plt.figure(figsize=(11, 7), layout="constrained")
for k in range(6):
    in_plane = abs(modes.shapes[k, :, 1]).max() < abs(modes.shapes[k, :, 2]).max()
    tanor.plot.modes(modes, k, axes=figure.add_subplot(2, 3, k + 1, projection=None if in_plane else "3d"))
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "modes.png", dpi=100)
print(f"{rest.status} after {rest.iterations} iterations; omega = {modes.omega}")
