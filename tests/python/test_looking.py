"""What is seen of systems and runs: pictures, tables, notebooks, progress, and reprs that stay short."""

import contextlib
import copy
import importlib.util
import io
import os
import pathlib
import pickle
import subprocess
import sys
import tempfile
import unittest

import numpy
import tanor

from chain import pendulum


def needs(*modules):
    missing = [module for module in modules if importlib.util.find_spec(module) is None]
    return unittest.skipIf(missing, f"without {', '.join(missing)}")


def cable(links: int = 4) -> tanor.System:
    positions = numpy.zeros((links + 1, 3))
    positions[:, 2] = -0.1 * numpy.arange(links + 1)
    return tanor.System(positions, 0.5, supports=[tanor.Support(0, name="hook")], units="si",
                        constraints=[tanor.Rods([[k, k + 1] for k in range(links)], name="links")],
                        forces=[tanor.Gravity((0, 0, -9.81))])


def numbers_of(line) -> numpy.ndarray:
    return numpy.array(line.get_data_3d() if hasattr(line, "get_data_3d") else line.get_data()).T


@needs("matplotlib")
class Plots(unittest.TestCase):
    def test_histories_have_the_names_and_units_of_the_columns(self):
        run = tanor.run(tanor.Simulation(cable()), 0.2, 0.1)
        axes = tanor.plot.histories(run)
        self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()],
                         ["max tension(links) [N]", "min tension(links) [N]",
                          "load(hook).x [N]", "load(hook).y [N]", "load(hook).z [N]"])
        self.assertEqual(axes.get_xlabel(), "t [s]")
        numpy.testing.assert_allclose(axes.lines[4].get_ydata(), 3 * [-4 * 0.5 * 9.81])
        (line,) = tanor.plot.histories(run, "load(hook).z").lines
        numpy.testing.assert_array_equal(line.get_ydata(), run["load(hook)"][:, 2])

    def test_histories_of_groups_and_members_are_tensions(self):
        run = tanor.run(tanor.Simulation(cable()), 0.2, 0.1)
        lines = tanor.plot.histories(run, ["links", "links[3]"]).lines
        self.assertEqual([line.get_label() for line in lines], [f"links[{k}] [N]" for k in (0, 1, 2, 3, 3)])
        for line, k in zip(lines, (0, 1, 2, 3, 3)):
            numpy.testing.assert_array_equal(line.get_ydata(), run["links"].tension[:, k])

    def test_histories_say_how_many_they_leave_out(self):
        simulation = tanor.Simulation(cable(20))
        simulation.add_observable("tension(links)", name="each")
        legend = tanor.plot.histories(tanor.run(simulation, 0.1), ["each"]).get_legend().get_texts()
        self.assertEqual((legend[3].get_text(), legend[-1].get_text()), ("each: links[3] [N]", "and 8 more of each"))

    def test_tensions_are_counted_along_a_run_and_at_rest(self):
        for result in (tanor.run(tanor.Simulation(cable()), 0.2), tanor.find_equilibrium(cable())):
            axes = tanor.plot.tensions(result, "links", bins=4)
            self.assertEqual([bar.get_height() for bar in axes.patches], [1, 1, 1, 1])
            self.assertAlmostEqual(axes.patches[0].get_x(), 0.5 * 9.81, 9)
        self.assertEqual(axes.get_xlabel(), "tension of links [N]")
        run = tanor.run(tanor.Simulation(cable()), 0.2)
        self.assertEqual(tanor.plot.tensions(run, "links").get_xlabel(), "tension of links at t = 0.2 s [N]")
        coils = tanor.System([[0, 0, 0], [0, 0, -1]], supports=[tanor.Support(0)], forces=[tanor.Springs([[0, 1]], stiffness=1, name="coil")])
        for plot in (tanor.plot.tensions, tanor.plot.histories):
            plot(tanor.run(tanor.Simulation(coils), 0.2), "coil")
        run.system.units = "none"
        self.assertEqual(tanor.plot.tensions(run, "links").get_xlabel(), "tension of links at t = 0.2")

    def test_a_mode_has_the_units_of_its_system(self):
        rest = tanor.find_equilibrium(cable())
        axes = tanor.plot.modes(tanor.modes(cable(), rest.positions))
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            self.assertRegex(label, r"^[xyz] \[m\]$")
        self.assertRegex(axes.get_legend().get_texts()[1].get_text(), r"^omega = [0-9.]+ rad/s$")

    def test_a_mode_is_drawn_in_its_plane(self):
        # A wire along y swings in z, where it is less stiff, and then in x: each mode lies in a plane.
        wire = tanor.System([[0, k, 0] for k in range(5)], supports=[tanor.Support([0, 4])],
                            constraints=[tanor.Rods([[k, k + 1] for k in range(4)], name="wire")],
                            forces=[tanor.Potential([[2]], kernel="0.5*x1^2")])
        modes = tanor.modes(wire, prestress={"wire": 1.0}, count="all")
        self.assertTrue(modes.ok, modes.outcome.what)
        self.assertEqual(numpy.argmax(numpy.ptp(modes.shapes[0], axis=0)), 2)
        axes = tanor.plot.modes(modes, 0)
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("y", "z"))
        rods, rest, moved_rods, moved = [numbers_of(line) for line in axes.lines]
        numpy.testing.assert_array_equal(rest, [[k, 0] for k in range(5)])
        shape = modes.shapes[0][:, 1:]
        numpy.testing.assert_allclose(moved, rest + 0.4 / abs(shape).max() * shape, atol=1e-12)  # a tenth of the length
        numpy.testing.assert_array_equal(moved_rods[[0, 1]], moved[[0, 1]])
        self.assertTrue(numpy.isnan(moved_rods[2]).all())
        self.assertEqual(len(rods), 3 * 4)
        self.assertEqual(axes.get_legend().get_texts()[1].get_text(), f"omega = {modes.omega[0]:.6g}")

    def test_a_mode_that_lies_in_no_plane_is_drawn_in_space(self):
        sideways = tanor.System([[0, 0, 0], [0.4, 0.8, 0], [0.8, 0, 0]], 1.0, supports=[tanor.Support([0, 2])],
                                constraints=[tanor.Rods([[0, 1], [1, 2]])], forces=[tanor.Gravity((0, 0, -9.81))])
        rest = tanor.find_equilibrium(sideways)
        axes = tanor.plot.modes(tanor.modes(sideways, rest.positions, multipliers=rest.multipliers), scale=0.01)
        self.assertEqual(axes.name, "3d")
        numpy.testing.assert_allclose(numbers_of(axes.lines[1]), rest.positions)

    def test_error_against_time_is_that_of_the_file(self):
        file = pathlib.Path(os.environ["TANOR_EXAMPLES"]).parent / "bench/results/error_time/net/error_time.csv"
        axes = tanor.plot.error_time(file)
        curves = {line.get_label(): numbers_of(line) for line in axes.lines}
        self.assertEqual(list(curves), ["rattle", "rattle4", "rattle6", "rk4", "dopri5", "dop853", "taylor"])
        numpy.testing.assert_array_equal(curves["rattle"][0], [0.020720593, 1.5143660854075131e-05])
        self.assertEqual((axes.get_xscale(), axes.get_yscale()), ("log", "log"))
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("seconds", "error"))

    def test_tables_of_errors_have_units_now_and_before(self):
        new = "method,wall_s,error,trouble,unit_of_length,unit_of_time\nrk4,0.5,1e-3,,angstrom,fs\nrk4,1,,too long,angstrom,fs\n"
        old = "method,wall_s,error_m,trouble\nrk4,0.5,1e-3,\n"  # of 0.2
        for text, label in ((new, "error [angstrom]"), (old, "error [m]")):
            with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
                file.write(text)
                file.flush()
                axes = tanor.plot.error_time(file.name)
            self.assertEqual(axes.get_ylabel(), label)
            numpy.testing.assert_array_equal(numbers_of(axes.lines[0]), [[0.5, 1e-3]])


