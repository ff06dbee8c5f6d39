"""Motions, their ends, and functions of users."""

import copy
import os
import pickle
import signal
import threading
import time
import unittest

import numpy
import tanor

from chain import hanging_chain, pendulum


def paraboloid(t, r, v):
    """xi = z - x^2 - y^2 of [k, 1, 3] points, with its gradient, rate and phi."""
    x, y, z = r[:, 0].T
    u = v[:, 0]
    gradient = numpy.stack([-2 * x, -2 * y, numpy.ones_like(x)], axis=-1)
    return z - x * x - y * y, gradient, (gradient * u).sum(axis=1), -2 * (u[:, 0]**2 + u[:, 1]**2)


def drag(t, r, v):
    return -0.3 * v


def bead_on_incline(friction):
    """A bead on a plane that leans by 45 degrees."""
    return tanor.System([[0, 0, 0]], [2.0], constraints=[tanor.Planes([0], normal=(1, 0, 1), name="incline")],
                        forces=[tanor.Gravity((0, 0, -10))], friction=[friction])


class Motions(unittest.TestCase):
    def test_a_pendulum_keeps_its_energy_and_its_certificate_passes(self):
        simulation = tanor.Simulation(pendulum())
        self.assertTrue(simulation.advance_to(2.0).ok)
        self.assertLess(abs(simulation.report.energy.drift_relative), 1e-8)
        self.assertTrue(simulation.certify().passed)
        solution = simulation.solution()
        # m v^2/L + m g cos: the pull of a pendulum of 1 kg on 1 m
        r, v = simulation.positions[1], simulation.velocities[1]
        self.assertAlmostEqual(solution["rod0"].tension[0], v @ v - 9.81 * r[2], places=7)

    def test_arrays_are_views_that_follow_the_motion(self):
        simulation = tanor.Simulation(hanging_chain())
        positions = simulation.positions
        before = positions.copy()
        self.assertTrue(simulation.advance_to(0.1).ok)
        self.assertTrue(numpy.shares_memory(positions, simulation.positions))
        self.assertGreater(abs(positions - before).max(), 1e-3)
        self.assertFalse(positions.flags.writeable)
        del simulation
        self.assertEqual(positions.shape, (11, 3))  # the view keeps the simulation alive

    def test_a_restored_simulation_goes_on_bit_by_bit(self):
        first, second = tanor.Simulation(hanging_chain()), tanor.Simulation(hanging_chain())
        self.assertTrue(first.advance_to(0.2).ok)
        second.restore(first.save())
        self.assertTrue(first.advance_to(0.4).ok and second.advance_to(0.4).ok)
        numpy.testing.assert_array_equal(first.positions, second.positions)
        with self.assertRaises(tanor.InputError):
            second.restore(b"no simulation")

    def test_run_keeps_the_states_at_its_output_times(self):
        trajectory = tanor.run(tanor.Simulation(pendulum()), 1.0, 0.25)
        numpy.testing.assert_array_equal(trajectory.times, [0, 0.25, 0.5, 0.75, 1])
        self.assertEqual(trajectory.positions.shape, (5, 2, 3))
        self.assertTrue(trajectory.outcome.ok)

    def test_an_event_stops_where_it_says(self):
        simulation = tanor.Simulation(pendulum())
        simulation.add_event(lambda t, r, v: r[1, 0], stops=True, name="below")
        self.assertTrue(simulation.advance_to(5.0).ok)
        self.assertAlmostEqual(simulation.positions[1, 2], -1.0, places=7)
        self.assertEqual(len(simulation.passages), 1)
        self.assertAlmostEqual(simulation.passages[0].time, simulation.time, places=9)

    def test_motion_options_are_obeyed_and_checked(self):
        simulation = tanor.Simulation(pendulum(), tanor.MotionOptions(method="rattle", step=1e-3))
        self.assertTrue(simulation.advance_to(0.1).ok)
        self.assertEqual((simulation.report.method, simulation.report.steps), ("rattle", 100))
        with self.assertRaisesRegex(tanor.InputError, "/motion/method"):
            tanor.Simulation(pendulum(), tanor.MotionOptions(method="euler"))
        with self.assertRaisesRegex(tanor.InputError, "/solver/form.*wanted one of auto, normal, tangent, both"):
            tanor.Simulation(pendulum(), solver=tanor.SolverOptions(form="other"))


