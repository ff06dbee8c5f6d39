"""RigidBonds in ASE's hands: dynamics, optimisers, cells, copies, files, mistakes."""

import copy
import itertools
import os
import pathlib
import pickle
import re
import tempfile
import unittest

import numpy
from ase import Atoms, units
from ase.build import molecule
from ase.constraints import FixAtoms, FixBondLengths
from ase.io import read, write
from ase.md.nptberendsen import NPTBerendsen
from ase.optimize import BFGS
from springs import Springs, bond_lengths, run, warm

from tanor.ase import RigidBonds, find_bonds, use_rigid_bonds


def water_box(pbc=True) -> Atoms:
    """Two waters in a skewed cell, wrapped: bonds of the first cross a face."""
    first, second = molecule("H2O"), molecule("H2O")
    first.rotate(50, "x")
    first.translate([0.1, -0.2, 3.0])
    second.translate([3.0, 3.0, 3.0])
    atoms = first + second
    atoms.set_cell([[6, 0, 0], [1, 7, 0], [0.5, -1, 8]])
    atoms.pbc = pbc
    atoms.wrap()
    return atoms


WATERS = [[0, 1], [0, 2], [1, 2], [3, 4], [3, 5], [4, 5]]
METHANE = list(itertools.combinations(range(5), 2))


def removed_dof(atoms: Atoms) -> int:
    return sum(constraint.get_removed_dof(atoms) for constraint in atoms.constraints)


class Forces(unittest.TestCase):
    def test_forces_and_what_the_bonds_did_to_them_are_those_of_fix_bond_lengths(self):
        for name in "CH4", "C6H6", "H2O":
            atoms = molecule(name)
            pairs = find_bonds(atoms)
            found = []
            for constraint in RigidBonds(pairs), FixBondLengths(pairs):
                one = warm(atoms, constraint)
                one.positions += 0.0  # forces are those of springs whose ends have moved
                one.calc.home = one.positions + 0.1 * numpy.sin(numpy.arange(3.0 * len(one))).reshape(-1, 3)
                found.append((one.get_forces(), constraint.constraint_forces))
            numpy.testing.assert_allclose(found[0][0], found[1][0], rtol=0, atol=1e-12)
            numpy.testing.assert_allclose(found[0][1], found[1][1], rtol=0, atol=1e-12)

    def test_no_force_is_too_small_to_be_projected(self):
        atoms = molecule("C6H6")
        bonds = RigidBonds(find_bonds(atoms))
        forces = numpy.sin(numpy.arange(36.0)).reshape(12, 3)
        small = 1e-30 * forces
        bonds.adjust_forces(atoms, forces)
        bonds.adjust_forces(atoms, small)
        numpy.testing.assert_allclose(1e30 * small, forces, rtol=0, atol=1e-14)

    def test_arrays_of_any_layout_are_written_in_place(self):
        atoms = molecule("CH4")
        bonds = RigidBonds(find_bonds(atoms))
        forces = numpy.sin(numpy.arange(15.0)).reshape(5, 3)
        single, fortran = forces.astype("float32"), numpy.asfortranarray(forces)
        bonds.adjust_momenta(atoms, forces)
        bonds.adjust_momenta(atoms, single)
        bonds.adjust_momenta(atoms, fortran)
        numpy.testing.assert_array_equal(fortran, forces)
        numpy.testing.assert_allclose(single, forces, rtol=1e-5, atol=1e-6)
        with self.assertRaises(TypeError):
            bonds.adjust_momenta(atoms, numpy.ones((5, 3), int))

    def test_an_optimiser_finds_the_place_without_tension(self):
        atoms = warm(molecule("CH3CH2OH"), RigidBonds(find_bonds(molecule("CH3CH2OH"))))
        pairs, before = find_bonds(atoms), bond_lengths(atoms, find_bonds(atoms))
        atoms.calc.home += 0.3 * numpy.sin(numpy.arange(27.0)).reshape(9, 3)
        with BFGS(atoms, logfile=None) as optimiser:
            self.assertTrue(optimiser.run(fmax=1e-6, steps=300))
        numpy.testing.assert_allclose(bond_lengths(atoms, pairs), before, rtol=1e-13)
        self.assertGreater(abs(atoms.constraints[0].constraint_forces).max(), 1e-3)