class Tables(unittest.TestCase):
    @needs("pandas")
    def test_pandas_has_a_column_for_each_number(self):
        run = tanor.run(tanor.Simulation(cable()), 0.2, 0.1)
        table = run.to_pandas()
        self.assertEqual(list(table.columns), ["max tension(links)", "min tension(links)",
                                               "load(hook).x", "load(hook).y", "load(hook).z"])
        numpy.testing.assert_array_equal(table.index, run.times)
        numpy.testing.assert_array_equal(table["load(hook).z"], run["load(hook)"][:, 2])
        self.assertEqual((table.index.name, table.attrs["units"]["load(hook)"]), ("t", "N"))

    def test_a_column_of_an_observable_has_a_name(self):
        simulation = tanor.Simulation(cable())
        simulation.add_observable("each tension(links)", name="pull")
        run = tanor.run(simulation, 0.2, 0.1)
        numpy.testing.assert_array_equal(run["pull: links[2]"], run["pull"][:, 2])
        self.assertAlmostEqual(simulation["load(hook).z"], -4 * 0.5 * 9.81, 9)
        with self.assertRaisesRegex(KeyError, r"did you mean load\(hook\)\?"):
            run["lod(hook)"]

    def test_a_run_may_be_asked_for_at_instants(self):
        instants = numpy.array([0.0, 0.05, 0.2])
        run = tanor.run(tanor.Simulation(pendulum()), instants)
        numpy.testing.assert_array_equal(run.times, instants)
        for wrong in ([0.2, 0.1], [-0.1, 0.1]):
            with self.assertRaisesRegex(ValueError, "t_end: the instants must increase"):
                tanor.run(tanor.Simulation(pendulum()), wrong)


