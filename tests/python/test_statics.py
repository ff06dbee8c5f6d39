"""Rest, small vibrations and buckling, against closed forms."""

import os
import threading
import unittest

import numpy
import tanor

from chain import hanging_chain, pendulum

G = 9.81


def standing(stiffness):
    """A point of 2 kg on a rod of 0.5 m above its support, held in x and y by springs."""

    def held(r, t, k):
        return 0.5 * k * (r[0]**2 + r[1]**2)

    return tanor.System([[0, 0, 0], [0, 0, 0.5]], [1, 2], supports=[tanor.Support([0])],
                        constraints=[tanor.Rods([[0, 1]])],
                        forces=[tanor.Gravity((0, 0, -G), name="weight"),
                                tanor.Potential([[1]], kernel=tanor.Definition(held), constants={"k": stiffness})])


class Rest(unittest.TestCase):
    def test_of_a_pendulum_is_below_and_its_rod_pulls_with_the_weight(self):
        found = tanor.find_equilibrium(pendulum())
        self.assertTrue(found.ok, found.outcome.what)
        self.assertEqual(found.status, "stable")
        numpy.testing.assert_allclose(found.positions, [[0, 0, 0], [0, 0, -1]], atol=1e-12)
        numpy.testing.assert_allclose(found.multipliers, [-G], rtol=1e-12)
        numpy.testing.assert_allclose(found.support_forces[0], [0, 0, -G], atol=1e-11)
        self.assertAlmostEqual(found.lowest_omega2, G, places=9)
        self.assertEqual((found.lowest_shape.shape, found.multipliers_unique.tolist()), ((2, 3), [True]))
        self.assertLess(found.residual_force, 1e-10 * found.largest_force)
        self.assertIn("status='stable'", repr(found))

    def test_of_two_uneven_rods_balances_their_tensions(self):
        # A weight on rods of 3 and 4 m between supports 5 m apart: a right angle, T1 = W cos of the angle of rod 1.
        system = tanor.System([[0, 0, 0], [2, 1, -2], [5, 0, 0]], [1, 1, 1], supports=[tanor.Support([0, 2])],
                              constraints=[tanor.Rods([[0, 1], [1, 2]], length=[3, 4])],
                              forces=[tanor.Gravity((0, 0, -10))])
        found = tanor.find_equilibrium(system, tanor.EquilibriumOptions(force_tolerance=1e-12))
        self.assertTrue(found.ok, found.outcome.what)
        numpy.testing.assert_allclose(found.positions[1], [1.8, 0, -2.4], atol=1e-10)
        numpy.testing.assert_allclose(-found.multipliers, [8, 6], rtol=1e-10)

    def test_that_is_unstable_is_an_outcome_or_an_answer_as_asked(self):
        refused = tanor.find_equilibrium(standing(1.0), tanor.EquilibriumOptions(method="newton"))
        self.assertFalse(refused.ok)
        self.assertIn("unstable", refused.outcome.what)
        taken = tanor.find_equilibrium(standing(1.0), tanor.EquilibriumOptions(method="newton", accept="any"))
        self.assertTrue(taken.ok)
        self.assertEqual((taken.status, taken.unstable_directions), ("unstable", 2))
        self.assertAlmostEqual(taken.lowest_omega2, 1.0 / 2.0 - G / 0.5, places=9)

    def test_on_a_floor_is_where_it_presses(self):
        system = tanor.System([[0, 0, 1], [0, 0, 3]], [2, 1], forces=[tanor.Gravity((0, 0, -G))],
                              constraints=[tanor.Planes([0, 1, 0], normal=(0, 0, 1), name="floor"),
                                           tanor.Planes([1], normal=(0, 0, -1), offset=-9, name="ceiling")])
        options = tanor.EquilibriumOptions(accept="marginal", one_sided={"floor": "at_least", "ceiling": "at_least"})
        found = tanor.find_equilibrium(system, options)
        self.assertTrue(found.ok, found.outcome.what)
        numpy.testing.assert_allclose(found.positions[:, 2], [0, 0], atol=1e-12)
        # The floor is named twice for point 0: once is enough to hold it.
        self.assertEqual(found.open.tolist(), [False, False, True, True])
        numpy.testing.assert_allclose(found.multipliers, [2 * G, G, 0, 0], atol=1e-9)

    def test_of_a_scene_is_that_of_its_file(self):
        scene = tanor.Scene(os.path.join(os.environ["TANOR_EXAMPLES"], "hanging_net.json"))
        found = tanor.find_equilibrium(scene)
        self.assertTrue(found.ok, found.outcome.what)
        self.assertEqual(found.positions.shape, (scene.num_points, 3))
        self.assertLess(found.residual_force, 1e-10 * found.largest_force)

    def test_another_thread_runs_meanwhile(self):
        net, ticks, is_done = tanor.Scene(os.path.join(os.environ["TANOR_EXAMPLES"], "hanging_net.json")), 0, False

        def rest():
            nonlocal is_done
            tanor.find_equilibrium(net)
            is_done = True

        thread = threading.Thread(target=rest)
        thread.start()
        while not is_done:
            ticks += 1
        thread.join()
        self.assertGreater(ticks, 1000)


