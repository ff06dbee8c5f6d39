#!/usr/bin/python3
"""A pendulum that falls from the horizontal: its way, its pull, its energy.

    pendulum.py [PICTURE.png]
"""

import sys

import matplotlib
import tanor

matplotlib.use("Agg")
import matplotlib.pyplot as plt

system = tanor.System([[0, 0, 0], [1, 0, 0]], [1, 1], supports=[tanor.Support([0], name="nail")],
                      constraints=[tanor.Rods([[0, 1]], name="rod")], forces=[tanor.Gravity((0, 0, -9.81))])
simulation = tanor.Simulation(system)
simulation.add_observable("energy()", name="energy")
run = tanor.run(simulation, 4.0, every=0.02)

figure, (way, pull, energy) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
way.plot(run.positions[:, 1, 0], run.positions[:, 1, 2])
way.set(xlabel="x, m", ylabel="z, m", aspect="equal", title=run.report.method)
pull.plot(run.times, run["rod"].tension[:, 0])
pull.set(xlabel="t, s", ylabel="pull of the rod, N")
energy.plot(run.times, run["energy"] - run["energy"][0])
energy.set(xlabel="t, s", ylabel="drift of the energy, J")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "pendulum.png", dpi=100)
print(simulation.certify().line)