class ContactEvents(unittest.TestCase):
    def test_a_rope_that_snaps_is_told(self):
        system = tanor.System([[0, 0, 0], [0.6, 0, 0]], 1, supports=[tanor.Support([0])],
                              constraints=[tanor.Ropes([[0, 1]], length=1)], forces=[tanor.Gravity((0, 0, -10))])
        simulation = tanor.Simulation(system)
        self.assertTrue(simulation.advance_to(0.5).ok)
        event, = simulation.report.contact_events
        self.assertEqual((event.change, event.equations), ("snap", [0]))
        self.assertAlmostEqual(event.time, 0.4, 12)  # it falls 0.8 m
        numpy.testing.assert_allclose(event.impulses, 0.8 * 4, rtol=1e-12)
        self.assertIn("snap", repr(event))
        self.assertEqual(pickle.loads(pickle.dumps(event)).change, "snap")


class Ends(unittest.TestCase):
    def test_progress_ends_a_run_after_a_step(self):
        simulation = tanor.Simulation(hanging_chain(), tanor.MotionOptions(method="rattle", step=1e-3))
        self.assertTrue(simulation.advance_to(1.0, lambda report: report.steps < 7).ok)
        self.assertEqual(simulation.report.steps, 7)
        self.assertAlmostEqual(simulation.time, 7e-3, places=12)
        self.assertTrue(simulation.advance_to(0.1).ok)

    def test_what_progress_raises_comes_out_and_the_run_can_go_on(self):
        simulation = tanor.Simulation(pendulum())
        with self.assertRaises(ZeroDivisionError):
            simulation.advance_to(1.0, lambda report: 1 / 0)
        self.assertTrue(simulation.outcome.ok)
        self.assertTrue(simulation.advance_to(1.0).ok)

    def test_ctrl_c_ends_a_run_between_two_steps(self):
        simulation = tanor.Simulation(hanging_chain())
        threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            simulation.advance_to(1e5)
        self.assertTrue(simulation.outcome.ok)
        reached = simulation.time
        self.assertTrue(0.0 < reached < 1e5)
        self.assertTrue(simulation.advance_to(reached + 0.01).ok)

    def test_another_thread_runs_meanwhile_but_not_on_the_same_simulation(self):
        simulation, stop = tanor.Simulation(hanging_chain()), threading.Event()
        thread = threading.Thread(target=lambda: simulation.advance_to(1e5, lambda report: not stop.is_set()))
        thread.start()
        ticks, refused = 0, False
        end = time.monotonic() + 10
        while not refused and time.monotonic() < end:
            ticks += 1
            try:
                simulation.save()
            except RuntimeError as error:
                refused = "in use by another thread" in str(error)
        stop.set()
        thread.join()
        self.assertTrue(refused)

    def test_a_motion_without_a_start_is_an_outcome(self):
        system = tanor.System([[0, 0, 0], [1, 0, 0]], [1, 1], supports=[tanor.Support([0]), tanor.Support([1])],
                              constraints=[tanor.Rods([[0, 1]], length=1.0)])
        system.supports[1].displacement = ("0.1*t^2", 0, 0)
        simulation = tanor.Simulation(system)
        outcome = simulation.advance_to(1.0) if simulation.outcome.ok else simulation.outcome
        self.assertEqual((outcome.ok, outcome.status), (False, "contradictory"))


