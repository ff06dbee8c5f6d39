"""Rigid bonds for ASE, the Atomic Simulation Environment: exact, for any graph of bonds, at the cost of compiled code.

`RigidBonds` stands wherever ASE's own FixBondLengths may, in molecular dynamics and in optimisers. `find_bonds` names the
bonds of Atoms by their radii, `use_rigid_bonds` puts a RigidBonds in the place of each FixBondLengths.
"""

import copy
from typing import Any

import numpy
from ase import Atoms
from ase.cell import Cell
from ase.constraints import FixAtoms, FixBondLengths, FixConstraint
from ase.geometry import find_mic
from ase.neighborlist import natural_cutoffs, neighbor_list
from numpy.typing import ArrayLike

from . import Constrainer, ConstraintReport, InputError, Rods, SolverOptions

__all__ = ["RigidBonds", "find_bonds", "use_rigid_bonds"]


def find_bonds(atoms: Atoms, mult: float = 1.1) -> numpy.ndarray:
    """int [k, 2], sorted: pairs of atoms that are no further apart than `mult` times the sum of their covalent radii.

    In a periodic cell distances are those of the nearest images.
    """
    i, j = neighbor_list("ij", atoms, natural_cutoffs(atoms, mult=mult))
    pairs = numpy.stack([i, j], axis=1)[i < j]
    return numpy.unique(pairs, axis=0)


def use_rigid_bonds(atoms: Atoms) -> Atoms:
    """Puts a RigidBonds of the same bonds in the place of each FixBondLengths of `atoms`, which it returns.

    ASE writes and reads the bonds of a file as a FixBondLengths.
    """
    atoms.set_constraint([RigidBonds(c.pairs, c.bondlengths) if isinstance(c, FixBondLengths) else c
                          for c in atoms.constraints])
    return atoms


