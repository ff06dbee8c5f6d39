"""The stubs that the build writes say what the package has."""

import ast
import dataclasses
import inspect
import pathlib
import re
import unittest

import tanor

TEXT = pathlib.Path(tanor.__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
STUBS = {node.name: node for node in ast.parse(TEXT).body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


def members(name):
    """Names of what the stub of a class declares."""
    return {part.target.id if isinstance(part, ast.AnnAssign) else part.name for part in STUBS[name].body
            if isinstance(part, (ast.AnnAssign, ast.FunctionDef))}


def arguments(function):
    return [each.arg for each in function.args.posonlyargs + function.args.args + function.args.kwonlyargs]


class Stubs(unittest.TestCase):
    def test_every_public_name_is_declared_and_no_other(self):
        self.assertEqual(set(STUBS), set(tanor.__all__))

    def test_every_public_member_of_a_class_is_declared(self):
        for name in tanor.__all__:
            thing = getattr(tanor, name)
            if not inspect.isclass(thing) or issubclass(thing, Exception):
                continue
            is_data = dataclasses.is_dataclass(thing)
            own = {field.name for field in dataclasses.fields(thing)} if is_data else set()
            own |= {member for member, value in vars(thing).items() if member == "__getitem__" or
                    not member.startswith("_") and (callable(value) or isinstance(value, property))}
            self.assertEqual(own - members(name), set(), name)

    def test_functions_of_python_have_their_own_arguments(self):
        for name in tanor.__all__:
            thing = getattr(tanor, name)
            if inspect.isfunction(thing) and not thing.__doc__.startswith(f"{name}("):  # a compiled one
                self.assertEqual(arguments(STUBS[name]), list(inspect.signature(thing).parameters), name)

    def test_types_are_those_that_editors_know(self):
        self.assertIsNone(re.search(r"std::|tanor::|_core|\bobject\b|\bhandle\b", TEXT))
        annotated = [each for function in ast.walk(ast.parse(TEXT)) if isinstance(function, ast.FunctionDef)
                     for each in function.args.args + function.args.kwonlyargs if each.arg != "self"]
        self.assertEqual([each.arg for each in annotated if each.annotation is None], [])

    def test_a_class_and_a_function_are_written_out(self):
        for line in ("    def velocities(self) -> numpy.ndarray: ...",
                     "    def __init__(self, pairs: ArrayLike, *, length: ParameterLike = None",
                     "def modes(system: System | Scene",
                     "    def __getitem__(self, name: str) -> 'numpy.ndarray | Group | Member': ...",
                     "class Group(Member):",
                     "    def tension(self) -> numpy.ndarray: ..."):
            self.assertIn(line, TEXT)


if __name__ == "__main__":
    unittest.main()
