#!/usr/bin/python3
"""Runs a scene file and draws where its points went.

    scene.py [PICTURE.png [SCENE.json]]
"""

import pathlib
import sys

import matplotlib
import numpy
import tanor

matplotlib.use("Agg")
import matplotlib.pyplot as plt

picture = sys.argv[1] if len(sys.argv) > 1 else "scene.png"
default = pathlib.Path(__file__).resolve().parent.parent / "chain.json"
scene = tanor.Scene(sys.argv[2] if len(sys.argv) > 2 else default)
trajectory = tanor.run_scene(scene)
if not trajectory.outcome.ok:
    sys.exit(trajectory.outcome.what)

# Seen along the axis in which least happens.
spread = numpy.ptp(trajectory.positions, axis=(0, 1))
across, up = sorted(numpy.argsort(spread)[-2:])
figure, axes = plt.subplots(figsize=(5, 5), layout="constrained")
for point in range(0, scene.num_points, max(1, scene.num_points // 20)):
    axes.plot(trajectory.positions[:, point, across], trajectory.positions[:, point, up], lw=0.8)
last = trajectory.positions[-1]
axes.plot(last[:, across], last[:, up], "k.", ms=3)
axes.set(xlabel="xyz"[across] + ", m", ylabel="xyz"[up] + ", m", aspect="equal", title=f"{scene.name}, {trajectory.times[-1]:g} s")
figure.savefig(picture, dpi=100)
print(f"{scene.name}: {trajectory.report.steps} steps of {trajectory.report.method}")
