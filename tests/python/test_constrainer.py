"""A host's arrays, time loop and mistakes."""

import copy
import pickle
import threading
import time
import unittest

import numpy
import tanor


class Host:
    """Velocity Verlet of a chain that falls from the horizontal; positions and velocities are columns of one array."""

    def __init__(self, n: int = 11) -> None:
        self.masses = numpy.full(n, 0.1)
        self.masses[0] = numpy.inf
        state = numpy.zeros((n, 7))
        self.r, self.v = state[:, 0:3], state[:, 3:6]
        self.r[:, 0] = 0.1 * numpy.arange(n)
        self.f = numpy.zeros((n, 3))
        self.f[1:, 2] = -9.81 * 0.1
        self.constrainer = self.make()

    def make(self, **more) -> tanor.Constrainer:
        n = len(self.masses)
        return tanor.Constrainer(self.masses, [tanor.Rods([[i, i + 1] for i in range(n - 1)], name="rods")], self.r,
                                 **more)

    def step(self, h: float) -> None:
        old = self.r.copy()
        self.v[1:] += 0.5 * h * self.f[1:] / 0.1
        self.r += h * self.v
        assert self.constrainer.constrain_positions(h, old, self.r, self.v).ok
        self.v[1:] += 0.5 * h * self.f[1:] / 0.1
        assert self.constrainer.constrain_velocities(h, self.r, self.v).ok

    def energy(self) -> float:
        return 0.05 * (self.v**2).sum() + 9.81 * 0.1 * self.r[1:, 2].sum()