class Motion(unittest.TestCase):
    def test_methane_with_ten_distances_loses_nine_degrees_of_freedom(self):
        atoms = warm(molecule("CH4"), RigidBonds(METHANE))
        self.assertEqual(atoms.constraints[0].get_removed_dof(atoms), 9)
        self.assertAlmostEqual(atoms.get_temperature(), 2 * atoms.get_kinetic_energy() / (6 * units.kB), places=9)
        before, energy = bond_lengths(atoms, METHANE), atoms.get_total_energy()
        run(atoms, 500)
        numpy.testing.assert_allclose(bond_lengths(atoms, METHANE), before, rtol=1e-13)
        self.assertLess(abs(atoms.get_total_energy() - energy), 1e-4)

    def test_changed_masses_are_seen(self):
        atoms = warm(molecule("H2O"), RigidBonds(WATERS[:3]))
        run(atoms, 1)
        atoms.set_masses([16.0, 2.0, 3.0])
        other = atoms.copy()
        other.calc = Springs(atoms.calc.home)
        numpy.testing.assert_array_equal(run(atoms).positions, run(other).positions)

    def test_given_lengths_are_reached_by_a_projection(self):
        atoms = molecule("H2O")
        bonds = RigidBonds(WATERS[:2], [1.0, 1.1])
        atoms.set_constraint(bonds)
        before = atoms.positions.copy()
        with self.assertRaisesRegex(RuntimeError, r"RigidBonds: bonds\[1\] is off by 0.1.*project_positions"):
            atoms.set_positions(before + 0.01)
        numpy.testing.assert_array_equal(atoms.positions, before)
        bonds.project_positions(atoms)
        numpy.testing.assert_allclose(bond_lengths(atoms, WATERS[:2]), [1.0, 1.1], rtol=1e-14)
        atoms.set_positions(atoms.positions + 0.01)

    def test_a_step_that_fails_leaves_the_atoms_alone(self):
        atoms = warm(molecule("H2O"), RigidBonds(WATERS[:2]))
        before = atoms.positions.copy()
        with self.assertRaisesRegex(RuntimeError, r"RigidBonds: .*bonds\[0\]"):
            atoms.set_positions(before + [[0, 0, 0], [50, 60, 0], [0, 0, 0]])
        numpy.testing.assert_array_equal(atoms.positions, before)
        run(atoms, 1)

    def test_atoms_that_fix_atoms_holds_stay_whichever_constraint_is_first(self):
        atoms = molecule("CH3CH2OH")
        pairs, held = find_bonds(atoms), [0, 2]
        found = []
        for order in (RigidBonds(pairs), FixAtoms(held)), (FixAtoms(held), RigidBonds(pairs)):
            moved = warm(atoms, list(order))
            moved.calc.home += 0.5  # held atoms are pulled at, too
            run(moved, 50)
            numpy.testing.assert_array_equal(moved.positions[held], atoms.positions[held])
            numpy.testing.assert_array_equal(moved.get_momenta()[held], 0.0)
            numpy.testing.assert_array_equal(moved.get_forces()[held], 0.0)
            numpy.testing.assert_allclose(bond_lengths(moved, pairs), bond_lengths(atoms, pairs), rtol=1e-13)
            self.assertEqual(removed_dof(moved), 3 * 2 + 8)
            found.append(moved.positions)
        numpy.testing.assert_array_equal(*found)
        both = run(warm(atoms, [RigidBonds([[0, 1], [1, 2], [0, 2]]), FixAtoms([0, 1])]))  # a bond between two held
        self.assertEqual(removed_dof(both), 3 * 2 + 2)