class Reprs(unittest.TestCase):
    def test_all_of_them_stay_short(self):
        n = 32000
        positions = numpy.zeros((n, 3))
        positions[:, 2] = -0.1 * numpy.arange(n)
        pairs = numpy.column_stack([numpy.arange(n - 1), numpy.arange(1, n)])
        system = tanor.System(positions, 0.1, supports=[tanor.Support(0)], constraints=[tanor.Rods(pairs, name="links")],
                              forces=[tanor.Gravity((0, 0, -9.81))])
        simulation = tanor.Simulation(system, method="dop853")
        simulation.add_observable("tension(links)", name="each")
        run = tanor.run(simulation, 1e-4)
        rest = tanor.find_equilibrium(system)
        everything = {"system": system, "simulation": simulation, "solution": simulation.solution(), "run": run,
                      "observed": simulation.observe()[-1], "certificate": simulation.certify(), "plan": simulation.plan,
                      "group": run["links"], "rods": system.constraints[0], "rest": rest}
        for name, thing in everything.items():
            self.assertLess(len(repr(thing)), 1000, name)
        self.assertEqual(repr(simulation), "Simulation('system', 32000 points, t = 0.0001, dop853)")
        self.assertIn("positions=<32000 x 3>", repr(rest))
        for thing in (system, simulation, run, rest):
            self.assertLess(len(thing._repr_html_()), 400_000)

    def test_a_system_tells_masses_supports_and_groups(self):
        self.assertEqual(repr(cable()), "System('system': 5 points; masses 0.5, 2 in all; supports hook (1 point); "
                         "constraints links (4 rods); forces gravity0)")
        sphere = tanor.UserConstraints([[0]], kernel="x1^2 + y1^2 + z1^2 - 1", name="ball")
        system = tanor.System(numpy.eye(3), [1, 2, 3], supports=[tanor.Support([2])], name="odd",
                              constraints=[tanor.Rods([[0, 1]]), sphere, tanor.Planes([0], normal=(1, 0, 0))],
                              forces=[tanor.Springs([[0, 1], [1, 2]], stiffness=1.0), tanor.FormulaForce([0, 1], kernel=("0", "0", "t"))],
                              friction=[tanor.Coulomb(["plane2"], coefficient=0.3, velocity=0.1)])
        self.assertEqual(repr(system), "System('odd': 3 points; masses 1 to 2, 3 in all; supports support0 (1 point); "
                         "constraints rod0 (1 rod), ball (1 tuple), plane2 (1 point); forces spring0 (2 springs), formula1 (2 points); "
                         "friction coulomb0 (1 guide))")
        many = tanor.System([[0, 0, 0]], "heavy", forces=[tanor.Gravity((0, 0, -1)) for _ in range(9)])  # not checked yet
        self.assertEqual(repr(many), "System('system': 1 point; forces gravity0, gravity1, gravity2, gravity3, gravity4, gravity5, 3 more)")

    def test_one_of_a_kind_is_no_plural(self):
        system = tanor.System([[0, 0, 0]], forces=[tanor.Gravity((0, 0, -1))])
        run = tanor.run(tanor.Simulation(system, method="rk4", step=0.1), 0.0)
        self.assertEqual(repr(tanor.Simulation(system, method="rk4", step=0.1)), "Simulation('system', 1 point, t = 0, rk4)")
        self.assertTrue(repr(run).startswith("Trajectory(1 time to t = 0, 1 point, ok"), repr(run))
        self.assertEqual(repr(tanor.Simulation(cable(1))["links"]), "Group('links', 1 member)")
        self.assertEqual(repr(tanor.Dynamics(system)), "Dynamics(1 point, 0 equations)")
        self.assertEqual(repr(tanor.InverseDynamics(cable(1))), "InverseDynamics(2 points, 1 equation)")

    def test_pictures_for_notebooks_show_points_and_rods(self):
        system = cable()
        rest = tanor.find_equilibrium(system)
        things = [system, tanor.Simulation(system), tanor.run(tanor.Simulation(system), 0.1), rest,
                  tanor.modes(system, rest.positions, multipliers=rest.multipliers)]
        for thing in things:
            shown = thing._repr_html_()
            self.assertEqual((shown.count("<circle"), shown.count("<path")), (5, 4), type(thing).__name__)
            self.assertTrue(shown.startswith(f"<p>{type(thing).__name__}("), shown[:40])

    def test_groups_of_one_instant_are_asked_by_name(self):
        system = cable()
        rest = tanor.find_equilibrium(system)
        expected = 0.5 * 9.81 * numpy.array([4, 3, 2, 1])
        for thing in (tanor.Simulation(system), tanor.Simulation(system).solution(), rest,
                      tanor.Dynamics(system).solution(system.positions), tanor.modes(system, rest.positions, multipliers=rest.multipliers)):
            numpy.testing.assert_allclose(thing["links"].tension, expected, rtol=1e-9)
            self.assertIs(thing.system, system)
            self.assertIn("links", thing._ipython_key_completions_())