class Vibrations(unittest.TestCase):
    def test_of_two_hanging_points_are_the_zeros_of_a_laguerre_polynomial(self):
        found = tanor.find_equilibrium(hanging_chain(3))
        modes = tanor.modes(hanging_chain(3), found.positions, multipliers=found.multipliers)
        self.assertTrue(modes.ok, modes.outcome.what)
        x = numpy.sqrt(G / 0.1 * numpy.array([2 - 2**0.5, 2 - 2**0.5, 2 + 2**0.5, 2 + 2**0.5]))
        numpy.testing.assert_allclose(modes.omega, x, rtol=1e-10)
        self.assertEqual((modes.shapes.shape, modes.degrees_of_freedom), ((4, 3, 3), 4))
        self.assertLess(modes.residual_max, 1e-10)
        flat = modes.shapes.reshape(4, 9)
        numpy.testing.assert_allclose(0.1 * flat @ flat.T, numpy.eye(4), atol=1e-10)  # q'Mq = 1
        self.assertFalse(modes.shapes.flags.writeable)

    def test_are_as_many_as_asked_and_grow_where_it_is_unstable(self):
        modes = tanor.modes(standing(1.0), options=tanor.ModesOptions(count=1))
        self.assertEqual(modes.omega.shape, (1,))
        self.assertAlmostEqual(modes.omega[0], -(G / 0.5 - 0.5)**0.5, places=9)
        everything = tanor.modes(standing(1.0), options=tanor.ModesOptions(count="all"))
        self.assertEqual((len(everything.omega), everything.unstable_directions), (2, 2))

    def test_take_a_prestress_where_the_load_says_nothing(self):
        # A point of 1 kg in the middle of a straight wire of two rods of 1 m: omega^2 = 2 T/(m l).
        wire = tanor.System([[-1, 0, 0], [0, 0, 0], [1, 0, 0]], [1, 1, 1], supports=[tanor.Support([0, 2])],
                            constraints=[tanor.Rods([[0, 1], [1, 2]], name="wire")])
        modes = tanor.modes(wire, options=tanor.ModesOptions(prestress={"wire": 50.0}))
        self.assertTrue(modes.ok, modes.outcome.what)
        numpy.testing.assert_allclose(modes.omega, [10, 10], rtol=1e-10)
        self.assertFalse(tanor.modes(wire).ok)

    def test_leave_out_what_is_open(self):
        # A bead on its rod hangs beside a wall that it does not touch: it swings as without the wall.
        system = pendulum()
        system.constraints.append(tanor.Planes([1], normal=(1, 0, 0), offset=-1, name="wall"))
        options = tanor.EquilibriumOptions(one_sided={"wall": "at_least"})
        rest = tanor.find_equilibrium(system, options)
        self.assertEqual(rest.open.tolist(), [False, True])
        modes = tanor.modes(system, rest.positions, multipliers=rest.multipliers, open=rest.open)
        numpy.testing.assert_allclose(modes.omega, 2 * [G**0.5], rtol=1e-10)
        with self.assertRaisesRegex(tanor.InputError, "open"):
            tanor.modes(system, rest.positions, open=[True])

    def test_with_drag_decay(self):
        # lambda^2 + (c/m) lambda + g/l = 0
        system = pendulum()
        system.forces.append(tanor.Drag([1], linear=0.6))
        rest = tanor.find_equilibrium(system)
        modes = tanor.modes(system, rest.positions, tanor.ModesOptions(damped=True))
        self.assertTrue(modes.ok, modes.outcome.what)
        half = 0.5 * 0.6 / system.masses[1]
        numpy.testing.assert_allclose(modes.decay, [half, half], rtol=1e-10)
        numpy.testing.assert_allclose(modes.omega, 2 * [(G - half**2)**0.5], rtol=1e-10)
        self.assertEqual((modes.shapes.shape, modes.shapes_imaginary.shape), ((2, 2, 3), (2, 2, 3)))
        size = system.masses[1] * (modes.shapes**2 + modes.shapes_imaginary**2).sum(axis=(1, 2))
        numpy.testing.assert_allclose(size, [1, 1], rtol=1e-10)
        without = tanor.modes(pendulum(), rest.positions)
        self.assertEqual((len(without.decay), without.shapes_imaginary.shape), (0, (0, 0, 3)))