class Cells(unittest.TestCase):
    def test_bonds_across_faces_move_as_those_of_fix_bond_lengths(self):
        for pbc in True, [True, True, False]:
            atoms = water_box(pbc)
            self.assertGreater(numpy.ptp(atoms.positions[:3, 1]), 5)
            exact, theirs = (run(warm(atoms, make(WATERS))) for make in (RigidBonds, FixBondLengths))
            numpy.testing.assert_allclose(exact.positions, theirs.positions, rtol=0, atol=1e-12)
            numpy.testing.assert_allclose(bond_lengths(exact, WATERS), bond_lengths(atoms, WATERS), rtol=1e-13)

    def test_atoms_may_be_wrapped_at_any_time(self):
        atoms, wrapped = (warm(water_box(), RigidBonds(WATERS)) for _ in range(2))
        for _ in range(4):
            run(atoms, 5)
            wrapped.calc.home -= wrapped.positions
            wrapped.wrap(eps=0.3)
            wrapped.calc.home += wrapped.positions
            run(wrapped, 5)
        atoms.wrap()
        wrapped.wrap()
        numpy.testing.assert_allclose(wrapped.positions, atoms.positions, rtol=0, atol=1e-12)

    def test_a_net_may_close_round_the_cell(self):
        atoms = Atoms("C4", [[0, 0, 0], [1.4, 0.3, 0], [2.8, 0, 0.2], [4.2, 0.3, 0]], cell=[5.6, 8, 0], pbc=[1, 1, 0])
        ring = [[0, 1], [1, 2], [2, 3], [3, 0]]
        moved = run(warm(atoms, RigidBonds(ring)))
        numpy.testing.assert_allclose(bond_lengths(moved, ring), bond_lengths(atoms, ring), rtol=1e-13)

    def test_a_barostat_keeps_the_lengths(self):
        atoms = warm(water_box(), RigidBonds(WATERS))
        lengths, volume = bond_lengths(atoms, WATERS), atoms.get_volume()
        NPTBerendsen(atoms, 0.5 * units.fs, temperature_K=300, taup=100 * units.fs, taut=100 * units.fs,
                     pressure_au=5e-3, compressibility_au=1.0).run(50)
        self.assertGreater(abs(atoms.get_volume() / volume - 1), 1e-3)
        numpy.testing.assert_allclose(bond_lengths(atoms, WATERS), lengths, rtol=1e-13)

    def test_a_cell_that_is_too_small_is_refused_and_not_taken(self):
        atoms = water_box()
        atoms.set_constraint(RigidBonds(WATERS))
        cell, positions = atoms.cell.copy(), atoms.positions.copy()
        with self.assertRaisesRegex(ValueError, r"RigidBonds: .*bonds\[2\].*half of the cell"):
            atoms.set_cell([3, 3, 3], scale_atoms=True)
        numpy.testing.assert_array_equal(atoms.cell, cell)
        numpy.testing.assert_array_equal(atoms.positions, positions)
        atoms.set_cell([7, 7, 7])

    def test_a_repeated_cell_has_the_bonds_of_its_images(self):
        atoms = water_box()
        atoms.set_constraint(RigidBonds(WATERS).measure(atoms))
        for m in (2, 1, 3), 2, (1, 1, 1):
            many = atoms.repeat(m)
            (bonds,) = many.constraints
            copies = len(many) // len(atoms)
            self.assertEqual(len(bonds.pairs), 6 * copies)
            numpy.testing.assert_allclose(bond_lengths(many, bonds.pairs), numpy.tile(bond_lengths(atoms, WATERS), copies))
            again = many.repeat((1, 2, 1)).constraints[0]
            many.repeat((1, 2, 1)).set_positions(many.repeat((1, 2, 1)).positions + 0.01)
            self.assertEqual(len(again.pairs), 12 * copies)
            self.assertEqual(bonds.get_removed_dof(many), 6 * copies)
        atoms.set_constraint(RigidBonds(WATERS))
        with self.assertRaisesRegex(ValueError, r"RigidBonds: .*measure\(atoms\)"):
            atoms.repeat(2)


class Copies(unittest.TestCase):
    def test_copies_go_on_as_what_they_were_taken_of(self):
        atoms = run(warm(molecule("C6H6"), RigidBonds(find_bonds(molecule("C6H6")))))
        copies = [atoms.copy(), copy.deepcopy(atoms), pickle.loads(pickle.dumps(atoms)), Atoms(atoms)]
        home = atoms.calc.home
        for each in copies:
            self.assertIsNot(each.constraints[0], atoms.constraints[0])
            each.calc = Springs(home)
        run(atoms)
        for each in copies:
            numpy.testing.assert_array_equal(run(each).positions, copies[0].positions)
            numpy.testing.assert_allclose(each.positions, atoms.positions, rtol=0, atol=1e-12)

    def test_a_slice_keeps_the_bonds_inside(self):
        atoms = water_box()
        atoms.set_constraint(RigidBonds(WATERS).measure(atoms))
        cases = [(slice(3, 6), [[0, 1], [0, 2], [1, 2]]), ([5, 4, 3, 0], [[2, 1], [2, 0], [1, 0]]),
                 (atoms.numbers == 1, [[0, 1], [2, 3]]), (slice(None, None, -1), 5 - numpy.array(WATERS)),
                 (numpy.array([-1, -3]), [[1, 0]])]
        for chosen, pairs in cases:
            part = atoms[chosen]
            numpy.testing.assert_array_equal(part.constraints[0].pairs, pairs)
            numpy.testing.assert_allclose(part.constraints[0].lengths, bond_lengths(part, pairs))
            part.set_positions(part.positions + 0.01)
        self.assertEqual(atoms[[0, 3]].constraints, [])
        self.assertEqual(len(atoms.constraints[0].pairs), 6)
        numpy.testing.assert_array_equal(atoms[:3].constraints[0].get_indices(), [0, 1, 2])

    def test_a_slice_of_what_nobody_measured_is_measured_later(self):
        atoms = water_box()
        atoms.set_constraint(RigidBonds(WATERS))
        run(warm(atoms[3:], atoms[3:].constraints))

    def test_files_hold_the_bonds_as_ase_reads_them(self):
        atoms = run(warm(molecule("CH4"), RigidBonds(METHANE)), 3)
        with tempfile.TemporaryDirectory() as folder:
            for name in "a.traj", "a.json", "a.db":
                file = os.path.join(folder, name)
                write(file, atoms)
                plain = read(file)
                self.assertIsInstance(plain.constraints[0], FixBondLengths)
                (bonds,) = use_rigid_bonds(plain).constraints
                self.assertIsInstance(bonds, RigidBonds)
                numpy.testing.assert_array_equal(bonds.pairs, METHANE)
                self.assertEqual(bonds.lengths is None, name == "a.json")  # where ASE forgets them
                numpy.testing.assert_allclose(bonds.measure(plain).lengths, atoms.constraints[0].lengths, rtol=1e-14)
                plain.calc = Springs(atoms.calc.home)
                run(plain, 2)

    def test_other_constraints_are_left_as_they_are(self):
        atoms = molecule("H2O")
        held = FixAtoms([0])
        atoms.set_constraint([held, FixBondLengths([[0, 1]])])
        self.assertIs(use_rigid_bonds(atoms).constraints[0], held)
        self.assertIsNone(atoms.constraints[1].lengths)


