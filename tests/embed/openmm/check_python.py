#!/usr/bin/python3
"""check_python.py LIBRARY: the call of libtanor_openmm for Python, as docs/embedding.md has it, on a methane with all ten
distances."""
import copy
import itertools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import host_runs  # noqa: E402

sys.path.pop(0)  # beside it lies a folder openmm, which is not the module

try:
    import numpy as np
    import openmm
except ImportError as missing:
    print(missing)
    sys.exit(77)

(example,) = host_runs.blocks_of_page("OpenMM", "python")
assert '"libtanor_openmm.so"' in example and '"CPU"' in example
example = example.replace('"libtanor_openmm.so"', repr(sys.argv[1])).replace('"CPU"', '"Reference"')

corners = np.array([(0, 0, 0), (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) * 0.109 / 3**0.5
pairs = np.array(list(itertools.combinations(range(5), 2)))


def lengths(positions):
    return np.linalg.norm(positions[pairs[:, 1]] - positions[pairs[:, 0]], axis=1)


system = openmm.System()
for mass in (12.011, 1.008, 1.008, 1.008, 1.008):
    system.addParticle(mass)
for (i, j), length in zip(pairs.tolist(), lengths(corners)):
    system.addConstraint(i, j, length)
given = {"openmm": openmm, "system": system, "integrator": openmm.VerletIntegrator(0.001)}
exec(compile(example, "docs/embedding.md", "exec"), given)
assert given["context"].getSystem().getNumForces() == 1

for one in (system, copy.deepcopy(system)):
    assert one.getNumForces() == 1
    integrator = openmm.VerletIntegrator(0.001)
    context = openmm.Context(one, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(corners)
    context.setVelocitiesToTemperature(300, 7)
    integrator.step(1000)
    end = context.getState(getPositions=True).getPositions(asNumpy=True)._value
    violation = abs(lengths(end) / lengths(corners) - 1).max()
    assert violation < 1e-13, violation

context.reinitialize()
context.setPositions(1.01 * corners)
try:
    integrator.step(1)
except openmm.OpenMMException as error:
    assert "particles" in str(error), error
else:
    sys.exit("positions off the constraints were accepted")