class Progress(unittest.TestCase):
    def run_with(self, stream) -> str:
        with contextlib.redirect_stderr(stream):
            tanor.run(tanor.Simulation(pendulum(), method="rattle", step=0.01), 1.0, 0.25, progress=True)
        return stream.getvalue()

    def test_a_terminal_has_one_line(self):
        terminal = io.StringIO()
        terminal.isatty = lambda: True
        said = self.run_with(terminal)
        self.assertEqual(said.count("\n"), 1)
        self.assertRegex(said.split("\r")[-1], r"^100 %, 100 steps of rattle, 0 s left *\n$")
        self.assertGreater(said.count("\r"), 50)

    def test_a_file_has_a_line_for_each_tenth(self):
        lines = self.run_with(io.StringIO()).splitlines()
        self.assertEqual([line[:5] for line in lines], [f"{10 * k:3d} %" for k in range(11)])

    def test_a_run_that_is_ended_ends_the_line(self):
        terminal = io.StringIO()
        terminal.isatty = lambda: True
        system = tanor.System([[0, 0, 0], [1, 0, 0]], velocities=[[0, 0, 0], [-1, 0, 0]], supports=[tanor.Support(0)],
                              constraints=[tanor.Rods([[0, 1]], length="1 - t")])
        with contextlib.redirect_stderr(terminal), self.assertRaises(tanor.Failed):
            tanor.run(tanor.Simulation(system), 2.0, progress=True)
        self.assertTrue(terminal.getvalue().endswith("\n"))


class Copies(unittest.TestCase):
    def test_a_run_is_kept_by_pickle(self):
        run = tanor.run(tanor.Simulation(cable()), 0.2, 0.1)
        for again in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
            numpy.testing.assert_array_equal(again["links"].tension, run["links"].tension)
            self.assertEqual((again.report.steps, again.report.energy.start), (run.report.steps, run.report.energy.start))
            self.assertEqual((again.outcome.ok, repr(again)), (True, repr(run)))

    def test_a_failure_comes_out_of_another_process(self):
        rest = tanor.find_equilibrium(cable())
        failed = pickle.loads(pickle.dumps(tanor.Failed(rest.outcome, tanor.run(tanor.Simulation(cable()), 0.1))))
        self.assertEqual((failed.outcome.status, len(failed.trajectory.times)), ("ok", 2))


