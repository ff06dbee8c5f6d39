#!/usr/bin/python3
"""A chain in a time loop of one's own: velocity Verlet with a Constrainer.

    hanging_chain.py [PICTURE.png]
"""

import sys

import matplotlib
import numpy
import tanor

matplotlib.use("Agg")
import matplotlib.pyplot as plt

n, h, g, m = 21, 1e-3, 9.81, 0.05
masses = numpy.full(n, m)
masses[0] = numpy.inf  # a support
r, v, f = numpy.zeros((n, 3)), numpy.zeros((n, 3)), numpy.zeros((n, 3))
r[:, 0] = 0.05 * numpy.arange(n)
f[1:, 2] = -g * m
constrainer = tanor.Constrainer(masses, [tanor.Rods([[i, i + 1] for i in range(n - 1)], name="links")], r)

shapes, energies = [r.copy()], []
for step in range(1, 1501):
    old = r.copy()
    v[1:] += 0.5 * h * f[1:] / m
    r += h * v
    report = constrainer.constrain_positions(h, old, r, v)
    if not report.ok:
        sys.exit(report.outcome.what)
    v[1:] += 0.5 * h * f[1:] / m  # the forces are those of before
    report = constrainer.constrain_velocities(h, r, v)
    if not report.ok:
        sys.exit(report.outcome.what)
    energies.append(0.5 * m * (v**2).sum() + g * m * r[1:, 2].sum())
    if step % 100 == 0:
        shapes.append(r.copy())
tensions = numpy.empty(constrainer.num_rows)
report = constrainer.solve(r, v, f, multipliers=tensions)
tensions *= -1

figure, (chain, energy, tension) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
for k, shape in enumerate(shapes):
    chain.plot(shape[:, 0], shape[:, 2], color=plt.cm.viridis(k / len(shapes)))
chain.set(xlabel="x, m", ylabel="z, m", aspect="equal", title="every 0.1 s")
energy.plot(h * numpy.arange(1, len(energies) + 1), energies)
energy.set(xlabel="t, s", ylabel="energy, J")
tension.step(range(len(tensions)), tensions)
tension.set(xlabel="link", ylabel="tension at the end, N")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "hanging_chain.png", dpi=100)
print(f"energy {energies[-1]:.1e} J, first link pulls with {tensions[0]:.3f} N")
