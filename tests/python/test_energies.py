"""Energies and forces of several points by functions of Python."""

import math
import threading
import unittest

import numpy
import tanor


def spring(r1, r2, t, k):
    return 0.5 * k * (numpy.linalg.norm(r2 - r1) - 1.0)**2


def beaten(r1, r2, t):
    """Reads the time, and most functions."""
    d = r2 - r1
    c = d @ d
    return (0.3 * numpy.cos(2 * t) * numpy.sqrt(c) + numpy.exp(-c) + 0.1 * numpy.arctan2(d[1], 2 + d[0]) +
            numpy.tanh(d[2]) / (1 + c) + abs(numpy.sin(d[0])) * 0.2 + numpy.cross(r1, r2)[2]**2 * 0.1 +
            (0.2 * d[1]).max(-0.1) + 2.0**d[2] * 0.1)


BEATEN = ("0.3*cos(2*t)*sqrt(C) + exp(-C) + 0.1*atan2(y2-y1, 2+x2-x1) + tanh(z2-z1)/(1+C) + 0.2*abs(sin(x2-x1)) + "
          "0.1*(x1*y2-y1*x2)^2 + max(0.2*(y2-y1), -0.1) + 0.1*2^(z2-z1)").replace(
              "C", "((x2-x1)^2 + (y2-y1)^2 + (z2-z1)^2)")


def two_points(*forces):
    return tanor.System([[0, 0.1, 0], [1.2, 0.3, -0.4]], [1, 2], velocities=[[0, 0, 0.1], [0.2, -0.1, 0]],
                        forces=list(forces))


def active_forces(system, time=0.3):
    forces = numpy.empty((len(system.masses), 3))
    assert tanor.Dynamics(system).solve(numpy.array(system.positions, float), numpy.array(system.velocities, float), time,
                                        active_forces=forces).ok
    return forces


class Definitions(unittest.TestCase):
    def test_are_what_their_formulas_are(self):
        for first, second in ((tanor.Definition(beaten), BEATEN), (beaten_with_constants(), BEATEN)):
            a, b = (two_points(tanor.Potential([[0, 1]], kernel=kernel)) for kernel in (first, second))
            numpy.testing.assert_allclose(active_forces(a), active_forces(b), rtol=1e-13, atol=1e-14)

    def test_have_series_stiffness_and_work_as_formulas_have(self):
        for method in ("taylor", "radau5", "dop853"):
            ends = []
            for kernel in (tanor.Definition(beaten), BEATEN):
                simulation = tanor.Simulation(two_points(tanor.Potential([[0, 1]], kernel=kernel)),
                                              tanor.MotionOptions(method=method, rtol=1e-9))
                outcome = simulation.advance_to(1.0)
                self.assertTrue(outcome.ok, outcome.what)
                self.assertLess(abs(simulation.report.energy.drift_relative), 1e-6)
                ends.append((simulation.positions.copy(), simulation.report.steps, simulation.report.energy))
            numpy.testing.assert_allclose(ends[0][0], ends[1][0], rtol=1e-10)
            self.assertEqual(ends[0][1], ends[1][1])  # the same work
        self.assertTrue(simulation.certify().passed)

    def test_take_a_constant_of_each_tuple_by_its_name(self):
        positions = [[0, 0, 0], [1.5, 0, 0], [1.5, 2.0, 0]]
        system = tanor.System(positions, [1, 1, 1], velocities=numpy.zeros((3, 3)), forces=[
            tanor.Potential([[0, 1], [1, 2]], kernel=tanor.Definition(spring), constants={"k": [30.0, 40.0]})])
        numpy.testing.assert_allclose(active_forces(system), [[15, 0, 0], [-15, 40, 0], [0, -40, 0]], rtol=1e-14)

    def test_call_python_once_and_then_run_on_any_thread(self):
        calls = []

        def counted(r1, r2, t):
            calls.append(threading.get_ident())
            return spring(r1, r2, t, 30.0)

        simulation = tanor.Simulation(two_points(tanor.Potential([[0, 1]], kernel=tanor.Definition(counted))))
        self.assertTrue(simulation.advance_to(1.0).ok)
        self.assertEqual(len(calls), 1)

    def test_refuse_what_cannot_be_taken_down_and_say_why(self):
        kept = []

        def keeps(r, t):
            kept.append(t)
            return r[0]

        def run(function, points=1):
            positions = numpy.arange(9.0).reshape(3, 3)
            tanor.validate(tanor.System(positions, [1, 1, 1], forces=[
                tanor.Potential([list(range(points))], kernel=tanor.Definition(function))]))

        with self.assertRaisesRegex(TypeError, "does not compare"):
            run(lambda r, t: r[0] if r[0] > 0 else -r[0])
        with self.assertRaisesRegex(TypeError, "does not compare"):
            run(lambda r, t: 1.0 if r[0] else 2.0)
        with self.assertRaises(TypeError):
            run(lambda r, t: math.sin(r[0]))
        with self.assertRaisesRegex(tanor.InputError, "wanted one number") as caught:
            run(lambda r, t: r)
        self.assertEqual(caught.exception.where, "/forces/0/kernel")
        with self.assertRaises(ZeroDivisionError):
            run(lambda r, t: 1 / 0)
        with self.assertRaises(TypeError):
            run(lambda r1, t: r1[0], points=2)  # too few arguments
        run(keeps)
        with self.assertRaisesRegex(ValueError, "kept after the call"):
            run(lambda r, t: r[0] + kept[0])
        with self.assertRaisesRegex(ValueError, "kept after the call"):
            kept[0] + 1.0


