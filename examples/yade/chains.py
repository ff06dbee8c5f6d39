"""Chains of grains fall on a plate in YADE; tanor keeps the rods between their grains.

    TANOR_LIBRARY=build/libtanor.so yade -n -x examples/yade/chains.py [STEPS]

After NewtonIntegrator, which leaps from r(t) to r(t + dt) with v(t + dt/2), the rods put both onto the constraints, along
their directions at r(t): SHAKE. Without TANOR_LIBRARY the loader looks for the installed libtanor.so.
"""
import ctypes
import os
import sys

import numpy as np
from yade import O, utils
from yade.wrapper import *


class Points(ctypes.Structure):  # tn_points
    _fields_ = [("data", ctypes.c_void_p), ("stride", ctypes.c_ssize_t), ("index", ctypes.c_void_p)]

    def __init__(self, array):
        super().__init__(array.ctypes.data, 0, None)


class Rods:
    """Bodies i, j of `pairs` keep the distance that they have now; those that are not dynamic hold them."""

    def __init__(self, pairs):
        self.bodies = sorted({int(body) for pair in pairs for body in pair})
        point = {body: k for k, body in enumerate(self.bodies)}
        self.pairs = np.array([[point[i], point[j]] for i, j in pairs], dtype=np.int32)
        masses = np.array([O.bodies[i].state.mass if O.bodies[i].dynamic else np.inf for i in self.bodies])
        self.old = self.read("pos")
        self.lengths = np.linalg.norm(self.old[self.pairs[:, 1]] - self.old[self.pairs[:, 0]], axis=1)
        self.lib = ctypes.CDLL(os.environ.get("TANOR_LIBRARY", "libtanor.so"))
        self.lib.tn_last_error.restype = self.lib.tn_create_error.restype = ctypes.c_char_p
        self.handle = ctypes.c_void_p()
        made = self.lib.tn_create(ctypes.byref(self.handle), ctypes.c_size_t(len(masses)),
                                  masses.ctypes.data_as(ctypes.c_void_p), Points(self.old), None)
        if made != 0:
            raise ValueError(self.lib.tn_create_error().decode())
        self.check(self.lib.tn_add_rods(self.handle, ctypes.c_size_t(len(self.pairs)),
                                        self.pairs.ctypes.data_as(ctypes.c_void_p),
                                        self.lengths.ctypes.data_as(ctypes.c_void_p), None, None))

    def check(self, result):
        if result != 0:
            raise RuntimeError(self.lib.tn_last_error(self.handle).decode())

    def read(self, name):
        return np.array([getattr(O.bodies[i].state, name) for i in self.bodies])

    def constrain(self):
        positions, velocities = self.read("pos"), self.read("vel")
        self.check(self.lib.tn_constrain_positions(self.handle, ctypes.c_double(O.dt), Points(self.old),
                                                   Points(positions), Points(velocities), None, None))
        for i, r, v in zip(self.bodies, positions, velocities):
            if O.bodies[i].dynamic:
                O.bodies[i].state.pos, O.bodies[i].state.vel = r, v
        self.old = positions

    def violation(self):
        d = self.old[self.pairs[:, 1]] - self.old[self.pairs[:, 0]]
        return abs(np.linalg.norm(d, axis=1) / self.lengths - 1).max()


def make_chains(count, grains, radius):
    """Chains side by side, askew over the plate; the rods leave a gap between the grains."""
    pairs = []
    for chain in range(count):
        for k in range(grains):
            place = (2.4 * radius * k, 4 * radius * chain, 3 * radius + 0.9 * radius * k)
            body = O.bodies.append(utils.sphere(place, radius))
            if k > 0:
                pairs.append((body - 1, body))
    return pairs


O.materials.append(FrictMat(density=2600, young=1e7, poisson=0.3, frictionAngle=0.4))
O.bodies.append(utils.wall(0, axis=2))
rods = Rods(make_chains(count=5, grains=10, radius=0.01))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
                    [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(gravity=(0, 0, -9.81), damping=0.2),
    PyRunner(command="rods.constrain()", iterPeriod=1),  # behind NewtonIntegrator
]
O.dt = 0.2 * utils.PWaveTimeStep()

worst = 0.0
for _ in range(int(sys.argv[1]) // 100 if len(sys.argv) > 1 else 100):
    O.run(100, True)
    worst = max(worst, rods.violation())
print(f"{len(rods.lengths)} rods, {O.iter} steps of {O.dt:.1e} s: largest violation {worst:.1e}, "
      f"highest grain at {rods.old[:, 2].max():.4f} m, energy of motion {utils.kineticEnergy():.2e} J")
