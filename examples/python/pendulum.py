#!/usr/bin/python3
"""A pendulum that falls from the horizontal: its way, its pull, its energy.

    pendulum.py [PICTURE.png]
"""

import sys

import matplotlib
import numpy
import tanor

matplotlib.use("Agg")
import matplotlib.pyplot as plt

system = tanor.System([[0, 0, 0], [1, 0, 0]], [1, 1], supports=[tanor.Support([0], name="nail")],
                      constraints=[tanor.Rods([[0, 1]], name="rod")], forces=[tanor.Gravity((0, 0, -9.81))])
simulation = tanor.Simulation(system)
times, places, pulls, energies = [], [], [], []
for t in numpy.linspace(0.02, 4.0, 200):
    outcome = simulation.advance_to(t)
    if not outcome.ok:
        sys.exit(outcome.what)
    times.append(simulation.time)
    places.append(simulation.positions[1].copy())
    pulls.append(simulation.solution().tension(group=0, number=0))
    energies.append(simulation.report.energy.drift_relative)
places = numpy.array(places)

figure, (way, pull, energy) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
way.plot(places[:, 0], places[:, 2])
way.set(xlabel="x, m", ylabel="z, m", aspect="equal", title=simulation.report.method)
pull.plot(times, pulls)
pull.set(xlabel="t, s", ylabel="pull of the rod, N")
energy.plot(times, energies)
energy.set(xlabel="t, s", ylabel="drift of the energy, relative")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "pendulum.png", dpi=100)
print(simulation.certify().line)