class RigidBonds(FixConstraint):
    """Bonds of constant length: SHAKE and RATTLE for any graph of bonds, solved to rounding.

    pairs    int [k, 2]: atoms that a bond joins; in a periodic cell the nearest images. Bonds that others imply (all ten
             distances of a methane) need no care
    lengths  float [k], Angstrom, or None: as they are at the first use, or in `measure`
    options  SolverOptions of the Constrainer

    Atoms that a FixAtoms of the same Atoms holds do not move, and bonds at them are kept exactly, whichever constraint
    stands first. ASE applies any other constraint on atoms with bonds before or after this one, so that only the last
    of them holds.

    The first step begins at positions where the bonds have their lengths to 0.1 % (barostats of ASE have scaled them by
    then): with lengths that are given, call `project_positions` once, before the first forces.

    Wrong input is a ValueError, at the latest at the first use; a step that does not converge (a bond that turns by
    more than about 0.4 rad) is a RuntimeError, as in FixBondLengths. Either leaves positions, momenta and forces alone.

    Attributes, besides the arguments:

    constraint_forces  float [n, 3], eV/Angstrom: what the bonds did to the forces of the last `adjust_forces`
    """

    def __init__(self, pairs: ArrayLike, lengths: ArrayLike | None = None,
                 options: SolverOptions | None = None) -> None:
        self.pairs = _frozen(pairs)
        if self.pairs.ndim != 2 or self.pairs.shape[1] != 2 or len(self.pairs) == 0:
            raise ValueError(f"RigidBonds: pairs have the shape {list(self.pairs.shape)}, wanted [k, 2], k > 0")
        if self.pairs.dtype.kind not in "iu":
            raise ValueError(f"RigidBonds: pairs are of type {self.pairs.dtype}, wanted whole numbers")
        _refuse(self.pairs[:, 0] == self.pairs[:, 1], self.pairs, "joins an atom with itself")
        self.lengths = None if lengths is None else _frozen(lengths, float)
        if self.lengths is not None:
            if self.lengths.shape != self.pairs.shape[:1]:
                raise ValueError(f"RigidBonds: lengths have the shape {list(self.lengths.shape)}, "
                                 f"wanted [{len(self.pairs)}]")
            self._check_lengths()
        self.options = options
        self._images: numpy.ndarray | None = None  # int [k, 3]: in which image of the cell the second atom is
        self._solver: _Solver | None = None

    def measure(self, atoms: Atoms) -> "RigidBonds":
        """Takes lengths that were not given from `atoms`, and checks the pairs; returns itself.

        The first use does that by itself. Before it, files and copies do not know the lengths, and `repeat` not which
        bonds join images.
        """
        _refuse(((self.pairs < 0) | (self.pairs >= len(atoms))).any(axis=1), self.pairs,
                f"names an atom beyond the {len(atoms)} that there are")
        _check_finite(position=atoms.positions)
        vectors = atoms.positions[self.pairs[:, 1]] - atoms.positions[self.pairs[:, 0]]
        nearest, distances = find_mic(vectors, atoms.cell, atoms.pbc)
        if self.lengths is None:
            self.lengths = _frozen(distances)
            self._check_lengths()
        self._images = _frozen(numpy.rint(atoms.cell.scaled_positions(nearest - vectors)).astype(int))
        return self

    def project_positions(self, atoms: Atoms) -> None:
        """Moves `atoms` to the nearest positions, weighted with the masses, where the bonds have their lengths."""
        _require(self._solver_of(atoms).constrainer.project_positions(atoms.positions), position=atoms.positions)

    # ---- what ASE calls ----

    def adjust_positions(self, atoms: Atoms, new: numpy.ndarray) -> None:
        """SHAKE: `new`, float [n, 3], comes back on the bonds, along their directions where the atoms are now."""
        solver, old = self._solver_of(atoms), atoms.positions
        solver.begin(old)
        if len(solver.held) > 0:
            new[solver.held] = old[solver.held]
        report = solver.constrainer.constrain_positions(1.0, old, new, measures=False)
        _require(report, position=old, new_position=new)

    def adjust_momenta(self, atoms: Atoms, momenta: numpy.ndarray) -> None:
        """RATTLE: `momenta`, float [n, 3], lose what would change the length of a bond."""
        self._project(atoms, momentum=momenta)

    def adjust_forces(self, atoms: Atoms, forces: numpy.ndarray) -> None:
        """`forces`, float [n, 3], lose what would accelerate the length of a bond; see `constraint_forces`."""
        free = forces.copy()
        self._project(atoms, force=forces)
        self.constraint_forces = numpy.subtract(forces, free, out=free)

    def adjust_cell(self, atoms: Atoms, cell: Cell) -> None:
        """Refuses a new cell in which a bond would be longer than half of it; lengths and cell stay as they are."""
        self._solver_of(atoms, cell)

    def get_removed_dof(self, atoms: Atoms) -> int:
        """The rank of the bonds, which is less than their number where some imply others."""
        solver = self._solver_of(atoms)
        if solver.rank is None:  # it stays along a motion
            solver.rank = solver.constrainer.rank(atoms.positions).rank
        return solver.rank

    def get_indices(self) -> numpy.ndarray:
        """The atoms that have bonds, sorted."""
        return numpy.unique(self.pairs)

    def index_shuffle(self, atoms: Atoms, ind: Any) -> None:
        """Keeps the bonds whose two atoms are in `ind` (a list, an array or a slice), under their new numbers."""
        chosen = numpy.arange(len(atoms))[ind]
        number = numpy.full(len(atoms), -1)
        number[chosen] = numpy.arange(len(chosen))
        pairs = number[self.pairs]
        kept = (pairs >= 0).all(axis=1)
        if not kept.any():
            raise IndexError("RigidBonds: no bond is part of the slice")
        self._take(pairs[kept], *(None if a is None else a[kept] for a in (self.lengths, self._images)))

    def repeat(self, m: int | tuple[int, int, int], n: int) -> "RigidBonds":
        """The bonds of `m` cells of `n` atoms; those that joined images join atoms of neighbouring cells then."""
        if self._images is None:
            raise ValueError("RigidBonds: nobody has looked yet which bonds join images; call measure(atoms) before "
                             "atoms are repeated")
        counts = numpy.array((m, m, m) if isinstance(m, int) else m)
        cells = numpy.indices(counts).reshape(3, -1).T[:, None, :]  # in the order of Atoms.repeat
        images, others = numpy.divmod(cells + self._images, counts)
        first = numpy.ravel_multi_index(numpy.moveaxis(cells, -1, 0), counts) * n + self.pairs[:, 0]
        second = numpy.ravel_multi_index(numpy.moveaxis(others, -1, 0), counts) * n + self.pairs[:, 1]
        self._take(numpy.stack([first.ravel(), second.ravel()], axis=1), numpy.tile(self.lengths, len(cells)),
                   images.reshape(-1, 3))
        return self

    def todict(self) -> dict[str, Any]:
        """The same bonds as a FixBondLengths: ASE reads constraints of its own alone. See `use_rigid_bonds`."""
        lengths = None if self.lengths is None else self.lengths.tolist()
        return {"name": "FixBondLengths", "kwargs": {"pairs": self.pairs.tolist(), "bondlengths": lengths}}

    def copy(self) -> "RigidBonds":
        """Calculators copy atoms in every step, so copies share the arrays, which never change."""
        return copy.copy(self)

    def __deepcopy__(self, memo: dict) -> "RigidBonds":
        return copy.copy(self)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_solver": None}  # made anew where the copy is first used

    def __repr__(self) -> str:
        return f"RigidBonds(pairs={self.pairs.tolist()})"

    # ---- inside ----

    def _check_lengths(self) -> None:
        _refuse(~((self.lengths > 0) & numpy.isfinite(self.lengths)), self.pairs, "has no positive length")

    def _take(self, pairs: numpy.ndarray, lengths: numpy.ndarray | None, images: numpy.ndarray | None) -> None:
        self.pairs, self._solver = _frozen(pairs), None
        self.lengths, self._images = (None if a is None else _frozen(a) for a in (lengths, images))

    def _solver_of(self, atoms: Atoms, cell: Cell | None = None) -> "_Solver":
        """The solver for these atoms in their cell, or in another one."""
        cell = atoms.cell if cell is None else cell
        kind = _kind_of(atoms)
        solver = self._solver
        try:
            if solver is None or solver.kind != kind:
                self.measure(atoms)
                solver = _Solver(self, atoms, cell, kind)
            solver.set_cell(cell)
        except InputError as error:
            raise ValueError(f"RigidBonds: {error}") from None
        self._solver = solver
        return solver

    def _project(self, atoms: Atoms, **named: numpy.ndarray) -> None:
        """Momenta p and forces f alike: K'M^-1 p = 0 is left; atoms that are held are left to FixAtoms."""
        (vectors,) = named.values()
        solver = self._solver_of(atoms)
        packed = numpy.ascontiguousarray(vectors, dtype=float)  # as a rule the same array
        _require(solver.constrainer.project_forces(atoms.positions, packed), position=atoms.positions, **named)
        if packed is not vectors:
            numpy.copyto(vectors, packed, casting="same_kind")