@needs("nbclient", "ipykernel")
class Notebooks(unittest.TestCase):
    def test_a_notebook_shows_pictures_and_progress(self):
        import nbclient
        from nbformat import v4

        cells = ["import tanor\nscene = tanor.Scene('pendulum.json')\nscene",
                 "run = tanor.run_scene(scene, progress=True)\nrun",
                 "import matplotlib\ntanor.plot.histories(run).get_xlabel()"]
        book = v4.new_notebook(cells=[v4.new_code_cell(cell) for cell in cells])
        nbclient.NotebookClient(book, kernel_name="python3", resources={"metadata": {"path": os.environ["TANOR_EXAMPLES"]}}).execute()
        scene, run, plot = [cell.outputs for cell in book.cells]
        self.assertIn("<svg", scene[0].data["text/html"])
        said = "".join(each.text for each in run if each.output_type == "stream" and each.name == "stdout")
        self.assertRegex(said, r"100 %, \d+ steps of")
        self.assertFalse([each for each in run if each.output_type == "stream" and each.name == "stderr"])
        self.assertEqual(run[-1].data["text/html"].count("<path"), 1)
        self.assertIn("Trajectory(", run[-1].data["text/plain"])
        self.assertEqual(plot[-1].data["text/plain"], "'t [s]'")