class Functions(unittest.TestCase):
    def both(self, first, second, t_end, tolerance):
        a, b = tanor.Simulation(first), tanor.Simulation(second)
        self.assertTrue(a.advance_to(t_end).ok and b.advance_to(t_end).ok)
        self.assertLess(abs(a.positions - b.positions).max(), tolerance)

    def test_a_force_in_python_is_the_same_as_the_librarys(self):
        shapes = set()

        def counted(t, r, v):
            shapes.add((r.shape, v.shape))
            return drag(t, r, v)

        in_python, in_library = hanging_chain(), hanging_chain()
        in_python.forces.append(tanor.FormulaForce(range(1, 11), kernel=counted))
        in_library.forces.append(tanor.Drag(range(1, 11), linear=0.3))
        self.both(in_python, in_library, 0.3, 1e-7)
        self.assertIn(((10, 3), (10, 3)), shapes)  # all members in one call

    def test_a_constraint_in_python_is_the_same_as_its_formula(self):
        def system(kernel):
            return tanor.System([[1, 0, 1], [0, 0.5, 0.25]], [1, 2],
                                constraints=[tanor.UserConstraints([[0], [1]], kernel=kernel)],
                                forces=[tanor.Gravity((0, 0, -9.81))])

        self.both(system(paraboloid), system("z1 - x1^2 - y1^2"), 1.0, 1e-7)

    def test_friction_forces_are_those_of_the_law(self):
        simulation = tanor.Simulation(bead_on_incline(tanor.Coulomb(["incline"], coefficient=0.25)))
        pull = 20 / 2**0.5  # N: weight along the incline, and across it
        on_the_way = []

        def look(report):
            on_the_way.append(simulation.friction_forces())

        self.assertTrue(simulation.advance_to(0.1, look).ok)
        along = simulation.velocities[0] / numpy.linalg.norm(simulation.velocities[0])
        for friction in [simulation.friction_forces()] + on_the_way:
            self.assertEqual(friction.shape, (1, 3))
            numpy.testing.assert_allclose(friction[0], -0.25 * pull * along, atol=1e-11)
        self.assertEqual(len(on_the_way), simulation.report.steps)

    def test_friction_forces_are_zero_without_friction(self):
        simulation = tanor.Simulation(pendulum())
        numpy.testing.assert_array_equal(simulation.friction_forces(), numpy.zeros((2, 3)))

    def test_friction_in_python_is_the_same_as_viscous(self):
        def law(t, r, v, multipliers):
            return -0.5 * v, numpy.zeros((len(r), 3, multipliers.shape[1]))

        self.both(bead_on_incline(tanor.UserFriction("incline", kernel=law, num_multipliers=1)),
                  bead_on_incline(tanor.Viscous("incline", coefficient=0.5)), 1.0, 1e-7)

    def test_a_law_of_friction_is_called_for_all_its_contacts_at_once(self):
        counts = set()

        def law(t, r, v, multipliers):
            counts.add((r.shape, v.shape, multipliers.shape))
            normal = numpy.abs(multipliers)[:, :, None]  # [k, 1, 1]
            speed = numpy.linalg.norm(v, axis=1, keepdims=True)
            return -0.1 * normal[:, 0] * v / speed, -0.1 * numpy.sign(multipliers)[:, :, None] * (v / speed)[:, :, None]

        n = 70
        points = numpy.stack([numpy.arange(n), numpy.zeros(n), numpy.zeros(n)], axis=1)
        velocities = numpy.stack([numpy.zeros(n), 3 + 0.01 * numpy.arange(n), numpy.zeros(n)], axis=1)

        def system(friction):
            return tanor.System(points, 1 + 0.1 * numpy.arange(n), velocities=velocities,
                                constraints=[tanor.Planes(list(range(n)), normal=(0, 0, 1), name="floor")],
                                forces=[tanor.Gravity((0, 0, -10))], friction=[friction])

        self.both(system(tanor.UserFriction("floor", kernel=law, num_multipliers=1)),
                  system(tanor.Coulomb("floor", coefficient=0.1)), 0.5, 1e-9)
        self.assertEqual(counts, {((64, 3), (64, 3), (64, 1)), ((6, 3), (6, 3), (6, 1))})

    def test_functions_of_time_are_numbers_texts_tables_and_callables(self):
        def swing(t):
            return 0.1 - 0.1 * numpy.cos(3 * t), 0.3 * numpy.sin(3 * t), 0.9 * numpy.cos(3 * t)

        times = numpy.linspace(0, 1.5, 301)
        formula = tanor.Formula("a*(1-cos(3*t))", {"a": 0.1})
        self.both(pendulum((swing, 0, 0)), pendulum((formula, 0, 0)), 1.0, 1e-7)
        self.both(pendulum((tanor.Table(times, 0.1 - 0.1 * numpy.cos(3 * times)), 0, 0)), pendulum((formula, 0, 0)), 1.0, 1e-5)
        self.both(pendulum(("0.1*(1-cos(3*t))", 0, 0)), pendulum((formula, 0, 0)), 1.0, 1e-12)

    def test_what_a_function_raises_or_returns_wrongly_comes_out(self):
        for kernel, kind in ((lambda t, r, v: 1 / 0, ZeroDivisionError), (lambda t, r, v: r[:0], ValueError),
                             (lambda t, r, v: "no force", ValueError)):
            with self.assertRaises(kind):
                simulation = tanor.Simulation(tanor.System([[0, 0, 0]], [1], forces=[tanor.FormulaForce([0], kernel=kernel)]))
                simulation.advance_to(1.0)