def beaten_with_constants():
    """A callable object, closed over a number of numpy's."""
    one = numpy.float64(1.0)

    class Beaten:
        def __call__(self, r1, r2, t):
            return one * beaten(r1, r2, t)

    return tanor.Definition(Beaten())


class ForcesOfTuples(unittest.TestCase):
    TEXTS = ["-0.2*vx1 + y2", "x1*z2", "0", "sin(t)", "-x2*vy1", "z1 - vz2"]

    @staticmethod
    def force(t, r, v):
        """The same of [k, 2, 3] points."""
        f = numpy.zeros_like(r)
        (x1, _, z1), (x2, y2, z2) = r[:, 0].T, r[:, 1].T
        f[:, 0] = numpy.stack([-0.2 * v[:, 0, 0] + y2, x1 * z2, 0 * x1], axis=-1)
        f[:, 1] = numpy.stack([numpy.sin(t) + 0 * x1, -x2 * v[:, 0, 1], z1 - v[:, 1, 2]], axis=-1)
        return f

    def test_by_a_function_are_what_their_formulas_are(self):
        pairs = [[0, 1], [1, 2], [2, 0]]
        systems = [tanor.System(numpy.random.default_rng(3).normal(size=(3, 3)), [1, 2, 3],
                                velocities=numpy.random.default_rng(4).normal(size=(3, 3)),
                                forces=[tanor.FormulaForce(tuples=pairs, kernel=kernel, points=[])])
                   for kernel in (self.force, self.TEXTS)]
        numpy.testing.assert_allclose(*map(active_forces, systems), rtol=1e-14, atol=1e-15)
        ends = [tanor.Simulation(system) for system in systems]
        for simulation in ends:
            self.assertTrue(simulation.advance_to(0.5).ok)
        numpy.testing.assert_allclose(ends[0].positions, ends[1].positions, atol=1e-7)

    def test_get_all_tuples_in_one_call_and_are_refused_in_another_shape(self):
        shapes = []

        def counted(t, r, v):
            shapes.append((r.shape, v.shape))
            return self.force(t, r, v)

        system = two_points(tanor.FormulaForce(tuples=[[0, 1], [1, 0]], kernel=counted))
        active_forces(system)
        self.assertIn(((2, 2, 3), (2, 2, 3)), shapes)
        with self.assertRaisesRegex(ValueError, r"wanted are 6"):
            active_forces(two_points(tanor.FormulaForce(tuples=[[0, 1]], kernel=lambda t, r, v: r[:, 0])))


if __name__ == "__main__":
    unittest.main()
