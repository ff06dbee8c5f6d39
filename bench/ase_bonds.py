#!/usr/bin/python3
"""Times tanor.ase.RigidBonds against ASE's FixBondLengths, in turn: PYTHONPATH=build/python bench/ase_bonds.py [TURNS]

Carbon chains at 300 K in free flight: the two calls of a step of velocity Verlet, adjust_positions and adjust_momenta,
from the same positions and momenta, one thread; each turn is ten steps of ours and one of theirs. Prints a table, medians of the
turns; bench/results/hosts-ase.md keeps one.
"""

import statistics
import sys
import time

import numpy
from ase import Atoms, units
from ase.build import molecule
from ase.constraints import FixBondLengths

from tanor import SolverOptions
from tanor.ase import RigidBonds, find_bonds

TIMESTEP = 0.5 * units.fs
LENGTH = 1.53  # Angstrom
ONE_THREAD = SolverOptions(threads=1)


def chain(num_bonds: int, angle: float | None) -> Atoms:
    """A random coil whose bonds turn by `angle`, degrees, from one to the next; None: by any."""
    random = numpy.random.default_rng(2)
    bonds = random.standard_normal((num_bonds, 3))
    bonds /= numpy.linalg.norm(bonds, axis=1)[:, None]
    if angle is not None:
        for k in range(1, num_bonds):
            across = numpy.cross(bonds[k - 1], bonds[k])
            across /= numpy.linalg.norm(across)
            bonds[k] = numpy.cos(numpy.radians(angle)) * bonds[k - 1] + numpy.sin(numpy.radians(angle)) * across
    return Atoms(f"C{num_bonds + 1}", numpy.vstack([numpy.zeros(3), numpy.cumsum(LENGTH * bonds, axis=0)]))


def warm(atoms: Atoms, pairs) -> Atoms:
    """With momenta of 300 K that obey the bonds."""
    momenta = numpy.sqrt(300 * units.kB * atoms.get_masses())[:, None]
    momenta = momenta * numpy.random.default_rng(1).standard_normal((len(atoms), 3))
    RigidBonds(pairs).adjust_momenta(atoms, momenta)
    atoms.set_momenta(momenta)
    return atoms


def flight(constraint, start: Atoms, steps: int) -> float:
    """Seconds of the processor a step of the two calls, the first step left out, which plans."""
    atoms, masses, times = start.copy(), start.get_masses()[:, None], []
    for _ in range(steps + 1):
        new = atoms.positions + TIMESTEP * atoms.arrays["momenta"] / masses
        begin = time.thread_time()
        constraint.adjust_positions(atoms, new)
        middle = time.thread_time()
        momenta = (new - atoms.positions) * masses / TIMESTEP
        atoms.arrays["positions"] = new
        again = time.thread_time()
        constraint.adjust_momenta(atoms, momenta)
        times.append(middle - begin + time.thread_time() - again)
        atoms.arrays["momenta"] = momenta
    return statistics.median(times[1:])


def compare(name: str, atoms: Atoms, tolerance: float, turns: int) -> str:
    pairs = find_bonds(atoms) if name.startswith("C60") else [[i, i + 1] for i in range(len(atoms) - 1)]
    warm(atoms, pairs)
    theirs = FixBondLengths(pairs, tolerance=tolerance)
    theirs.bondlengths = theirs.initialize_bond_lengths(atoms)
    try:
        times = [(flight(RigidBonds(pairs, options=ONE_THREAD), atoms, 10), flight(theirs, atoms, 1)) for _ in range(turns)]
    except RuntimeError as error:
        return f"| {name} | {tolerance:.0e} | | {error} | |"
    ours, their = (statistics.median(column) for column in zip(*times))
    return f"| {name} | {tolerance:.0e} | {1e3 * ours:.3f} | {1e3 * their:.0f} | {statistics.median(b / a for a, b in times):.0f} |"


def main(turns: int) -> None:
    print("| bonds | tolerance of FixBondLengths | RigidBonds, ms | FixBondLengths, ms | times faster |")
    print("|---|---|---|---|---|")
    print(compare("C60, 90 bonds", molecule("C60"), 1e-13, turns), flush=True)
    for num_bonds, angle, tolerance in ((10, None, 1e-13), (100, None, 1e-13), (1000, None, 1e-13), (1000, None, 1e-8),
                                        (1000, 68, 1e-13), (1000, 68, 1e-8), (1000, 5, 1e-8)):
        name = f"{num_bonds}, freely jointed" if angle is None else f"{num_bonds}, each turned by {angle} degrees"
        print(compare(name, chain(num_bonds, angle), tolerance, turns), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
