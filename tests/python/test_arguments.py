"""Wrong arguments are told in words: which one, what was found, what is wanted; nothing is said in those of the binding."""

import importlib.util
import os
import pickle
import unittest

import numpy
import tanor

EXAMPLES = os.environ["TANOR_EXAMPLES"]
SCENE = os.path.join(EXAMPLES, "pendulum.json")


def cable(**changed) -> tanor.System:
    system = tanor.System([[0, 0, -0.1 * k] for k in range(5)], 0.5, supports=[tanor.Support(0, name="hook")],
                          constraints=[tanor.Rods([[k, k + 1] for k in range(4)], name="links")],
                          forces=[tanor.Gravity((0, 0, -9.81), name="weight")])
    for name, value in changed.items():
        setattr(system, name, value)
    return system


has_plots = importlib.util.find_spec("matplotlib") is not None
if has_plots:
    from matplotlib import pyplot


class Arguments(unittest.TestCase):
    def expect(self, error, wanted):
        for call, said in wanted:
            with self.subTest(said), self.assertRaises(error) as raised:
                call()
            if isinstance(raised.exception, KeyError):
                self.assertEqual(raised.exception.args[0], said)
            else:
                self.assertEqual(str(raised.exception), said)

    def test_options_that_stand_alone_are_told_where_they_belong(self):
        options, motion = ", wanted MotionOptions, or its fields by name, method=...", "/motion: found "
        self.expect(tanor.InputError, [
            (lambda: tanor.Simulation(cable(), "dopri5"), motion + "'dopri5'" + options),
            (lambda: tanor.Simulation(cable(), "dopri5", rtol=1e-8), motion + "'dopri5'" + options),
            (lambda: tanor.Simulation(cable(), {"method": "rk4"}), motion + "{'method': 'rk4'}" + options),
            (lambda: tanor.Simulation(cable(), tanor.SolverOptions()).time, motion + repr(tanor.SolverOptions())[:77] + "..." + options),
            (lambda: tanor.Dynamics(cable(), "sparse"), "/solver: found 'sparse', wanted SolverOptions, or its fields by name, form=..."),
            (lambda: tanor.find_equilibrium(cable(), "newton"), "/equilibrium: found 'newton', wanted EquilibriumOptions, or its fields by name, method=..."),
            (lambda: tanor.modes(cable(), None, 4), "/modes: found 4, wanted ModesOptions, or its fields by name, count=..."),
            (lambda: tanor.find_buckling(cable(), "weight"), "/buckling: found 'weight', wanted BucklingOptions, or its fields by name, loads=...")])

    def test_buckling_asks_for_its_loads(self):
        self.expect(tanor.InputError, [
            (lambda: tanor.find_buckling(cable()), '/buckling/loads: none are named, wanted are those of the forces that grow, loads="weight"')])

    def test_arrays_fit_the_number_of_points(self):
        self.expect(tanor.InputError, [
            (lambda: tanor.Simulation(cable(masses=[1.0, 2.0, 3.0])), "/masses: found [1.0, 2.0, 3.0], wanted 5 numbers, or one for all points"),
            (lambda: tanor.Simulation(cable(masses=numpy.ones((5, 1)))), "/masses: found <5 x 1>, wanted a list of numbers"),
            (lambda: tanor.Simulation(cable(velocities=numpy.zeros((4, 3)))), "/velocities: found <4 x 3>, wanted numbers [5, 3], or [3] for all points"),
            (lambda: tanor.Simulation(cable(positions=numpy.zeros((5, 2)))), "/positions: found <5 x 2>, wanted numbers [n, 3]"),
            (lambda: tanor.Simulation(cable(positions="here")), "/positions: found 'here', wanted numbers [n, 3]"),
            (lambda: tanor.Constrainer([1, 1], tanor.Rods([[0, 1]]), numpy.zeros((2, 3))), "/constraints: found Rods(pairs=[[0, 1]]), wanted a list of constraints")])

    def test_functions_of_python_and_compiled_ones_tell_the_argument(self):
        simulation = tanor.Simulation(cable())
        self.expect(TypeError, [
            (lambda: tanor.run(simulation, "x"), "run: t_end: found 'x', wanted a number or a list of numbers"),
            (lambda: tanor.run(simulation, [[1], [2, 3]]), "run: t_end: found [[1], [2, 3]], wanted a number or a list of numbers"),
            (lambda: tanor.run(simulation, 1.0, "0.1"), "run: every: found '0.1', wanted a number"),
            (lambda: tanor.run(simulation, 1.0, numpy.zeros(3)), "run: every: found array([0., 0., 0.]), wanted a number"),
            (lambda: tanor.run(simulation), "run: missing a required argument: 't_end' (it has simulation, t_end, every, progress, check)"),
            (lambda: tanor.run("x", 1.0), "run: simulation: found 'x', wanted a Simulation (run_scene takes a Scene or a file)"),
            (lambda: tanor.run_scene(5), "run_scene: scene: found 5, wanted a Scene or a text or a path"),
            (lambda: tanor.Simulation(), "Simulation: missing a required argument: 'system' (it has system, motion, solver, t_start)"),
            (lambda: tanor.Simulation(cable(), t_start="now"), "Simulation: t_start: found 'now', wanted a number or None"),
            (lambda: simulation.advance_to("x"), "advance_to: t_end: found 'x', wanted a number"),
            (lambda: simulation.add_observable(5), "add_observable: what: found 5, wanted a text"),
            (lambda: simulation.add_observable("t", "mine"), "add_observable: too many positional arguments (it has what, name=..., every_step=..., unit=...)"),
            (lambda: simulation.add_event("t > 1", stops="yes"), "add_event: stops: found 'yes', wanted True or False"),
            (lambda: simulation.restore("x"), "restore: saved: found 'x', wanted bytes"),
            (lambda: tanor.validate(cable(), "now"), "validate: time: found 'now', wanted a number"),
            (lambda: tanor.Scene(SCENE, "rk4"), "Scene: too many positional arguments (it has file, method=..., step=..., max_step=..., rtol=..., atol=..., t_end=..., threads=...)")])
        # What is raised inside stays as it is.
        with self.assertRaisesRegex(TypeError, "^of the caller, incompatible$"):
            simulation.advance_to(1.0, lambda report: (_ for _ in ()).throw(TypeError("of the caller, incompatible")))

    def test_a_class_accepts_what_numpy_has(self):
        simulation = tanor.Simulation(cable(), rtol=numpy.float32(1e-6), threads=numpy.int64(1))
        run = tanor.run(simulation, numpy.float64(0.2), every=numpy.array(0.1), progress=None, check=numpy.bool_(True))
        self.assertEqual(len(run.times), 3)
        self.assertEqual(tanor.run(simulation, (0.3, 0.4)).times[-1], 0.4)

    @unittest.skipUnless(has_plots, "without matplotlib")
    def test_things_that_are_no_run_and_instants_that_are_no_outputs(self):
        run = tanor.run(tanor.Simulation(cable()), 0.2, 0.05)
        rest = tanor.find_equilibrium(cable())
        modes = tanor.modes(cable(), rest.positions, multipliers=rest.multipliers)
        plot = tanor.plot
        self.expect(TypeError, [
            (lambda: plot.tensions("x", "links"), "tensions: run: found 'x', wanted a Trajectory or an EquilibriumResult or a Modes or a Solution or a Simulation (run_scene takes a Scene or a file)"),
            (lambda: plot.tensions(run, 0), "tensions: group: found 0, wanted a text"),
            (lambda: plot.tensions(run, "links", "end"), "tensions: time: found 'end', wanted a number or None"),
            (lambda: plot.histories(3), "histories: run: found 3, wanted a Trajectory"),
            (lambda: plot.histories(run, 3), "histories: names: found 3, wanted a text or a list of texts or None"),
            (lambda: plot.modes(rest.ok), "modes: result: found True, wanted a Modes"),
            (lambda: run["links"]["a"], "links['a']: members have numbers, 0 to 3")])
        self.expect(ValueError, [
            (lambda: plot.tensions(run, "links", time=0.07), "tensions: time: there is no output at 0.07, the nearest one is at 0.05"),
            (lambda: plot.tensions(run, "links", time=7), "tensions: time: there is no output at 7, the nearest one is at 0.2"),
            (lambda: plot.tensions(run, "links", time=float("nan")), "tensions: time: there is no output at nan, the nearest one is at 0"),
            (lambda: plot.tensions(rest, "links", time=1.0), "tensions: time: EquilibriumResult is of one instant")])
        self.expect(IndexError, [
            (lambda: plot.modes(modes, 99), f"modes: number: there are {len(modes.omega)} modes, counted from 0, found 99"),
            (lambda: run["links"][4], "links has 4 members, counted from 0")])
        self.expect(KeyError, [
            (lambda: cable()["lnks"], "lnks: there are weight, hook, links; did you mean links?"),
            (lambda: run["links[12]"], "links[12]: links has 4 members, counted from 0"),
            (lambda: plot.tensions(run, "lnks"), "lnks: there are t, max tension(links), min tension(links), load(hook), links; did you mean links?")])

    @unittest.skipUnless(has_plots, "without matplotlib")
    def test_plots_say_what_they_cannot_draw(self):
        run, plot = tanor.run_scene(os.path.join(EXAMPLES, "breaking_rod.json")), tanor.plot
        self.expect(ValueError, [(lambda: plot.tensions(run, "rod"), f"tensions: no tension of rod at t = {run.times[-1]:g} s is known")])
        with self.assertRaisesRegex(ValueError, "no table of tanor error-time"):
            plot.error_time(os.path.join(EXAMPLES, "..", "tests", "data", "path.csv"))

    def test_systems_that_are_not_valid_are_looked_at(self):
        tanor.System([[0, 0, 0]], constraints=[tanor.Rods([[0, 7]])])._repr_html_()
        self.assertIn("0 points", repr(tanor.System(5)))

    @unittest.skipUnless(has_plots, "without matplotlib")
    def test_reports_that_were_pickled_are_drawn(self):
        modes = tanor.modes(cable(), tanor.find_equilibrium(cable()).positions)
        copied = pickle.loads(pickle.dumps(modes))
        self.assertEqual(len(tanor.plot.modes(copied).lines), len(tanor.plot.modes(modes).lines))

    @unittest.skipUnless(has_plots, "without matplotlib")
    def test_a_time_of_a_histogram_is_an_instant_of_the_run(self):
        system = cable(velocities=[[0.5 * k, 0, 0] for k in range(5)])  # it swings
        run = tanor.run(tanor.Simulation(system), 0.2, 0.05)
        for k, time in enumerate(run.times):
            given = pyplot.subplots()[1]
            axes = tanor.plot.tensions(run, "links", time=time, bins=7, axes=given)
            self.assertIs(axes, given)
            wanted, edges = numpy.histogram(run["links"].tension[k], 7)
            self.assertEqual([bar.get_height() for bar in axes.patches], list(wanted))
            self.assertAlmostEqual(axes.patches[0].get_x(), edges[0], 9)
            self.assertEqual(axes.get_xlabel(), f"tension of links at t = {time:g}")

    def test_what_cannot_be_set_is_told_and_what_is_meant(self):
        scene, simulation = tanor.Scene(SCENE), tanor.Simulation(cable())
        self.expect(AttributeError, [
            (lambda: setattr(scene, "rtol", 1e-3), "Scene has no attribute 'rtol' (did you mean motion.rtol?)"),
            (lambda: setattr(scene, "threads", 2), "Scene has no attribute 'threads' (did you mean solver.threads?)"),
            (lambda: setattr(scene, "tend", 1), "Scene has no attribute 'tend' (did you mean t_end?)"),
            (lambda: setattr(scene, "output_every", 1), "Scene.output_every cannot be set: s; 0: start and end only. `run` takes another "
             "one, run(Simulation(scene), t_end, every=0.1)"),
            (lambda: setattr(simulation, "time", 1), "Simulation.time cannot be set: s"),
            (lambda: setattr(cable(), "mass", 1), "System has no attribute 'mass' (did you mean masses?)"),
            (lambda: setattr(tanor.Rods([[0, 1]]), "lenght", 1), "Rods has no attribute 'lenght' (did you mean length?)")])

    def test_the_end_of_a_scene_may_be_set(self):
        scene = tanor.Scene(SCENE)
        scene.masses = [1.0, 2.0]
        scene.t_end = 3
        self.assertEqual(scene.t_end, 3.0)
        self.assertEqual(tanor.run_scene(scene).times[-1], 3.0)
        for wrong, said in ((-1, "t_end: found number -1, wanted a time after t_start = 0"), ("x", "t_end: found 'x', wanted a number")):
            with self.assertRaises(tanor.InputError) as raised:
                scene.t_end = wrong
            self.assertEqual(str(raised.exception), said)
        self.assertEqual((scene.t_end, list(scene.masses)), (3.0, [1.0, 2.0]))
        scene.t_end = None  # that of the file
        self.assertEqual(scene.t_end, 10.0)
        self.expect(tanor.InputError, [
            (lambda: tanor.run_scene("nothing.json"), "nothing.json cannot be read: No such file or directory"),
            (lambda: tanor.Scene(SCENE, rtol="small"), "rtol: found 'small', wanted a number"),
            (lambda: tanor.Scene(SCENE, t_end=-1), "t_end: found number -1, wanted a time after t_start = 0")])


if __name__ == "__main__":
    unittest.main()
