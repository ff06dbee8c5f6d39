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
        # A handle that goes on has its factor from the step before, a new one makes it: the last bits may differ.
        numpy.testing.assert_allclose(host.r, other.r, rtol=0, atol=1e-14)
        numpy.testing.assert_array_equal(other.r, third.r)

    def test_a_pickle_keeps_the_lengths_of_the_start(self):
        host = Host()
        host.r[:, 0] *= 2  # the host's array moves on; the description does not
        again = pickle.loads(pickle.dumps(host.constrainer))
        self.assertAlmostEqual(again.violation(host.r).violation, 1.0, places=12)

    def test_an_index_reads_and_writes_rows_in_another_order(self):
        host = Host()
        order = numpy.random.default_rng(1).permutation(20)[:11].astype("int32")
        wide = numpy.full((20, 3), 7.0)
        wide[order] = host.r + 0.01 * numpy.sin(numpy.arange(33.0)).reshape(11, 3)
        packed = wide[order].copy()
        self.assertTrue(host.constrainer.project_positions(packed).ok)
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
