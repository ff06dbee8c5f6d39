"""What a system is made of, as plain objects that hold what the user gave.

The classes of the kinds are made of the library's own tables, so a kind that the library gains is here, too.
"""

import dataclasses
import difflib
import html
import types
from typing import Any

from . import _core


@dataclasses.dataclass
class Formula:
    """A formula with named constants, for whatever takes a text: Formula("0.1*sin(omega*t)", {"omega": 3.0}).

    text       a text, or a list of texts where several are wanted
    constants  numbers by name
    """

    text: Any
    constants: dict[str, float] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(eq=False)
class Definition:
    """An energy that is written once, over a scalar type, as the kernel of a Potential:

        def stretched(r1, r2, t, k):
            return 0.5 * k * (numpy.linalg.norm(r2 - r1) - 1.0)**2

        Potential([[0, 1], [1, 2]], kernel=Definition(stretched), constants={"k": [30.0, 40.0]})

    function  (r1 [3], r2 [3], ..., t, and the constants by name) -> energy, J

    It is called once, with numbers that write down what is done to them (Scalar). The library then has force, stiffness
    and series of any order, and calls Python no more: all methods, equilibria and modes take it, on any number of threads.
    """

    function: Any


@dataclasses.dataclass(eq=False)
class Table:
    """A function of time by its samples, C4 between them. Outside of its times it is an InputError.

    times   float [k], increasing, s
    values  float [k], or [k, 3] for a vector
    """

    times: Any
    values: Any


def _short(value: Any) -> str:
    """A repr that stays short: arrays and long lists by their shapes."""
    shape = getattr(value, "shape", None)
    if shape is None and isinstance(value, (list, tuple, dict)) and len(value) > 8:
        shape = (len(value),)
    if shape is not None and (len(shape) != 1 or shape[0] > 8):
        return "<" + " x ".join(str(size) for size in shape) + ">"
    return repr(value)


def short_repr(self: Any) -> str:
    """The repr of a kind, of options or of a report: fields that hold nothing are left out."""
    names = getattr(self, "_fields", None) or [field.name for field in dataclasses.fields(self)]
    fields = [(name, getattr(self, name)) for name in names]
    said = [f"{name}={_short(value)}" for name, value in fields if value is not None and not (hasattr(value, "__len__") and len(value) == 0)]
    return f"{type(self).__name__}({', '.join(said)})"


def reduce_report(self: Any) -> tuple:
    """How pickle and copy keep a report: as a plain namespace with the same fields."""
    return types.SimpleNamespace, (), {**vars(self), **{name: getattr(self, name) for name in self._fields}}


def split_options(what: str, first: Any, solver: Any, named: dict) -> tuple:
    """Options from their fields by name; what was given whole is kept and changed in a copy."""
    parts = [first, solver]
    names = [{field.name for field in dataclasses.fields(part)} for part in parts]
    for name in named:
        if name not in names[0] | names[1]:
            near = difflib.get_close_matches(name, names[0] | names[1], 1)
            raise TypeError(f"{what} has no option {name!r}" + (f" (did you mean {near[0]}?)" if near else ""))
    return tuple(dataclasses.replace(part, **{name: value for name, value in named.items() if name in known})
                 for part, known in zip(parts, names))


def _make_class(table: dict) -> type:
    """The class of a kind or of options; its members stand first, all other fields are keywords."""
    lines = [table["doc"], ""] if table["doc"] else []
    fields = []
    for number, (name, annotation, text, default, is_required) in enumerate(table["fields"]):
        is_keyword = number > 0 or table["list"] == "options"
        if is_required:
            fields.append((name, annotation, dataclasses.field(kw_only=is_keyword)))
        else:
            fields.append((name, annotation, dataclasses.field(default=default, kw_only=is_keyword)))
        rest = "" if is_required else f" (default {default!r})"
        lines.append(f"{name}: {text}{rest}")
    for name, annotation, text in _EXTRA.get(table["name"], ()):
        fields.append((name, annotation, dataclasses.field(kw_only=True)))
        lines.append(f"{name}: {text}")
    namespace = {"__doc__": "\n".join(lines), "__module__": "tanor", "__repr__": short_repr}
    if table["kind"]:
        namespace["kind"] = table["kind"]
    return dataclasses.make_dataclass(table["name"], fields, namespace=namespace, eq=False, slots=True)


# What the library reads off a kernel, and Python must be told.
_EXTRA = {
    "UserFriction": [("num_multipliers", "int", "equations of the guides at a point: 1 on a surface, 2 on a wire")],
    "UserCoordinates": [("names", "Sequence[str]", "of the coordinates, as the formulas of the kernel spell them")],
}

KINDS = {table["name"]: _make_class(table) for table in _core._descriptions()}


@dataclasses.dataclass(eq=False, slots=True)
class System:
    """What is simulated: points, supports, constraints, forces, friction, coordinates.

    positions    float [n, 3], m
    masses       float [n], or one number for all, kg, > 0 (of supports: ignored)
    velocities   float [n, 3], or [3] for all, m/s; None: at rest
    supports     list of Support: points whose motion is prescribed
    constraints  list of Rods, Planes, ...
    forces       list of Gravity, Springs, ...
    friction     list of Coulomb, ...
    coordinates  list of coordinates; none: the constraints alone say what can move
    name         a text
    cell         edges [3] of a periodic cell, m, for pressure and files of results; None: there is none
    units        letters beside results: none, si, lj, real, metal

    The lists and arrays are the user's own; nothing is checked or copied before a Dynamics, a Simulation or
    `validate` reads them.
    """

    positions: Any
    masses: Any = 1.0
    velocities: Any = None
    supports: list = dataclasses.field(default_factory=list, kw_only=True)
    constraints: list = dataclasses.field(default_factory=list, kw_only=True)
    forces: list = dataclasses.field(default_factory=list, kw_only=True)
    friction: list = dataclasses.field(default_factory=list, kw_only=True)
    coordinates: list = dataclasses.field(default_factory=list, kw_only=True)
    name: str = dataclasses.field(default="system", kw_only=True)
    cell: Any = dataclasses.field(default=None, kw_only=True)
    units: str = dataclasses.field(default="none", kw_only=True)

    def __repr__(self) -> str:
        return (f"System({self.name!r}, {len(self.positions)} points, constraints={_short(self.constraints)}, "
                f"forces={_short(self.forces)})")

    def _repr_html_(self) -> str:
        from .plot import picture_of
        return f"<p>{html.escape(repr(self))}</p>" + picture_of(self)