class _Solver:
    """A Constrainer, and for what it was made."""

    MOST_VIOLATION = 1e-3  # of a length, where the first step begins

    def __init__(self, bonds: RigidBonds, atoms: Atoms, cell: Cell, kind: tuple) -> None:
        masses, pbc = atoms.get_masses(), atoms.pbc
        for constraint in _held_in(atoms):
            masses[constraint.index] = numpy.inf
        self.kind, self.pbc, self.cell = kind, pbc.copy(), cell.array.tobytes()
        self.held = numpy.flatnonzero(numpy.isinf(masses))
        self.rank: int | None = None
        self.has_begun = False
        edges = cell.complete().array if pbc.any() else None
        self.constrainer = Constrainer(masses, [Rods(bonds.pairs, length=bonds.lengths, name="bonds")],
                                       atoms.positions, cell=edges, repeats=_repeats(cell, pbc), options=bonds.options)

    def begin(self, positions: numpy.ndarray) -> None:
        """Refuses positions off the bonds where the first step begins: it would put the correction into velocities."""
        if self.has_begun:
            return
        found = self.constrainer.violation(positions)
        _require(found, position=positions)
        if found.violation > self.MOST_VIOLATION:
            name = self.constrainer.row_name(found.worst_row)
            raise RuntimeError(f"RigidBonds: {name} is off by {found.violation:.3g} of its length where the step begins; "
                               "call project_positions(atoms) before the first forces")
        # The Constrainer looks itself where its first step begins, and takes nothing less than exact.
        exact = positions.copy()
        _require(self.constrainer.project_positions(exact))
        _require(self.constrainer.constrain_positions(1.0, exact, exact.copy(), measures=False))
        self.has_begun = True

    def set_cell(self, cell: Cell) -> None:
        bits = cell.array.tobytes()
        if bits != self.cell and self.pbc.any():
            self.constrainer.set_cell(cell.complete().array, _repeats(cell, self.pbc))
        self.cell = bits


def _held_in(atoms: Atoms) -> list[FixAtoms]:
    return [constraint for constraint in atoms.constraints if isinstance(constraint, FixAtoms)]


def _kind_of(atoms: Atoms) -> tuple:
    """All that a solver is made for beside bonds and cell: masses, or the elements that have them, periods, what is held.

    Bytes compare in a fraction of the time that numpy takes, and masses are not looked up in each call.
    """
    own = atoms.arrays.get("masses")
    source = atoms.arrays["numbers"] if own is None else own
    return (own is None, source.tobytes(), atoms.pbc.tobytes(), [held.index.tobytes() for held in _held_in(atoms)])


def _repeats(cell: Cell, pbc: numpy.ndarray) -> numpy.ndarray:
    """bool [3]: an edge that is not there repeats nothing."""
    return pbc & cell.array.any(axis=1)


def _frozen(numbers: ArrayLike, dtype: type | None = None) -> numpy.ndarray:
    """An array of its own that copies may share."""
    array = numpy.array(numbers, dtype)
    array.flags.writeable = False
    return array


def _refuse(wrong: numpy.ndarray, pairs: numpy.ndarray, what: str) -> None:
    if wrong.any():
        k = numpy.flatnonzero(wrong)[0]
        raise ValueError(f"RigidBonds: bond {k}, {pairs[k].tolist()}, {what}")


def _check_finite(**named: numpy.ndarray) -> None:
    for name, vectors in named.items():
        wrong = numpy.flatnonzero(~numpy.isfinite(vectors).all(axis=1))
        if len(wrong) > 0:
            raise ValueError(f"RigidBonds: the {name.replace('_', ' ')} of atom {wrong[0]} is not finite")


def _require(report: ConstraintReport, **named: numpy.ndarray) -> None:
    if not report.ok:
        _check_finite(**named)
        raise RuntimeError(f"RigidBonds: {report.outcome.what}")
