#!/usr/bin/python3
"""Writes the stubs of the built package, PACKAGE_FOLDER/__init__.pyi, from its docstrings and signatures.

    write_stubs.py PACKAGE_FOLDER
"""

import dataclasses
import inspect
import pathlib
import re
import sys

HEAD = '''"""Motion and reactions of large systems of material points under constraints."""

# Made by src/bindings/python/write_stubs.py.

from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any

import numpy
from numpy.typing import ArrayLike

from . import plot as plot

TimeFunction = str | Formula | Table | Callable[[float], tuple[Any, Any, Any]]
VectorLike = ArrayLike | Sequence[float | TimeFunction] | Table | Callable[[float], tuple[Any, Any, Any]]
ParameterLike = None | float | ArrayLike | TimeFunction | Sequence[float | TimeFunction]

__version__: str
'''

# Arguments of compiled functions, by name: all that pybind11 knows of most of them is that they are objects.
ARRAYS = {"positions", "old_positions", "velocities", "accelerations", "forces", "multipliers", "open",
          "constraint_forces", "stress", "gradient", "reactions", "support_forces", "active_forces", "friction_forces", "index", "q", "q_dot",
          "q_ddot"}
ARGUMENTS = {"masses": "ArrayLike", "constraints": "Sequence[Any]", "cell": "ArrayLike | None",
             "old_cell": "ArrayLike | None", "images": "ArrayLike | None", "repeats": "Sequence[bool] | None",
             "options": "SolverOptions | None", "solver": "SolverOptions | None", "motion": "MotionOptions | None",
             "system": "System | Scene", "file": "str | PathLike[str]", "method": "str | None",
             "progress": "Callable[[MotionReport], bool | None] | None", "direction": "str", "mode": "str",
             "ids": "ArrayLike", "lengths": "ArrayLike", "rates": "ArrayLike | None", "points": "ArrayLike",
             "from_": "ArrayLike", "flags": "ArrayLike", "function": "Callable[[float, numpy.ndarray, numpy.ndarray], float]"}
OPTIONS = {"find_equilibrium": "EquilibriumOptions", "modes": "ModesOptions", "find_buckling": "BucklingOptions"}
RESULTS = {"find_equilibrium": "EquilibriumResult", "modes": "Modes", "solution": "Solution"}
EXCEPTIONS = {"InputError": "    where: str\n", "Failed": "    outcome: Outcome\n    trajectory: Trajectory\n"}
NUMBERS = {"step", "max_step", "rtol", "atol", "t_end", "threads"}


def argument(text: str) -> str:
    """"time: float = 0.0" as pybind11 writes it, with the type that it does not know."""
    match = re.fullmatch(r"(\w+)(?:: ([^=]+?))?(?: = (.*))?", text)
    if not match:
        return text
    name, kind, default = match.groups()
    if name == "self":
        return name
    if kind == "object":
        optional = " | None" if default == "None" else ""
        kind = "numpy.ndarray" + optional if name in ARRAYS else ARGUMENTS.get(name, "Any")
        if name in NUMBERS:
            kind = "int | None" if name == "threads" else "float | None"
    kind = kind.replace("List[", "list[").replace("tanor::python::", "")
    kind = re.sub(r"Optional\[(\w+)\]", r"\1 | None", kind)
    return f"{name}: {kind}" + (f" = {default}" if default else "")


def compiled(name: str, doc: str, indent: str) -> str:
    """The first line of pybind11's docstring is the signature."""
    match = re.match(r"(\w+)\((.*)\) -> (.*)", doc)
    arguments = ", ".join(map(argument, re.split(r", (?![^(\[]*[)\]])", match[2])))  # at commas outside of brackets
    arguments = arguments.replace("options: SolverOptions", "options: " + OPTIONS.get(name, "SolverOptions"))
    result = re.sub(r"tanor\._core\.", "", match[3]).replace("List[", "list[").replace("Tuple[", "tuple[")
    arguments = arguments.replace("self: _core.", "self: ").replace("tanor._core.", "")
    arguments = re.sub(r"self: [\w.:<>]+", "self", arguments)
    result = result if re.fullmatch(r"[\w\[\], .|]+", result) else "Any"
    result = {"tuple": "tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]", "object": RESULTS.get(name, "Any")}.get(result, result)
    return f"{indent}def {name}({arguments}) -> {result}: ...\n"