class Mistakes(unittest.TestCase):
    def refused(self, text, call):
        with self.assertRaisesRegex(ValueError, text):
            call()

    def test_wrong_bonds_are_refused_by_number(self):
        self.refused(r"pairs have the shape \[0\]", lambda: RigidBonds([]))
        self.refused(r"pairs have the shape \[2, 3\]", lambda: RigidBonds([[0, 1, 2], [1, 2, 3]]))
        self.refused("of type float64", lambda: RigidBonds([[0, 1.5]]))
        self.refused(r"bond 1, \[2, 2\], joins an atom with itself", lambda: RigidBonds([[0, 1], [2, 2]]))
        self.refused(r"lengths have the shape \[1\], wanted \[2\]", lambda: RigidBonds([[0, 1], [1, 2]], [1.0]))
        for wrong in 0.0, -1.0, numpy.nan, numpy.inf:
            self.refused(r"bond 1, \[1, 2\], has no positive length",
                         lambda: RigidBonds([[0, 1], [1, 2]], [1.0, wrong]))
        atoms = molecule("H2O")
        for pair in [0, 3], [-1, 0]:
            atoms.set_constraint(RigidBonds([[0, 1], pair]))
            self.refused(re.escape(f"RigidBonds: bond 1, {pair}, names an atom beyond the 3"),
                         lambda: atoms.set_positions(atoms.positions))
        atoms.positions[2] = atoms.positions[1]
        self.refused(r"bond 0, \[1, 2\], has no positive length", lambda: RigidBonds([[1, 2]]).measure(atoms))

    def test_numbers_that_are_none_are_refused_by_atom(self):
        atoms = molecule("H2O")
        bonds = RigidBonds([[0, 1], [0, 2]]).measure(atoms)
        atoms.set_constraint(bonds)
        wrong = atoms.get_positions()
        wrong[2, 1] = numpy.nan
        self.refused("RigidBonds: the new position of atom 2 is not finite", lambda: atoms.set_positions(wrong))
        self.refused("RigidBonds: the momentum of atom 2 is not finite", lambda: atoms.set_momenta(wrong))
        self.refused("RigidBonds: the force of atom 2 is not finite", lambda: bonds.adjust_forces(atoms, wrong.copy()))
        atoms.positions[1] = numpy.inf
        for call in (lambda: bonds.project_positions(atoms), lambda: atoms.set_positions(wrong),
                     lambda: atoms.set_momenta(wrong), lambda: bonds.measure(atoms)):
            self.refused("RigidBonds: the position of atom 1 is not finite", call)
        self.refused("RigidBonds: .*masses/1.*not positive", lambda: (atoms.set_masses([1, 0, 1]),
                                                                      atoms.positions.fill(0.0),
                                                                      RigidBonds([[0, 1]], [1.0]).adjust_positions(
                                                                          atoms, atoms.get_positions())))

    def test_a_bond_longer_than_half_of_the_cell_is_refused(self):
        atoms = molecule("H2O")
        atoms.set_cell([1.5, 9, 9])
        atoms.pbc = True
        atoms.set_constraint(RigidBonds([[0, 1], [0, 2]], [0.9, 0.9]))
        self.refused(r"RigidBonds: .*bonds\[[01]\] has the length 0.9, no less than half",
                     lambda: atoms.set_positions(atoms.positions))


class Page(unittest.TestCase):
    def test_the_example_of_the_page_runs(self):
        page = pathlib.Path(os.environ["TANOR_DOCS"], "embedding.md").read_text(encoding="utf-8")
        (program,) = re.findall(r"```python\n([^`]*tanor\.ase.*?)```", page, re.DOTALL)
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            exec(compile(program, "docs/embedding.md, ASE", "exec"), {})


if __name__ == "__main__":
    unittest.main()