class StepsOnTheHostsArrays(unittest.TestCase):
    def test_energy_stays_and_lengths_are_kept_to_rounding(self):
        host = Host()
        for _ in range(1000):
            host.step(1e-3)
        self.assertLess(abs(host.energy()), 1e-3)
        lengths = numpy.linalg.norm(numpy.diff(host.r, axis=0), axis=1)
        self.assertLess(abs(lengths - 0.1).max(), 1e-15)
        tensions = numpy.empty(host.constrainer.num_rows)
        report = host.constrainer.solve(host.r, host.v, host.f, multipliers=tensions)
        self.assertTrue(report.ok)
        self.assertAlmostEqual(-tensions[0], 1.5535, places=4)  # docs/embedding.md

    def test_a_tolerance_ends_the_iterations(self):
        old = numpy.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
        left = []
        for tolerance in (0.0, 1e-4):
            constrainer = tanor.Constrainer([numpy.inf, 1.0], [tanor.Rods([[0, 1]])], old)
            new = old + [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]
            report = constrainer.constrain_positions(1.0, old, new, tolerance=tolerance)
            left.append((report.iterations, abs(numpy.linalg.norm(new[1]) - 1.0)))
        self.assertLess(left[1][0], left[0][0])
        self.assertLess(left[0][1], 1e-13)
        self.assertTrue(1e-13 < left[1][1] < 1e-4)

    def test_pendulum_at_rest_pulls_with_its_weight(self):
        r = numpy.array([[0.0, 0, 0], [0, 0, -2]])
        constrainer = tanor.Constrainer([numpy.inf, 3.0], [tanor.Rods([[0, 1]])], r)
        f, w = numpy.array([[0.0, 0, 0], [0, 0, -30]]), numpy.ones((2, 3))
        multipliers, forces, stress = numpy.empty(1), numpy.empty((2, 3)), numpy.empty((2, 9))
        report = constrainer.solve(r, numpy.zeros((2, 3)), f, accelerations=w, multipliers=multipliers,
                                   constraint_forces=forces, stress=stress)
        self.assertAlmostEqual(-multipliers[0], 30.0, places=13)
        numpy.testing.assert_allclose(w, 0, atol=1e-14)
        numpy.testing.assert_allclose(forces, [[0, 0, -30], [0, 0, 30]], atol=1e-13)
        self.assertAlmostEqual(report.virial[2], -60.0, places=12)
        self.assertAlmostEqual(stress[:, 8].sum(), -60.0, places=12)

    def test_copies_go_on_as_the_handle_they_were_taken_from(self):
        host, other, third = Host(), Host(), Host()
        for k in range(60):
            for each in (host, other, third):
                each.step(1e-3)
            if k == 30:
                other.constrainer = copy.deepcopy(host.constrainer)
                third.constrainer = pickle.loads(pickle.dumps(host.constrainer))
        numpy.testing.assert_array_equal(host.r, other.r)
        numpy.testing.assert_array_equal(host.r, third.r)
        numpy.testing.assert_array_equal(host.v, other.v)

    def test_a_pickle_keeps_the_lengths_of_the_start(self):
        host = Host()
        host.r[:, 0] *= 2  # the host's array moves on; the description does not
        again = pickle.loads(pickle.dumps(host.constrainer))
        self.assertAlmostEqual(again.violation(host.r).violation, 1.0, places=12)

    def test_observables_are_those_of_solve_also_in_copies(self):
        host = Host()
        constrainer = host.constrainer
        self.assertEqual(constrainer.add_observable("max tension(rods)", name="most"), 0)
        constrainer.add_observable("load(support0).z", unit="kN")
        host.r[:] = 0.1 * numpy.arange(11)[:, None] * (0, 0, -1)
        multipliers = numpy.zeros(10)
        self.assertTrue(constrainer.observe(host.r, host.v, host.f, multipliers=multipliers, time=2.5).ok)
        most, load = constrainer.observed
        self.assertEqual(most.values[0], -multipliers.min())
        self.assertAlmostEqual(most.values[0], 9.81, 12)
        self.assertEqual((most.name, most.largest[0].time, most.largest[0].member), ("most", 2.5, "rods[0]"))
        self.assertAlmostEqual(load.values[0], -9.81, 12)
        self.assertEqual((load.columns, load.unit, most.unit), (["load(support0).z"], "kN", ""))
        constrainer.add_observable("load(support0)", name="load")
        constrainer.observe(host.r, host.v, host.f)
        self.assertEqual((constrainer["most"], constrainer["load(support0).z"]), (most.values[0], load.values[0]))
        self.assertEqual((constrainer["load"].shape, constrainer["load.z"]), ((3,), load.values[0]))
        constrainer.remove_observable(2)
        with self.assertRaisesRegex(tanor.InputError, "column 13: no constraints or forces are named 'rod'.*mean rods"):
            constrainer.add_observable("max tension(rod)")
        constrainer.remove_observable(0)
        copied = copy.deepcopy(constrainer)
        copied.observe(host.r, host.v, host.f)
        self.assertEqual([(each.values[0], each.unit) for each in copied.observed], [(load.values[0], "kN")])

    def test_one_mass_is_that_of_all(self):
        rods = [tanor.Rods([[0, 1]])]
        positions, velocities, forces = numpy.array([[0.0, 0, 0], [1, 0, 0]]), numpy.zeros((2, 3)), numpy.array([[1.0, 0, 0], [0, 0, 0]])
        one, each = numpy.empty((2, 3)), numpy.empty((2, 3))
        tanor.Constrainer(2.0, rods, positions).solve(positions, velocities, forces, accelerations=one)
        tanor.Constrainer([2.0, 2.0], rods, positions).solve(positions, velocities, forces, accelerations=each)
        numpy.testing.assert_array_equal(one, each)
        numpy.testing.assert_allclose(one[:, 0], 0.25, rtol=1e-14)

    def test_an_index_reads_and_writes_rows_in_another_order(self):
        host = Host()
        order = numpy.random.default_rng(1).permutation(20)[:11].astype("int32")
        wide = numpy.full((20, 3), 7.0)
        wide[order] = host.r + 0.01 * numpy.sin(numpy.arange(33.0)).reshape(11, 3)
        packed = wide[order].copy()
        report = host.constrainer.project_positions(packed)
        self.assertTrue(report.ok)
        self.assertGreater(report.largest_turn, 1e-4)
        self.assertTrue(host.constrainer.project_positions(wide, index=order).ok)
        numpy.testing.assert_array_equal(wide[order], packed)
        self.assertEqual((wide == 7.0).all(axis=1).sum(), 9)

    def test_a_periodic_cell_joins_nearest_images(self):
        r = numpy.array([[2.6, 1, 1], [0.4, 1.2, 1], [1.2, 1.4, 1]])
        edges = [[3, 0, 0], [0.5, 4, 0], [0, 0, 5]]
        constrainer = tanor.Constrainer(numpy.ones(3), [tanor.Rods([[0, 1], [1, 2]])], r, cell=edges)
        moved = r + [[0.05, 0, 0], [0, 0.1, 0], [0, 0, 0]]
        self.assertTrue(constrainer.constrain_positions(0.01, r, moved).ok)
        self.assertLess(numpy.linalg.norm(moved[1] + [3, 0, 0] - moved[0]) - numpy.linalg.norm([0.8, 0.2, 0]), 1e-12)
        constrainer.set_cell(1.01 * numpy.array(edges))
        again = copy.deepcopy(constrainer)
        self.assertEqual(again.violation(moved).violation, constrainer.violation(moved).violation)

    def test_rank_and_determinant(self):
        square = numpy.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
        pairs = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]]
        self.assertEqual(tanor.Constrainer(numpy.ones(4), [tanor.Rods(pairs)], square).rank(square).rank, 5)
        dumbbell = tanor.Constrainer([2.0, 4.0], [tanor.Rods([[0, 1]])], square[:2])
        self.assertAlmostEqual(dumbbell.log_det(square[:2]).value, numpy.log(1 / 2 + 1 / 4), places=14)

    def test_the_gradient_of_the_determinant_knows_all_kinds(self):
        r, e = numpy.array([[0.0, 0, 0], [1, 0.3, 0]]), 1e-5
        held = tanor.Constrainer([2.0, 4.0], [tanor.Rods([[0, 1]]), tanor.Spheres([0], center=[0.4, 0.2, -1])], r)
        gradient = numpy.empty((2, 3))
        self.assertTrue(held.log_det(r, gradient).ok)
        for place in numpy.ndindex(2, 3):
            step = numpy.zeros((2, 3))
            step[place] = e
            slope = (held.log_det(r + step).value - held.log_det(r - step).value) / (2 * e)
            self.assertAlmostEqual(gradient[place], slope, places=9)


