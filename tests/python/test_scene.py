"""A scene and a system are one thing: Scene.system is read, changed and simulated as if it had been written in Python."""

import copy
import json
import os
import pathlib
import pickle
import tempfile
import unittest

import numpy
import tanor

EXAMPLES = pathlib.Path(os.environ["TANOR_EXAMPLES"])


def write(folder: str, scene: dict) -> str:
    path = pathlib.Path(folder) / "scene.json"
    path.write_text(json.dumps({"tanor_scene": 1, **scene}))
    return str(path)


CRANE = {
    "units": {"length": "mm", "force": "N"}, "name": "crane",
    "points": {"positions": [[0, 0, 0], [0, 0, -1], [1.5, 0, 0.5], [2, 0, 2], [0.5, 0, 0]], "masses": [1, 2, 3, 4, 5]},
    "supports": [{"name": "trolley", "points": [0], "motion": {"formula": ["0.1*sin(t)", "0", "0"]}}],
    "constraints": [{"name": "rope", "kind": "rod", "pairs": [[0, 1]], "length": {"formula": "1-0.1*t"}},
                    {"name": "wire", "kind": "formula", "points": [[2]], "equation": "z1-x1^2+1.75"},
                    {"name": "table", "kind": "plane", "points": [3], "normal": [0, 0, 1], "offset": 2}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
               {"kind": "formula", "points": [4], "x": "-x", "y": "sin(t)", "z": "0"}],
    "friction": [{"kind": "coulomb", "at": "table", "coefficient": 0.3}],
    "motion": {"rtol": 1e-11, "start": "project", "t_end": 1}}


class SceneAsSystem(unittest.TestCase):
    def expect_same(self, scene: tanor.Scene, same: "tanor.Scene | tanor.System | None" = None) -> None:
        one = tanor.Simulation(scene)
        other = tanor.Simulation(same or scene.system, scene.motion, scene.solver, scene.t_start)
        for name in ("positions", "accelerations", "multipliers", "reactions"):
            numpy.testing.assert_array_equal(getattr(one.solution(), name), getattr(other.solution(), name))

    def test_every_example_is_the_same_as_its_system(self):
        tried = 0
        for file in sorted(EXAMPLES.glob("*.json")):
            try:
                scene = tanor.Scene(file)
            except tanor.InputError:  # it reads a file that is to be fetched
                continue
            with self.subTest(file.name):
                self.expect_same(scene)
            tried += 1
        self.assertGreater(tried, 5)

    def test_functions_kernels_and_units_are_carried(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = tanor.Scene(write(folder, CRANE))
        self.assertEqual((scene.num_points, scene._repr_html_().count("<circle")), (scene.num_points,) * 2)
        self.expect_same(scene)
        self.assertIn("of a scene file", repr(scene.supports))
        run = tanor.run_scene(scene)
        again = pickle.loads(pickle.dumps(run))
        self.assertEqual(repr(again.system), repr(scene))
        for other in (again.system, again.system.system, pickle.loads(pickle.dumps(scene.system))):
            numpy.testing.assert_array_equal(tanor.run(tanor.Simulation(other, scene.motion), run.times[-1]).positions[-1], run.positions[-1])
            self.expect_same(scene, other)
        end = [tanor.run(tanor.Simulation(each, scene.motion), 1.0).positions[-1] for each in (scene.system, copy.deepcopy(scene.system))]
        numpy.testing.assert_array_equal(*end)
        self.assertEqual(tanor.Simulation(scene.system, scene.motion).observe()[0].unit, "N")

    def test_what_a_scene_holds_is_seen_and_changed(self):
        scene = tanor.Scene(EXAMPLES / "net.json")
        system = scene.system
        self.assertEqual(system.constraints[0].pairs.shape, (760, 2))
        numpy.testing.assert_array_equal(system.masses, 0.1)
        self.assertIn("400 points", repr(scene))
        self.assertLess(len(repr(scene)), 600)
        shown = scene._repr_html_()
        self.assertEqual((shown.count("<circle"), shown.count("<path")), (400, 760))
        self.assertLess(len(tanor.Scene(EXAMPLES / "melt_generated.json")._repr_html_()), 400_000)
        self.assertEqual((scene.motion.method, scene.motion.rtol, scene.t_end), ("dopri5", 1e-6, 0.6))
        system.forces[0].acceleration = (0, 0, -1.62)  # on the moon
        # A flat net falls freely, but for its supports. The scene and its system are one.
        for moon in (system, scene, pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
            numpy.testing.assert_allclose(tanor.Simulation(moon).accelerations[200], (0, 0, -1.62), atol=1e-12)
        scene.masses = 0.2
        scene.motion.method, scene.motion.step = "rk4", 0.01
        self.assertEqual(system.masses, 0.2)
        for moon in (tanor.Simulation(scene), tanor.Simulation(copy.copy(scene))):
            self.assertEqual(moon.report.method, "rk4")
        self.assertEqual(tanor.Simulation(scene, method="rattle").report.method, "rattle")
        self.assertEqual(scene.motion.method, "rk4")
        self.assertEqual(tanor.Scene(scene.file).motion.method, "dopri5")  # the file is as it was

    def test_a_scene_begins_at_its_own_time_and_takes_options_by_name(self):
        with tempfile.TemporaryDirectory() as folder:
            fall = {"points": {"positions": [[0, 0, 0]], "masses": 1}, "motion": {"t_start": -5, "t_end": -3, "output_every": 1},
                    "forces": [{"kind": "formula", "points": [0], "x": "t", "y": "0", "z": "0"}]}
            scene = tanor.Scene(write(folder, fall))
        run = tanor.run_scene(scene)
        numpy.testing.assert_array_equal(run.times, [-5, -4, -3])
        # x'' = t from rest at t = -5
        numpy.testing.assert_allclose(run.positions[:, 0, 0], [t**3 / 6 - 12.5 * t - 125 / 3 for t in run.times], atol=1e-12)
        self.assertEqual(tanor.Simulation(scene, method="rk4", step=0.1).report.method, "rk4")

    def test_options_of_a_scene_stay_beside_those_by_name(self):
        hanging = {"points": {"positions": [[0, 0, 0], [0, 0, -1], [0, 0, -2]], "masses": 1}, "supports": [{"points": [0]}],
                   "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [1, 2]]}],
                   "forces": [{"kind": "gravity", "acceleration": [0, 0, -10]}],
                   "modes": {"count": "all"}, "equilibrium": {"prestress": {"links": 1.0}, "accept": "any"}}
        with tempfile.TemporaryDirectory() as folder:
            scene = tanor.Scene(write(folder, hanging))
        self.assertTrue(tanor.find_equilibrium(scene, max_iterations=20).ok)
        self.assertEqual(tanor.modes(scene, count=2).omega.shape, (2,))
        self.assertEqual(tanor.modes(scene, tolerance=1e-9).omega.shape, (4,))

    def test_a_carried_value_stands_where_it_belongs(self):
        with tempfile.TemporaryDirectory() as folder:
            system = tanor.Scene(write(folder, CRANE)).system
        system.constraints[2].offset = system.supports[0].displacement
        with self.assertRaisesRegex(tanor.InputError, "/constraints/2/offset"):
            tanor.validate(system)


if __name__ == "__main__":
    unittest.main()
