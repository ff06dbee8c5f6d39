"""Whoever asks help() is answered, and docs/python.md is true."""

import dataclasses
import importlib.util
import inspect
import os
import pathlib
import pickle
import re
import shutil
import tempfile
import unittest

import tanor


class Help(unittest.TestCase):
    def test_every_public_name_and_member_has_a_text(self):
        silent = []
        for name in tanor.__all__:
            thing = getattr(tanor, name)
            if not (thing.__doc__ or "").strip():
                silent.append(name)
            if not inspect.isclass(thing) or dataclasses.is_dataclass(thing):
                continue
            for member, value in vars(thing).items():
                # The first line of a compiled function's text is its signature.
                text = (getattr(value, "__doc__", None) or "").strip()
                own = text if isinstance(value, property) else text.partition("\n")[2].strip()
                if not member.startswith("_") and (callable(value) or isinstance(value, property)) and not own:
                    silent.append(f"{name}.{member}")
        self.assertEqual(silent, [])

    def test_every_field_of_a_kind_is_told_with_what_it_takes(self):
        untold = []
        for name in tanor.__all__:
            thing = getattr(tanor, name)
            if inspect.isclass(thing) and dataclasses.is_dataclass(thing):
                untold += [f"{name}.{field.name}" for field in dataclasses.fields(thing)
                           if not re.search(rf"^\s*{field.name}\b.*\w", thing.__doc__, re.MULTILINE)]
        self.assertEqual(untold, [])

    def test_no_text_shows_names_of_the_inside(self):
        shown = [name for name in tanor.__all__ if inspect.isclass(getattr(tanor, name))
                 for value in vars(getattr(tanor, name)).values() if "std::" in (getattr(value, "__doc__", None) or "")]
        self.assertEqual(shown, [])

    def test_all_kinds_of_the_library_are_there(self):
        kinds = {thing.kind for thing in vars(tanor).values() if inspect.isclass(thing) and hasattr(thing, "kind")}
        self.assertTrue({"rod", "plane", "sphere", "line", "circle", "angle", "pulley", "linear", "ellipsoid", "helix",
                         "formula", "gravity", "constant", "spring", "drag", "pair", "coulomb", "viscous", "free",
                         "chain_angles", "rigid_body"} <= kinds, kinds)

    def test_classes_are_found_by_pickle(self):
        self.assertIs(pickle.loads(pickle.dumps(tanor.Rods)), tanor.Rods)
        self.assertIs(pickle.loads(pickle.dumps(tanor.Constrainer)), tanor.Constrainer)


class Page(unittest.TestCase):
    def test_arguments_of_observables_and_events_are_told(self):
        page = pathlib.Path(os.environ["TANOR_DOCS"], "python.md").read_text(encoding="utf-8")
        for name in ("add_observable", "add_event"):
            table = re.search(rf"\| argument of `{name}` \|.*?\n\n", page, re.DOTALL)[0]
            signature = getattr(tanor.Simulation, name).__doc__.splitlines()[0]
            self.assertEqual(set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE)), set(re.findall(r"(\w+): ", signature)) - {"self"})

    def test_functions_of_plot_are_told(self):
        page = pathlib.Path(os.environ["TANOR_DOCS"], "python.md").read_text(encoding="utf-8")
        table = re.search(r"\| of `tanor.plot` \|.*?\n\n", page, re.DOTALL)[0]
        told = {name: arguments.split(", ")[1:] for name, arguments in re.findall(r"^\| `(\w+)\((.*?)\)`", table, re.MULTILINE)}
        public = {name: thing for name, thing in vars(tanor.plot).items()
                  if inspect.isfunction(thing) and not name.startswith("_") and name != "picture_of"}
        self.assertEqual(set(told), set(public))
        for name, arguments in told.items():
            self.assertLessEqual(set(arguments), set(inspect.signature(public[name]).parameters), name)

    def test_programs_of_the_page_run(self):
        page = pathlib.Path(os.environ["TANOR_DOCS"], "python.md").read_text(encoding="utf-8")
        programs = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        self.assertGreater(len(programs), 1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for scene in pathlib.Path(os.environ["TANOR_EXAMPLES"]).glob("*.json"):
            shutil.copy(scene, folder.name)
        os.chdir(folder.name)  # some write pictures
        self.addCleanup(os.chdir, "/")
        for number, program in enumerate(programs):
            modules = re.findall(r"^import (\w+)", program, re.MULTILINE)
            if any(importlib.util.find_spec(module) is None for module in modules):
                continue  # matplotlib and pandas may be missing
            with self.subTest(number=number):
                exec(compile(program, f"docs/python.md, program {number + 1}", "exec"), {})


if __name__ == "__main__":
    unittest.main()