class Chains:
    """Three chains of five points side by side, without forces, whose constraints come and go."""

    def __init__(self, **more) -> None:
        self.r = numpy.zeros((15, 3))
        self.r[:, 0] = numpy.tile(numpy.arange(5.0), 3)
        self.r[:, 1] = numpy.repeat(numpy.arange(3.0), 5)
        self.masses = 1 + 0.1 * numpy.arange(15)
        self.masses[0] = numpy.inf
        self.v = 0.3 * numpy.sin(7.0 * numpy.arange(45)).reshape(15, 3)
        self.v[0] = 0
        pairs = [[i, i + 1] for i in range(14) if i % 5 != 4]
        self.c = tanor.Constrainer(self.masses, [tanor.Rods(pairs, name="links")], self.r, **more)
        self.time = 0.0
        assert self.c.constrain_velocities(1e-3, self.r, self.v).ok

    def step(self, constrainer: tanor.Constrainer, h: float = 1e-3) -> tuple[numpy.ndarray, numpy.ndarray]:
        r, v = self.r + h * self.v, self.v.copy()
        for report in (constrainer.constrain_positions(h, self.r, r, v, time=self.time + h),
                       constrainer.constrain_velocities(h, r, v, time=self.time + h)):
            assert report.ok, report.outcome.what
        return r, v

    def go(self, steps: int = 3, h: float = 1e-3) -> None:
        for _ in range(steps):
            self.r, self.v = self.step(self.c, h)
            self.time += h

    def lengths(self, pairs) -> numpy.ndarray:
        i, j = numpy.transpose(pairs)
        return numpy.linalg.norm(self.r[j] - self.r[i], axis=1)