def is_compiled(member: object) -> bool:
    """A compiled function says its signature in its text, also where Python surrounds it."""
    return bool(re.match(r"\w+\(.*\) -> ", member.__doc__ or ""))


def own_members(cls: type) -> str:
    """What a class has that is written in Python: methods, properties, and what it is asked in brackets."""
    lines = ""
    for name, member in vars(cls).items():
        get = member.fget if isinstance(member, property) else member
        if inspect.isfunction(get) and not is_compiled(get) and (name == "__getitem__" or not name.startswith("_")):
            lines += "    @property\n" * (get is not member) + "    " + function(name, get)
    return lines


def compiled_class(cls: type) -> str:
    lines = ""
    for name, member in vars(cls).items():
        if isinstance(member, property):
            kind = re.match(r"\((.*?)\) ", member.__doc__ or "")
            lines += f"    @property\n    def {name}(self) -> {kind[1] if kind else 'Any'}: ...\n"
        elif name == "__init__" and (member.__doc__ or "").startswith("__init__(self: "):
            lines += compiled(name, member.__doc__, "    ")
        elif not name.startswith("_") and callable(member):
            lines += compiled(name, member.__doc__, "    ")
    lines += own_members(cls)
    return f"class {cls.__name__}:\n{lines or '    ...' + chr(10)}"


def written(value: object) -> str:
    return "..." if value is dataclasses.MISSING else repr(value)


def data_class(cls: type) -> str:
    lines, arguments, has_star = "", ["self"], False
    if hasattr(cls, "kind"):
        lines += "    kind: str\n"
    for field in dataclasses.fields(cls):
        kind = field.type if isinstance(field.type, str) else inspect.formatannotation(field.type).replace("typing.", "")
        kind = re.sub(r"\b(collections\.abc|tanor\._core|tanor)\.", "", kind)
        lines += f"    {field.name}: {kind}\n"
        if field.kw_only and not has_star:
            arguments.append("*")
            has_star = True
        has_default = field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING
        arguments.append(f"{field.name}: {kind}" + (f" = {written(field.default)}" if has_default else ""))
    base = f"({cls.__base__.__name__})" if dataclasses.is_dataclass(cls.__base__) else ""
    return f"class {cls.__name__}{base}:\n{lines}    def __init__({', '.join(arguments)}) -> None: ...\n{own_members(cls)}"


def function(name: str, member: object) -> str:
    signature = re.sub(r"\b(collections\.abc|tanor\._core|tanor\.runs|tanor|os)\.", "", str(inspect.signature(member)))
    return f"def {name}{signature}: ...\n"


def stubs(module: object) -> str:
    text = HEAD
    for name in sorted(module.__all__, key=lambda each: (each[0].islower(), each)):
        member = getattr(module, name)
        if isinstance(member, type) and issubclass(member, Exception):
            text += f"\nclass {name}({member.__base__.__name__}):\n" + EXCEPTIONS[name]
        elif isinstance(member, type):
            text += "\n" + (data_class(member) if dataclasses.is_dataclass(member) else compiled_class(member))
        elif inspect.isfunction(member) and not is_compiled(member):
            text += "\n" + function(name, member)
        else:
            text += "\n" + compiled(name, member.__doc__, "")
    return text


def main(package: str) -> None:
    folder = pathlib.Path(package)
    sys.path.insert(0, str(folder.parent))
    sys.dont_write_bytecode = True
    import tanor

    (folder / "__init__.pyi").write_text(stubs(tanor), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
