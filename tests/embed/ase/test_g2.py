"""All molecules of ASE's collection g2 that have bonds move as ASE's own constraint moves them."""

import unittest
import unittest.mock

import numpy
from ase.collections import g2
from ase.constraints import FixBondLengths
from springs import bond_lengths, run, warm

from tanor.ase import RigidBonds, find_bonds


class Molecules(unittest.TestCase):
    # Two thirds of FixBondLengths' time are ASE's search for images, and molecules have none.
    @unittest.mock.patch("ase.constraints.find_mic", lambda vector, cell, pbc: (vector, None))
    def test_positions_after_25_steps_are_those_of_fix_bond_lengths(self):
        molecules = [(name, g2[name], find_bonds(g2[name])) for name in g2.names]
        bonded = [molecule for molecule in molecules if len(molecule[2]) > 0]
        self.assertEqual(len(bonded), 145)
        for name, atoms, pairs in bonded:
            with self.subTest(name):
                exact = run(warm(atoms, RigidBonds(pairs)))
                theirs = run(warm(atoms, FixBondLengths(pairs)))
                self.assertLess(abs(exact.positions - atoms.positions).max(), 1.0)
                self.assertGreater(abs(exact.positions - atoms.positions).max(), 0.02)
                numpy.testing.assert_allclose(exact.positions, theirs.positions, rtol=0, atol=1e-12)
                numpy.testing.assert_allclose(bond_lengths(exact, pairs), bond_lengths(atoms, pairs), rtol=1e-13)


if __name__ == "__main__":
    unittest.main()