class Edits(unittest.TestCase):
    def assert_copies_go_on(self, chains: Chains) -> None:
        """Copies of copies, too; and their ids are the same."""
        copies = [copy.deepcopy(chains.c), pickle.loads(pickle.dumps(chains.c))]
        copies.append(copy.deepcopy(copies[0]))
        r, v = chains.step(chains.c)
        for other in copies:
            self.assertEqual([other.row_name(k) for k in range(other.num_rows)],
                             [chains.c.row_name(k) for k in range(chains.c.num_rows)])
            other_r, other_v = chains.step(other)
            numpy.testing.assert_array_equal(r, other_r)
            numpy.testing.assert_array_equal(v, other_v)

    def test_constraints_come_and_go_by_ids(self):
        chains = Chains()
        self.assertEqual(chains.c.add(tanor.Rods([[4, 9]], name="bridge"), chains.r), 12)
        self.assertEqual(chains.c.add(tanor.Planes([5, 14], normal=(0, 0, 1))), 13)
        self.assertEqual((chains.c.num_rows, chains.c.rows(14)), (15, slice(14, 15, 1)))
        chains.c.remove([2, 13])
        self.assertEqual((chains.c.num_rows, chains.c.rows(14)), (13, slice(12, 13, 1)))
        self.assertEqual([chains.c.row_name(k) for k in (2, 11)], ["links[3]", "bridge[0]"])
        self.assertGreater(chains.c.update_plan(), 0)
        self.assertEqual(chains.c.update_plan(), 0)
        self.assertAlmostEqual(chains.lengths([[4, 9]])[0], 1, places=14)

    def test_copies_after_each_kind_of_edit_go_on_with_the_same_bits_and_ids(self):
        chains = Chains()
        chains.go()
        chains.c.remove([1, 6])
        self.assert_copies_go_on(chains)
        chains.go()
        bridge = chains.c.add(tanor.Rods([[4, 9], [9, 14]]), chains.r)
        chains.v *= 0
        chains.go()
        self.assert_copies_go_on(chains)
        chains.c.set_masses([3, 8], [5, 6.5])
        chains.c.set_lengths([bridge], chains.lengths([[4, 9]]))
        self.assert_copies_go_on(chains)
        chains.c.set_lengths([bridge + 1], chains.lengths([[9, 14]]) + 1e-4, rates=[0.1])
        self.assert_copies_go_on(chains)
        chains.go(1)
        chains.c.set_lengths([bridge + 1], chains.lengths([[9, 14]]))
        chains.c.remove([0, bridge])
        self.assert_copies_go_on(chains)
        chains.go()
        again = copy.deepcopy(chains.c)
        self.assertEqual(again.add(tanor.Rods([[0, 5]]), chains.r), chains.c.add(tanor.Rods([[0, 5]]), chains.r))

    def test_copies_know_points_that_were_renumbered(self):
        chains = Chains()
        chains.go()
        chains.c.remove([0, 1])
        for k in range(3):
            from_ = numpy.random.default_rng(k).permutation(15)
            from_[from_ == (1 if k == 0 else 99)] = -1  # point 1 leaves, another one comes
            for each in (chains.r, chains.v, chains.masses):
                each[:] = each[from_]
            chains.masses[from_ < 0] = 2.5
            chains.c.renumber(from_, chains.masses, chains.r)
            self.assert_copies_go_on(chains)
        chains.go()
        free = numpy.flatnonzero(chains.masses == 2.5)[0]
        other = numpy.flatnonzero(numpy.isinf(chains.masses))[0]
        chains.c.add(tanor.Rods([[free, other]]), chains.r)
        chains.v[:] = 0
        self.assert_copies_go_on(chains)
        self.assertEqual(copy.deepcopy(chains.c).num_points, 15)

    def test_copies_know_a_cell_that_changes(self):
        chains = Chains(cell=(8, 8, 8))
        chains.go()
        chains.c.set_cell((8.5, 8.5, 8.5))
        chains.c.add(tanor.Rods([[10, 5]]), chains.r)
        chains.v[:] = 0
        chains.go()
        chains.c.set_cell((9, 8, 8))
        chains.go()
        self.assert_copies_go_on(chains)

    def test_driven_lengths_arrive(self):
        chains = Chains()
        h = 1e-3
        chains.v[:] = 0
        chains.time = 1.0
        for k in range(10):
            chains.c.set_lengths([11], [1 + 0.1 * h * (k + 1)], rates=[0.1])
            chains.go(1, h)
        self.assertAlmostEqual(chains.lengths([[13, 14]])[0], 1.001, delta=1e-13)

    def test_saved_bytes_are_for_the_same_constraints(self):
        chains, other = Chains(), Chains()
        chains.go()
        saved = chains.c.save()
        other.c.restore(saved)
        numpy.testing.assert_array_equal(chains.step(chains.c)[0], chains.step(other.c)[0])
        other.c.remove([3])
        with self.assertRaisesRegex(tanor.InputError, "other points or constraints"):
            other.c.restore(saved)
        with self.assertRaisesRegex(tanor.InputError, "damaged"):
            chains.c.restore(saved[:40] + b"?" + saved[41:])

    def test_degrees_of_freedom_are_shared_among_the_points_that_move(self):
        chains = Chains()
        flags = numpy.arange(15) < 5
        first, others = (chains.c.removed_degrees_of_freedom(chains.r, each) for each in (flags, ~flags))
        self.assertEqual((first, others), (4, 8))
        flags[:] = numpy.arange(15) == 1
        self.assertEqual(chains.c.removed_degrees_of_freedom(chains.r, flags), 1.5)  # its rod to the support is its own

    def test_wrong_edits_change_nothing_and_are_not_remembered(self):
        chains = Chains()
        c, r = chains.c, chains.r
        wrong = (
            (tanor.InputError, "no constraint with the id 17", lambda: c.remove([1, 17])),
            (tanor.InputError, "removed twice", lambda: c.remove([2, 2])),
            (tanor.InputError, "whole numbers", lambda: c.remove([0.5])),
            (tanor.InputError, "not positive", lambda: c.set_lengths([1], [-1.0])),
            (tanor.InputError, "lengths has 2", lambda: c.set_lengths([1], [1.0, 2.0])),
            (tanor.InputError, "become a support", lambda: c.set_masses([1], [numpy.inf])),
            (tanor.InputError, "no point 15", lambda: c.set_masses([15], [1])),
            (tanor.InputError, "still holds point 14", lambda: c.renumber(range(14), chains.masses[:14])),
            (tanor.InputError, "used once", lambda: c.add(tanor.Rods([[0, 5]], name="links"), r)),
            (tanor.InputError, "no constraint with the id 12", lambda: c.rows(12)),
            (tanor.InputError, "flags has 3", lambda: c.removed_degrees_of_freedom(r, [True] * 3)),
            (ValueError, "positions: they are needed", lambda: c.add(tanor.Rods([[0, 5]]))),
            (ValueError, r"positions: found the shape \[4, 3\]", lambda: c.add(tanor.Rods([[0, 5]]), r[:4])),
        )
        for kind, text, call in wrong:
            with self.subTest(text=text), self.assertRaisesRegex(kind, text):
                call()
        self.assertEqual((c.num_rows, c.num_points), (12, 15))
        self.assert_copies_go_on(chains)


