"""Observables and conditions in Python: closed forms of a hanging cable and of a rod that breaks."""

import copy
import math
import pickle
import unittest

import numpy
import tanor


def make_cable(links: int) -> tanor.System:
    positions = numpy.zeros((links + 1, 3))
    positions[:, 2] = -0.1 * numpy.arange(links + 1)
    return tanor.System(positions, 0.5, supports=[tanor.Support([0], name="hook")],
                        constraints=[tanor.Rods([[k, k + 1] for k in range(links)], name="links")],
                        forces=[tanor.Gravity((0, 0, -9.81))], units="si")


class Observables(unittest.TestCase):
    def test_the_default_observables_are_tensions_and_loads(self):
        found = {each.name: each for each in tanor.Simulation(make_cable(10)).observe()}
        self.assertEqual(list(found), ["max tension(links)", "min tension(links)", "load(hook)"])
        self.assertAlmostEqual(found["max tension(links)"].values[0], 5.0 * 9.81, 11)
        self.assertEqual(found["max tension(links)"].member, "links[0]")
        self.assertEqual(found["load(hook)"].unit, "N")
        self.assertEqual(found["load(hook)"].columns, ["load(hook).x", "load(hook).y", "load(hook).z"])

    def test_a_run_keeps_a_structured_array(self):
        simulation = tanor.Simulation(make_cable(4))
        simulation.add_observable("tension(links)", name="tensions")
        run = tanor.run(simulation, 0.2, 0.1)
        self.assertEqual(run.observables["tensions"].shape, (3, 4))
        numpy.testing.assert_allclose(run.observables["tensions"][-1], 0.5 * 9.81 * numpy.array([4, 3, 2, 1]), rtol=1e-10)
        self.assertEqual(run.observables["load(hook)"].shape, (3, 3))
        self.assertEqual(run.units["tensions"], "N")

    def test_a_default_is_asked_for_at_every_step(self):
        cable = make_cable(3)
        cable.positions = [[0.1 * k, 0, 0] for k in range(4)]
        largest = []
        for every_step in (False, True):
            simulation = tanor.Simulation(cable)
            self.assertEqual(simulation.add_observable("max tension(links)", every_step=every_step), 0)
            run = tanor.run(simulation, 1.0, 1.0)
            self.assertEqual(list(run.observables.dtype.names)[1:], ["max tension(links)", "min tension(links)", "load(hook)"])
            largest.append(simulation.observe()[0].largest[0].value)
        self.assertGreater(largest[1], largest[0])

    def test_rods_and_ropes_break_at_a_tension(self):
        for line in (tanor.Rods([[0, 1]], breaks_at=20, name="line"), tanor.Ropes([[0, 1]], breaks_at=[20], name="line")):
            system = tanor.System([[0, 0, 0], [1, 0, 0]], 1.0, supports=[tanor.Support([0])], constraints=[line],
                                  forces=[tanor.Gravity((0, 0, -10))])
            simulation = tanor.Simulation(system)
            self.assertTrue(simulation.advance_to(0.6).ok)
            self.assertEqual([passage.name for passage in simulation.passages], ["breaks_at of line"])
            self.assertEqual([passage.member for passage in simulation.passages], ["line[0]"])
            self.assertEqual(numpy.ravel(pickle.loads(pickle.dumps(line)).breaks_at)[0], 20)
        with self.assertRaisesRegex(tanor.InputError, "breaks_at -1 is not positive"):
            tanor.Simulation(tanor.System([[0, 0, 0], [1, 0, 0]], 1.0, constraints=[tanor.Rods([[0, 1]], breaks_at=-1)]))

    def test_limits_of_contact_are_options(self):
        floor = tanor.Planes([0], normal=(0, 0, 1), side="at_least", restitution=0.9)
        system = tanor.System([[0, 0, 1]], 1.0, constraints=[floor], forces=[tanor.Gravity((0, 0, -10))])
        simulation = tanor.Simulation(system, contact={"max_events": 3})
        self.assertIn("solver.contact.max_events", simulation.advance_to(10.0).what)
        with self.assertRaisesRegex(tanor.InputError, "max_event"):
            tanor.Simulation(system, contact={"max_event": 3})

    def test_an_event_is_a_condition_or_a_function(self):
        simulation = tanor.Simulation(make_cable(3))
        simulation.add_event("t > 0.15", do="break", of="links[1]")
        self.assertTrue(simulation.advance_to(0.3).ok)
        self.assertEqual([passage.member for passage in simulation.passages], ["links[1]"])
        with self.assertRaisesRegex(TypeError, "^function: found 3, wanted a function"):
            simulation.add_event(3)
        with self.assertRaisesRegex(TypeError, "wanted a function"):
            simulation.add_event("t > 1", when="t > 2")
        with self.assertRaisesRegex(tanor.InputError, "(?s)brake.*did you mean break"):
            simulation.add_event("t > 1", do="brake")
        with self.assertRaisesRegex(tanor.InputError, "did you mean si"):
            tanor.Simulation(tanor.System([[0, 0, 0]], units="SI"))

    def test_a_rod_breaks_at_its_tension(self):
        system = tanor.System([[0, 0, 0], [1, 0, 0]], 2.0, supports=[tanor.Support([0])],
                              constraints=[tanor.Rods([[0, 1]], name="rod")], forces=[tanor.Gravity((0, 0, -9.81))])
        simulation = tanor.Simulation(system, tanor.MotionOptions(rtol=1e-12))
        simulation.add_event(when="tension(rod) > 39.24", do="break")
        self.assertTrue(simulation.advance_to(0.6).ok)
        (passage,) = simulation.passages
        self.assertEqual(passage.member, "rod[0]")
        flight = 0.6 - passage.time
        sine = 2.0 / 3.0
        expected = math.sqrt(1.0 - sine**2) - math.sqrt(2.0 * 9.81 * sine) * sine * flight
        self.assertAlmostEqual(simulation.positions[1, 0], expected, 9)

    def test_a_member_has_its_name_and_is_nan_once_it_broke(self):
        simulation = tanor.Simulation(make_cable(4))
        simulation.add_observable("tension(links)")
        simulation.add_event(when="t > 0.15", do="break", of="links[2]")
        run = tanor.run(simulation, 0.3, 0.1)
        numpy.testing.assert_array_equal(run["links"].tension, run["tension(links)"])
        self.assertEqual([member.name for member in run["links"][1:3]], ["links[1]", "links[2]"])
        self.assertEqual((len(run["links"]), len(list(run["links"]))), (4, 4))
        for member in (run["links[2]"], run["links"][2], run["links"][-2]):
            self.assertEqual((member.name, member.multipliers.shape), ("links[2]", (4, 1)))
            self.assertEqual(repr(member), "Member('links[2]' at 4 times)")
            numpy.testing.assert_allclose(member.tension, [0.5 * 9.81 * 2] * 2 + [math.nan] * 2, rtol=1e-10)
        numpy.testing.assert_allclose(run["links[0]"].tension, 0.5 * 9.81 * numpy.array([4, 4, 2, 2]), rtol=1e-10)
        self.assertTrue(math.isnan(simulation["links[2]"].tension))
        self.assertAlmostEqual(simulation.solution()["links[1]"].tension, 0.5 * 9.81, 9)
        with self.assertRaisesRegex(KeyError, r"links\[4\]"):
            run["links[4]"]
        with self.assertRaisesRegex(IndexError, "links has 4 members"):
            run["links"][4]
        self.assertEqual((repr(simulation["links[2]"]), repr(simulation["links"])), ("Member('links[2]')", "Group('links', 4 members)"))
        (passage,) = pickle.loads(pickle.dumps(run)).passages
        self.assertEqual((passage.member, round(passage.time, 12)), ("links[2]", 0.15))
        self.assertEqual(tanor.run(simulation, 0.4).passages, [])

    def test_springs_and_bonds_are_groups_by_name(self):
        # Two points of 2 kg on springs of 1 m and 400 N/m, and one of 1 kg on a bond, at rest: m g.
        coil = tanor.Springs([[0, 1], [1, 2]], stiffness=400, rest_length=1, name="coil")
        bond = tanor.Bonds([[0, 3]], stiffness=100, rest_length=1, name="bond")
        system = tanor.System([[0, 0, 0], [0, 0, -1], [0, 0, -2], [0, 0, -1]], [1, 2, 2, 1], supports=[tanor.Support(0)],
                              forces=[coil, bond, tanor.Gravity((0, 0, -10))])
        self.assertIs(system["coil"], coil)
        with self.assertRaisesRegex(KeyError, "lid: there are .*coil, bond, gravity2"):
            system["lid"]
        rest = tanor.find_equilibrium(system)
        for result in (rest, tanor.modes(system, rest.positions), tanor.Dynamics(system).solution(rest.positions)):
            numpy.testing.assert_allclose(result["coil"].tension, [40, 20], rtol=1e-9)
            numpy.testing.assert_allclose(result["bond[0]"].tension, 10, rtol=1e-9)
            self.assertAlmostEqual(result["max tension(coil)"], 40, 7)
            self.assertAlmostEqual(result["distance(0, 3)"], 1.1, 9)
            self.assertEqual(repr(result["coil"]), "Group('coil', 2 members)")

    def test_a_spring_that_swings_pulls_by_its_closed_form_until_it_breaks(self):
        # From rest at its own length it pulls with m g (1 - cos w t), w^2 = k/m.
        coil = tanor.Springs([[0, 1]], stiffness=8, rest_length=1, name="coil")
        system = tanor.System([[0, 0, 0], [0, 0, -1]], 2.0, supports=[tanor.Support(0)], forces=[coil, tanor.Gravity((0, 0, -10))])
        simulation = tanor.Simulation(system, rtol=1e-12)
        simulation.add_event("t > 1.25", do="break", of="coil[0]")
        run = tanor.run(simulation, 2, 0.5)
        expected = 20 * (1 - numpy.cos(2 * run.times))
        expected[run.times > 1.25] = math.nan
        numpy.testing.assert_allclose(run["coil"].tension[:, 0], expected, atol=1e-9)
        numpy.testing.assert_array_equal(pickle.loads(pickle.dumps(run))["coil[0]"].tension, run["coil"].tension[:, 0])
        self.assertEqual((run.passages[0].name, run["coil"].multipliers.shape), ("t > 1.25", (5, 1, 0)))
        self.assertTrue(math.isnan(simulation["coil"].tension[0]) and math.isnan(simulation.solution()["coil[0]"].tension))
        self.assertAlmostEqual(simulation["distance(0, 1)"], numpy.linalg.norm(run.positions[-1, 1]), 12)

    def test_modes_tell_the_forces_of_the_rest_about_which_they_swing(self):
        # The middle of a line of rods hangs on its prestress, a weight on the middle.
        system = tanor.System([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 0, -1]], 1.0, supports=[tanor.Support([0, 2], name="h")],
                              constraints=[tanor.Rods([[0, 1], [1, 2], [1, 3]], name="rods")], forces=[tanor.Gravity((0, 0, -10))])
        rest = tanor.find_equilibrium(system)
        modes = tanor.modes(system, rest.positions)
        dynamics = tanor.Dynamics(system).solution(system.positions)
        for result in (rest, modes, dynamics, tanor.Simulation(system)):
            self.assertAlmostEqual(result["reaction(3)"][2], 10, 9)
            self.assertAlmostEqual(result["tension(rods[2])"], 10, 9)
            self.assertTrue(numpy.isnan(result["each load(h)"]).all())
            self.assertTrue(math.isnan(result["max tension(rods)"]))

    def test_copies_keep_what_was_asked_for(self):
        simulation = tanor.Simulation(make_cable(3))
        simulation.add_observable("distance(0, 3)", name="span", every_step=True)
        tanor.run(simulation, 0.1)
        for again in (copy.deepcopy(simulation), pickle.loads(pickle.dumps(simulation))):
            self.assertEqual([each.name for each in again.observe()], [each.name for each in simulation.observe()])
            self.assertEqual(again["span"], simulation["span"])

    def test_springs_may_have_the_name_of_the_time(self):
        system = tanor.System([[0, 0, 0], [0, 0, -2], [0, 0, -3]], 1.0, supports=[tanor.Support(0)],
                              constraints=[tanor.Rods([[1, 2]], name="rod")],
                              forces=[tanor.Springs([[0, 1]], stiffness=100.0, rest_length=1.5, name="t")])
        self.assertAlmostEqual(tanor.Simulation(system)["t"].tension[0], 50, 9)
        run = tanor.run(tanor.Simulation(system), 0.1)
        numpy.testing.assert_allclose(run["t"].tension[:, 0], 100 * (numpy.linalg.norm(run.positions[:, 1], axis=1) - 1.5), rtol=1e-9)
        with self.assertRaisesRegex(tanor.InputError, "name of the time"):
            tanor.Simulation(system).add_observable("tension(t)", name="t")

    def test_tensions_of_a_solution_are_those_of_its_system(self):
        system = tanor.System([[0, 0, 0], [0, 0, -1]], 2.0, supports=[tanor.Support(0)],
                              constraints=[tanor.Rods([[0, 1]], name="rod")], forces=[tanor.Gravity((0, 0, -10))])
        solution = tanor.Dynamics(system).solution(system.positions)
        system.constraints[0].name = "other"  # the user's own list; the solution keeps what it was made of
        system.constraints.append(tanor.Rods([[0, 1]], name="new"))
        again = pickle.loads(pickle.dumps(solution))
        for each in (solution, again):
            self.assertEqual(each.groups, {"rod": (0, 1, 1)})
            numpy.testing.assert_allclose(each.tensions["rod"], [20])
        self.assertIs(solution.tensions, solution.tensions)

    def test_tensions_that_are_not_unique_are_nan(self):
        # The first two rods hold the weight of 4 kg together, in any share; the third holds 2 kg.
        system = tanor.System([[0, 0, 0], [0, 0, -1], [0, 0, -2]], 2.0, supports=[tanor.Support(0, name="hook")],
                              constraints=[tanor.Rods([[0, 1], [0, 1], [1, 2]], name="rods")], forces=[tanor.Gravity((0, 0, -10))])
        simulation = tanor.Simulation(system)
        rest = tanor.find_equilibrium(system)
        modes = tanor.modes(system, rest.positions, multipliers=rest.multipliers)
        for result in (simulation, simulation.solution(), rest, modes, tanor.Dynamics(system).solution(system.positions)):
            numpy.testing.assert_allclose(result["rods"].tension, [math.nan, math.nan, 20], rtol=1e-9)
            numpy.testing.assert_allclose(result["load(hook)"], [0, 0, -40], atol=1e-9)
            self.assertTrue(math.isnan(result["max tension(rods)"]))
            self.assertAlmostEqual(result["sum tension(rods)"], 60, 9)
        numpy.testing.assert_allclose(tanor.run(simulation, 0.1)["rods[1]"].tension, [math.nan] * 2)
        self.assertEqual([each.unknown for each in simulation.observe()], ["not unique", "not unique", ""])
        for result in (simulation.solution(), rest, tanor.Dynamics(system).solution(system.positions)):
            stress = result.self_stress
            self.assertEqual((stress[0], stress[2]), (-stress[1], 0))
            self.assertNotEqual(stress[0], 0)
        positions = numpy.array(system.positions, float)
        constrainer = tanor.Constrainer([math.inf, 2, 2], [tanor.Rods([[0, 1], [0, 1], [1, 2]])], positions)
        for text in ("tension(rod0)", "load(support0).z", "sum tension(rod0)"):
            constrainer.add_observable(text)
        force = numpy.array([[0, 0, 0], [0, 0, -20], [0, 0, -20.0]])
        self.assertTrue(constrainer.observe(positions, numpy.zeros((3, 3)), force).ok)
        numpy.testing.assert_allclose(constrainer["tension(rod0)"], [math.nan, math.nan, 20], rtol=1e-9)
        numpy.testing.assert_allclose([constrainer["load(support0).z"], constrainer["sum tension(rod0)"]], [-40, 60], rtol=1e-9)

    def test_a_search_that_failed_knows_no_forces(self):
        cable = make_cable(2)
        cable.positions = [*cable.positions, [5, 0, 0]]  # a point that falls
        rest = tanor.find_equilibrium(cable)
        self.assertFalse(rest.ok)
        for name in ("load(hook)", "max tension(links)"):
            self.assertTrue(numpy.isnan(rest[name]).all(), name)

    def test_a_name_of_both_is_the_group(self):
        simulation = tanor.Simulation(make_cable(2))
        simulation.add_observable("load(hook).z", name="links")
        run = tanor.run(simulation, 0.1)
        self.assertEqual((repr(run["links"]), repr(simulation["links"])), ("Group('links', 2 members at 2 times)", "Group('links', 2 members)"))
        self.assertEqual(run.observables["links"].shape, (2,))

    def test_units_have_own_letters(self):
        system = tanor.System([[0, 0, 0], [0, 0, -1]], supports=[tanor.Support(0)], forces=[tanor.Gravity((0, 0, -9.81))],
                              constraints=[tanor.Rods([[0, 1]], name="rod")], units={"length": "mm", "force": "mN"})
        for copy in (system, pickle.loads(pickle.dumps(system))):
            found = {each.name: each.unit for each in tanor.Simulation(copy).observe()}
            self.assertEqual(found, {"tension(rod)": "mN", "load(support0)": "mN"})
        for units, wrong in (({"lenght": "mm"}, "did you mean length"), ({"boltzmann": "x"}, "/boltzmann"), ({"length": "a\nb"}, "on one line"), (3, "wanted")):
            with self.assertRaisesRegex(tanor.InputError, wrong):
                tanor.Simulation(tanor.System([[0, 0, 0]], units=units))

    def test_a_formula_has_the_unit_that_is_given(self):
        simulation = tanor.Simulation(make_cable(4))
        simulation.add_observable("-load(hook).z/9.81", name="weight", unit="kg")
        run = tanor.run(simulation, 0.1)
        self.assertEqual(run.units["weight"], "kg")
        with self.assertRaisesRegex(tanor.InputError, "is in N already"):
            simulation.add_observable("tension(links)", unit="kg")

    def test_states_are_those_behind_the_events_at_their_time(self):
        system = tanor.System([[0, 0, 0], [1, 0, 0]], supports=[tanor.Support(0)], forces=[tanor.Springs([[0, 1]], stiffness=2.0, rest_length=0.0, name="s")])
        simulation = tanor.Simulation(system)
        simulation.add_observable("potential()")
        simulation.add_event("t > -1", do="break", of="s[0]")
        run = tanor.run(simulation, 0.1)
        self.assertEqual(run.observables["potential()"].tolist(), [0.0, 0.0])
        self.assertEqual([each.time for each in run.passages], [0.0])
        stopped = tanor.Simulation(system)
        stopped.add_event("t > -1", do="stop")
        self.assertEqual(tanor.run(stopped, 0.1).times.tolist(), [0.0])

    def test_events_of_one_name_are_refused(self):
        simulation = tanor.Simulation(make_cable(4))
        simulation.add_event("t > 0.1", name="e")
        simulation.add_event("t > 0.2")
        simulation.add_event("t > 0.2", do="stop")
        with self.assertRaisesRegex(tanor.InputError, "two events have the name \"e\""):
            simulation.add_event("t > 0.3", name="e")

    def test_an_event_that_stops_ends_a_run_where_a_state_is_kept(self):
        for event in ({"when": "t > 0.1", "do": "stop"}, {"function": lambda t, r, v: t - 0.1, "stops": True}):
            simulation = tanor.Simulation(make_cable(4))
            simulation.add_event(**event)
            run = tanor.run(simulation, 0.3, 0.1)
            numpy.testing.assert_array_equal(run.times, [0.0, 0.1])
            self.assertEqual(len(tanor.run(simulation, 0.3, 0.1).times), 3)

    def test_options_by_name_scalars_and_groups(self):
        simulation = tanor.Simulation(make_cable(4), rtol=1e-10, method="dop853", threads=1)
        run = tanor.run(simulation, 0.2, 0.1)
        self.assertEqual(run.report.method, "dop853")
        numpy.testing.assert_allclose(run["links"].tension[-1], 0.5 * 9.81 * numpy.array([4, 3, 2, 1]), rtol=1e-9)
        self.assertEqual(run["load(hook)"].shape, (3, 3))
        self.assertLess(len(repr(run)), 300)
        self.assertIn("<svg", run._repr_html_())
        with self.assertRaisesRegex(TypeError, r"no argument 'rtl' \(did you mean rtol\?\)"):
            tanor.Simulation(make_cable(4), rtl=1e-10)
        with self.assertRaisesRegex(KeyError, "load"):
            run["lod(hook)"]

    def test_a_state_of_rest_is_read_by_name(self):
        rest = tanor.find_equilibrium(make_cable(4))
        numpy.testing.assert_allclose(rest["links"].tension, 0.5 * 9.81 * numpy.array([4, 3, 2, 1]), rtol=1e-9)
        numpy.testing.assert_allclose(rest["load(hook)"], [0, 0, -0.5 * 9.81 * 4], atol=1e-9)
        self.assertAlmostEqual(rest["max tension(links)"], 0.5 * 9.81 * 4, 9)
        self.assertEqual(repr(rest["links"]), "Group('links', 4 members)")
        self.assertAlmostEqual(rest["distance(0, 2)"], numpy.linalg.norm(rest.positions[2] - rest.positions[0]), 12)
        self.assertAlmostEqual(rest["2*load(hook).z"], -9.81 * 4, 9)  # any observable, also one that nobody asked for
        with self.assertRaisesRegex(KeyError, "load"):
            rest["lod(hook)"]

    def test_solutions_and_modes_are_read_by_name(self):
        system = make_cable(4)
        rest = tanor.find_equilibrium(system)
        for solution in (tanor.Simulation(system).solution(), tanor.Dynamics(system).solution(system.positions)):
            self.assertAlmostEqual(solution["max tension(links)"], rest["max tension(links)"], 9)
            numpy.testing.assert_allclose(solution["load(hook)"], rest["load(hook)"], atol=1e-9)
        modes = tanor.modes(system, rest.positions)
        for name in ("max tension(links)", "min tension(links)", "load(hook).z"):
            self.assertAlmostEqual(modes[name], rest[name], 9)
        self.assertEqual(len(modes.observables), 3)
        with self.assertRaisesRegex(KeyError, r"did you mean load\(hook\)\?"):
            modes["lod(hook)"]

    def test_what_is_open_pulls_with_nothing_in_modes(self):
        rods = tanor.Rods([[0, 1], [1, 2]], name="links")
        slack = tanor.Rods([[0, 2]], length=5.0, name="stay")
        system = tanor.System([[0, 0, 0], [0, 0, -1], [0, 0, -2]], supports=[tanor.Support(0)], constraints=[rods, slack],
                              forces=[tanor.Gravity((0, 0, -10))])
        rest = tanor.find_equilibrium(system, one_sided={"stay": "at_most"})
        self.assertTrue(rest.open.any(), rest.outcome.what)
        modes = tanor.modes(system, rest.positions, multipliers=rest.multipliers, open=rest.open)
        self.assertAlmostEqual(modes["max tension(links)"], 20, 9)
        self.assertEqual(modes["tension(stay)"], 0)

    def test_members_keep_their_numbers_where_others_are_slack(self):
        for side, asked in (("at_most", {}), (None, {"wires": "at_most"})):
            wires = tanor.Rods([[0, 3], [1, 3], [2, 3]], length=[5.0, 4.5, 5.0], name="wires", side=side)
            system = tanor.System([[-3, 0, 0], [0, 0, 0], [3, 0, 0], [0, 0, -4]], supports=[tanor.Support([0, 1, 2])],
                                  constraints=[wires], forces=[tanor.Gravity((0, 0, -10))])
            rest = tanor.find_equilibrium(system, one_sided=asked)
            swinging = [tanor.modes(system, rest.positions, open=rest.open)] + ([tanor.modes(system, rest.positions)] if side else [])
            for result in (rest, *swinging):
                numpy.testing.assert_allclose(result["wires"].tension, [6.25, 0.0, 6.25], atol=1e-9)
                numpy.testing.assert_allclose(result.multipliers, rest.multipliers, atol=1e-9)
            for modes in swinging:
                self.assertAlmostEqual(modes.omega[0], (10 / 4) ** 0.5, 9)

    def test_a_run_that_the_numbers_end_raises(self):
        system = tanor.System([[0, 0, 0], [1, 0, 0]], velocities=[[0, 0, 0], [-1, 0, 0]], supports=[tanor.Support([0])],
                              constraints=[tanor.Rods([[0, 1]], length="1 - t", name="rod")])
        with self.assertRaises(tanor.Failed) as raised:
            tanor.run(tanor.Simulation(system), 2.0, 0.5)
        self.assertIn("rod", str(raised.exception))
        self.assertGreater(len(raised.exception.trajectory.times), 1)
        self.assertFalse(tanor.run(tanor.Simulation(system), 2.0, check=False).outcome.ok)

    def test_unknown_names_are_input_errors(self):
        simulation = tanor.Simulation(make_cable(2))
        with self.assertRaisesRegex(tanor.InputError, r"did you mean links\?"):
            simulation.add_observable("tension(linsk)")
        with self.assertRaisesRegex(tanor.InputError, "does not break"):
            simulation.add_event(when="t > 1", do="break", of="hook")


if __name__ == "__main__":
    unittest.main()