class Buckles(unittest.TestCase):
    def test_a_standing_point_at_the_load_that_its_springs_hold(self):
        found = tanor.find_buckling(standing(100.0), tanor.BucklingOptions(loads="weight"))
        self.assertTrue(found.ok, found.outcome.what)
        self.assertAlmostEqual(found.load_factor, 100.0 * 0.5 / (2 * G), places=9)
        self.assertEqual(found.shape.shape, (2, 3))
        self.assertLess(abs(found.shape[1, 2]), 1e-10)


class Mistakes(unittest.TestCase):
    def test_name_their_place(self):
        for work, place in (
                (lambda: tanor.find_equilibrium(pendulum(), tanor.EquilibriumOptions(max_iterations=0)),
                 "/equilibrium/max_iterations"),
                (lambda: tanor.find_equilibrium(pendulum(), tanor.EquilibriumOptions(accept="some")), "/equilibrium/accept"),
                (lambda: tanor.find_equilibrium(pendulum(), tanor.EquilibriumOptions(prestress={"rope": 1.0})),
                 "/equilibrium/prestress"),
                (lambda: tanor.find_equilibrium(pendulum(), tanor.EquilibriumOptions(one_sided={"floor": "up"})),
                 "/equilibrium/one_sided/floor"),
                (lambda: tanor.modes(pendulum(), options=tanor.ModesOptions(count="many")), "/modes/count"),
                (lambda: tanor.modes(pendulum(), options=tanor.ModesOptions(prestress=[1.0])), "/modes/prestress"),
                (lambda: tanor.find_equilibrium(pendulum(), solver=tanor.SolverOptions(form="other")), "/solver/form")):
            with self.subTest(place=place), self.assertRaises(tanor.InputError) as caught:
                work()
            self.assertTrue(caught.exception.where.startswith(place), str(caught.exception))

    def test_of_positions_say_what_is_wrong(self):
        with self.assertRaisesRegex(tanor.InputError, "point 1"):
            tanor.modes(pendulum())  # it lies: no equilibrium
        with self.assertRaisesRegex(ValueError, "positions"):
            tanor.modes(pendulum(), numpy.zeros((3, 3)))
        with self.assertRaisesRegex(ValueError, "multipliers"):
            tanor.modes(standing(1.0), multipliers=numpy.zeros(2))
        with self.assertRaises(tanor.InputError):
            tanor.find_buckling(standing(1.0), tanor.BucklingOptions(loads="wind"))
        with self.assertRaises(tanor.InputError):
            tanor.find_buckling(standing(1.0))  # no load is named


if __name__ == "__main__":
    unittest.main()