class Mistakes(unittest.TestCase):
    def setUp(self):
        self.host = Host()

    def refused(self, kind, text, call):
        with self.assertRaisesRegex(kind, text):
            call()

    def test_wrong_arrays_are_refused_by_name(self):
        c, r, v = self.host.constrainer, self.host.r, self.host.v
        self.refused(TypeError, "positions: found numbers of type float32, wanted float64",
                     lambda: c.violation(r.astype("float32")))
        self.refused(TypeError, r"positions: found list, wanted a numpy array of float64 \[11, 3\]",
                     lambda: c.violation(r.tolist()))
        self.refused(ValueError, r"velocities: found the shape \[11, 2\], wanted \[11, 3\]",
                     lambda: c.constrain_velocities(1e-3, r, v[:, :2]))
        self.refused(ValueError, r"positions: found the shape \[5, 3\]", lambda: c.violation(r[:5]))
        self.refused(ValueError, "positions: the three numbers of a point do not follow one another",
                     lambda: c.violation(numpy.asfortranarray(r)))
        self.refused(ValueError, r"multipliers: found the shape \[3\], wanted \[10\]",
                     lambda: c.solve(r, v, v, multipliers=numpy.empty(3)))
        self.refused(ValueError, "old_positions: it is the same array",
                     lambda: c.constrain_positions(1e-3, r, r))
        self.refused(ValueError, "positions: the index names row 99 of 11",
                     lambda: c.violation(r, index=numpy.full(11, 99, "int32")))
        frozen = r.copy()
        frozen.flags.writeable = False
        self.refused(ValueError, "positions: it is read-only", lambda: c.project_positions(frozen))

    def test_wrong_descriptions_are_input_errors_with_a_place(self):
        r = numpy.zeros((2, 3))
        r[1, 0] = 1
        for constraint, place in ((tanor.Rods([[0, 5]]), "/constraints/0/pairs/0"), (7, "/constraints/0"),
                                  (tanor.Rods([[0, 1]], length="x"), "/constraints/0/length"),
                                  (tanor.Rods([[0.5, 1]]), "/constraints/0/pairs")):
            with self.assertRaises(tanor.InputError) as caught:
                tanor.Constrainer([1, 1], [constraint], r)
            self.assertTrue(caught.exception.where.startswith(place), caught.exception)
        self.assertTrue(issubclass(tanor.InputError, ValueError))

    def test_a_failure_is_a_report_and_touches_no_array(self):
        host = self.host
        old, moved = host.r.copy(), host.r.copy()
        moved[5] = [50, 60, 70]
        before = moved.copy()
        report = host.constrainer.constrain_positions(1e-3, old, moved)
        self.assertFalse(report.ok)
        self.assertIn("rods[", report.outcome.what)
        numpy.testing.assert_array_equal(moved, before)

    def test_reports_show_themselves(self):
        text = repr(self.host.constrainer.violation(self.host.r))
        self.assertTrue(text.startswith("ConstraintReport(ok=True, outcome=Outcome(ok=True, status='ok'"), text)


class OtherThreads(unittest.TestCase):
    def test_python_goes_on_while_a_projection_computes(self):
        n = 60000
        r = numpy.zeros((n, 3))
        r[:, 0] = numpy.arange(n)
        constrainer = tanor.Constrainer(numpy.ones(n), [tanor.Rods([[i, i + 1] for i in range(n - 1)])], r)
        moved = r + 1e-3 * numpy.sin(numpy.arange(3.0 * n)).reshape(n, 3)
        ticks, done = [], threading.Event()

        def work():
            for _ in range(30):
                constrainer.project_positions(moved.copy())
            done.set()

        thread = threading.Thread(target=work)
        thread.start()
        while not done.is_set():
            ticks.append(1)
            time.sleep(1e-4)
        thread.join()
        self.assertGreater(len(ticks), 10)


if __name__ == "__main__":
    unittest.main()