class Descriptions(unittest.TestCase):
    def test_a_system_is_kept_by_pickle_and_deepcopy(self):
        system = hanging_chain()
        system.forces.append(tanor.FormulaForce(range(1, 11), kernel=drag))
        for again in (copy.deepcopy(system), pickle.loads(pickle.dumps(system))):
            a, b = tanor.Simulation(system), tanor.Simulation(again)
            self.assertTrue(a.advance_to(0.1).ok and b.advance_to(0.1).ok)
            numpy.testing.assert_array_equal(a.positions, b.positions)

    def test_a_simulation_is_kept_on_its_way(self):
        motion = tanor.MotionOptions(method="taylor", rtol=1e-9)
        first = tanor.Simulation(hanging_chain(), motion)
        self.assertTrue(first.advance_to(0.1).ok)
        for again in (copy.deepcopy(first), pickle.loads(pickle.dumps(first))):
            self.assertEqual(again.time, 0.1)
            numpy.testing.assert_array_equal(again.positions, first.positions)
            beside = tanor.Simulation(hanging_chain(), motion)
            beside.restore(first.save())
            self.assertTrue(again.advance_to(0.3).ok and beside.advance_to(0.3).ok)
            numpy.testing.assert_array_equal(again.positions, beside.positions)

    def test_dynamics_answers_as_the_simulation_and_inverse_dynamics_finds_no_control(self):
        system = hanging_chain()
        dynamics = pickle.loads(pickle.dumps(tanor.Dynamics(system)))
        r, w = system.positions, numpy.empty((11, 3))
        multipliers = numpy.empty(dynamics.num_equations)
        self.assertTrue(dynamics.solve(r, accelerations=w, multipliers=multipliers).ok)
        numpy.testing.assert_allclose(w[1:, 2], -9.81, rtol=1e-13)  # all rods horizontal: free fall but for the first
        forces = tanor.InverseDynamics(system).evaluate(r, numpy.zeros((11, 3)), w)
        self.assertLess(forces.largest_control, 1e-13)
        self.assertTrue(dynamics.certify(r).passed)

    def test_a_scene_file_runs_as_the_program_does(self):
        file = os.path.join(os.environ["TANOR_EXAMPLES"], "pendulum.json")
        scene = tanor.Scene(file)
        trajectory = tanor.run_scene(scene)
        self.assertTrue(trajectory.outcome.ok)
        self.assertEqual(trajectory.times[-1], scene.t_end)
        again = tanor.run_scene(pickle.loads(pickle.dumps(scene)))
        numpy.testing.assert_array_equal(trajectory.positions, again.positions)
        self.assertEqual(tanor.Scene(file, t_end=0.5).t_end, 0.5)
        with self.assertRaisesRegex(tanor.InputError, "nowhere.json"):
            tanor.Scene("nowhere.json")


if __name__ == "__main__":
    unittest.main()