class Numpy(unittest.TestCase):
    def test_what_is_no_system_or_run_is_told(self):
        simulation = tanor.Simulation(pendulum())
        for call, error, said in (
                (lambda: tanor.Simulation("net.json"), TypeError, "found 'net.json', wanted a System or a Scene"),
                (lambda: tanor.run("net.json", 1.0), TypeError, "found 'net.json', wanted a Simulation"),
                (lambda: tanor.Simulation(tanor.System([[0, 0, 0]], supports=[0])), tanor.InputError, "/supports/0: found 0, wanted a Support"),
                (lambda: tanor.run(simulation, -1.0), ValueError, "t_end: -1.0 lies before"),
                (lambda: tanor.run(simulation, 1.0, every=-0.1), ValueError, "every: -0.1 is negative"),
                (lambda: tanor.run(simulation, 0.0)[0], KeyError, "there are t,")):
            with self.assertRaisesRegex(error, said):
                call()
        for wrong in (None, tanor.Support(0), [0]):  # its text stands before it is checked
            self.assertIn("System('system': 1 point", repr(tanor.System([[0, 0, 0]], supports=wrong)))

    def test_numbers_of_numpy_broadcast(self):
        for masses in (numpy.float32(2), numpy.int64(2), numpy.array(2.0), [2, 2]):
            system = tanor.System([[0, 0, 0], [1, 0, 0]], masses, velocities=numpy.array([0, 0, 1]), forces=[tanor.Gravity((0, 0, -1))])
            simulation = tanor.Simulation(system)
            numpy.testing.assert_array_equal(simulation.velocities, [[0, 0, 1], [0, 0, 1]])
            self.assertEqual(simulation.report.energy.start, 0.5 * 4)
        with self.assertRaisesRegex(tanor.InputError, "/masses.*wanted a number"):
            tanor.Simulation(tanor.System([[0, 0, 0]], "heavy"))
        with self.assertRaisesRegex(tanor.InputError, "/velocities"):
            tanor.Simulation(tanor.System([[0, 0, 0]], velocities=[0, 1]))

    def test_numpy_2_is_refused_where_it_would_be_read_wrongly(self):
        if b"needs numpy 1" not in pathlib.Path(tanor._core.__file__).read_bytes():
            self.skipTest("built with a pybind11 that knows numpy 2")
        program = "import numpy; numpy.__version__ = '2.1.0'; import tanor"
        found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        self.assertIn("ImportError: this build of tanor needs numpy 1, found numpy 2.1.0", found.stderr)

    def test_dynamics_reads_lists_slices_and_whole_numbers(self):
        dynamics = tanor.Dynamics(pendulum())
        states = numpy.zeros((2, 6))
        states[1, 0] = 1
        for positions in ([[0, 0, 0], [1, 0, 0]], states[:, :3], numpy.asfortranarray(states[:, :3]), states[:, :3].astype(int)):
            numpy.testing.assert_allclose(dynamics.solution(positions).accelerations, [[0, 0, 0], [0, 0, -9.81]], atol=1e-14)
        with self.assertRaisesRegex(ValueError, r"positions: found the shape \[1, 3\], wanted \[2, 3\]"):
            dynamics.solution([[0, 0, 0]])
        with self.assertRaisesRegex(TypeError, "positions: found str"):
            dynamics.solution("here")

    def test_dynamics_takes_scalars_and_scenes(self):
        system = pendulum()
        system.masses = 3.0
        self.assertEqual(tanor.Dynamics(system).num_points, 2)
        scene = tanor.Scene(os.path.join(os.environ["TANOR_EXAMPLES"], "pendulum.json"))
        self.assertTrue(tanor.Dynamics(scene).solution(scene.system.positions).ok)

    def test_a_misspelt_field_is_no_field(self):
        for thing, name in ((pendulum(), "mass"), (tanor.Rods([[0, 1]]), "lenght"), (tanor.MotionOptions(), "rtl")):
            with self.assertRaisesRegex(AttributeError, name):
                setattr(thing, name, 1.0)

    def test_a_misspelt_argument_is_told_with_what_is_meant(self):
        scene = os.path.join(os.environ["TANOR_EXAMPLES"], "pendulum.json")
        simulation = tanor.Simulation(pendulum())
        misspelt = [
            (lambda: tanor.System([[0, 0, 0]], mases=1.0), "System has no argument 'mases' (did you mean masses?)"),
            (lambda: tanor.Rods([[0, 1]], lenght=1.0), "Rods has no argument 'lenght' (did you mean length?)"),
            (lambda: tanor.MotionOptions(rtoll=1.0), "MotionOptions has no argument 'rtoll' (did you mean rtol?)"),
            (lambda: tanor.Formula("t", constnts={}), "Formula has no argument 'constnts' (did you mean constants?)"),
            (lambda: tanor.run(simulation, 1.0, evry=0.1), "run has no argument 'evry' (did you mean every?)"),
            (lambda: tanor.run_scene(scene, progres=True), "run_scene has no argument 'progres' (did you mean progress?)"),
            (lambda: tanor.Scene(scene, tend=1.0), "Scene has no argument 'tend' (did you mean t_end?)"),
            (lambda: tanor.Simulation(pendulum(), rtoll=1e-6), "Simulation has no argument 'rtoll' (did you mean rtol?)"),
            (lambda: tanor.modes(pendulum(), cuont=3), "modes has no argument 'cuont' (did you mean count?)"),
            (lambda: simulation.add_observable("t", evry_step=True), "add_observable has no argument 'evry_step' (did you mean every_step?)"),
            (lambda: simulation.add_event(stop=True), "add_event has no argument 'stop' (did you mean stops?)"),
            (lambda: tanor.plot.tensions(simulation, "rods", bin=3), "tensions has no argument 'bin' (did you mean bins?)"),
            (lambda: tanor.Gravity((0, 0, 1), colour="red"), "Gravity has no argument 'colour' (it has acceleration, name)"),
        ]
        for call, expected in misspelt:
            with self.assertRaises(TypeError) as raised:
                call()
            self.assertEqual(str(raised.exception), expected)

        def fail(report):
            raise TypeError("of the caller")

        with self.assertRaisesRegex(TypeError, "^of the caller$"):
            tanor.run(simulation, 1.0, progress=fail)

    def test_options_of_rest_and_modes_stand_by_name(self):
        rest = tanor.find_equilibrium(cable(), force_tolerance=1e-13, threads=1)
        modes = tanor.modes(cable(), rest.positions, count=3, multipliers=rest.multipliers)
        self.assertEqual(modes.omega.shape, (3,))
        with self.assertRaisesRegex(tanor.InputError, "/equilibrium/force_tolerance"):
            tanor.find_equilibrium(cable(), force_tolerance=-1.0)
        with self.assertRaisesRegex(tanor.InputError, "no force has the name 'wind'"):
            tanor.find_buckling(cable(), loads="wind")


if __name__ == "__main__":
    unittest.main()
