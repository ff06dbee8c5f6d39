"""What a system is made of, as plain objects that hold what the user gave.

The classes of the kinds are made of the library's own tables, so a kind that the library gains is here, too.
"""

import dataclasses
import difflib
import functools
import html
import inspect
import re
import types
from collections.abc import Callable, Collection
from typing import Any

import numpy

from . import _core


def _meant(name: str, known: Collection[str]) -> str:
    """"(did you mean length?)", or the names that there are."""
    near = difflib.get_close_matches(name, known, 1)
    return f"(did you mean {near[0]}?)" if near else f"(it has {', '.join(known)})"


def no_name(name: object, known: Collection[str]) -> KeyError:
    """What a name gets that nothing has: all that there are, and the one that is meant."""
    near = difflib.get_close_matches(str(name), known, 1)
    return KeyError(f"{name}: there are {', '.join(known) or 'no names'}" + (f"; did you mean {near[0]}?" if near else ""))


def refuse_names(what: str, known: Collection[str], named: dict) -> None:
    """Raises TypeError for the first keyword that is no name of an argument, with the one that is meant."""
    for name in named:
        if name not in known:
            raise TypeError(f"{what} has no argument {name!r} {_meant(name, known)}")


def signature_of(function: Callable) -> inspect.Signature:
    """The arguments of a function. The first line of a compiled one's text has them, with its types and defaults as texts."""
    compiled = re.match(r"\w+\((.*)\) -> ", function.__doc__ or "")
    if not compiled:
        return inspect.signature(function)
    parameters, kind = [], inspect.Parameter.POSITIONAL_OR_KEYWORD
    for text in re.split(r", (?![^(\[]*[)\]])", compiled[1]):  # commas outside of brackets
        name, annotation, default = re.fullmatch(r"([*\w]+)(?:: ([^=]+?))?(?: = (.*))?", text).groups()
        if name == "*":  # what follows stands by name
            kind = inspect.Parameter.KEYWORD_ONLY
        else:
            own = inspect.Parameter.VAR_KEYWORD if name[0] == "*" else kind
            parameters.append(inspect.Parameter(name.strip("*"), own, default=default or inspect.Parameter.empty, annotation=annotation or "Any"))
    return inspect.Signature(parameters)


def _has_numbers(value: Any) -> bool:
    try:
        return numpy.asarray(value).dtype.kind in "fiub"
    except ValueError:  # rows of several lengths
        return False


# Types of arguments: in words, and what is one. All others are known by the names of their classes, reports that were pickled by theirs.
_TYPES = {
    "None": ("None", lambda value: value is None),
    "bool": ("True or False", lambda value: isinstance(value, (bool, int, numpy.bool_))),
    "int": ("a whole number", lambda value: hasattr(value, "__index__") and not getattr(value, "ndim", 0)),
    "float": ("a number", lambda value: (hasattr(value, "__float__") or hasattr(value, "__index__")) and not getattr(value, "ndim", 0)),
    "str": ("a text", lambda value: isinstance(value, str)),
    "bytes": ("bytes", lambda value: isinstance(value, bytes)),
    "list[str]": ("a list of texts", lambda value: isinstance(value, (list, tuple)) and all(isinstance(each, str) for each in value)),
    "ArrayLike": ("a list of numbers", _has_numbers),
    "Callable": ("a function", callable),
    "PathLike": ("a path", lambda value: hasattr(value, "__fspath__")),
    "Simulation": ("a Simulation (run_scene takes a Scene or a file)", lambda value: isinstance(value, _core.Simulation)),
    **dict.fromkeys(("Any", "object", "_empty"), ("anything", lambda value: True)),
}


def _type_of(text: str) -> tuple:
    kind = text if text in _TYPES else re.sub(r"\[.*", "", text).rpartition(".")[2].rpartition(":")[2]
    return _TYPES.get(kind, (f"{'an' if kind[0] in 'AEIOU' else 'a'} {kind}",
                             lambda value: {kind, "SimpleNamespace"} & {base.__name__ for base in type(value).__mro__}))


def refuse_values(what: str, signature: inspect.Signature, arguments: tuple, named: dict) -> None:
    """Raises TypeError where arguments are missing or too many, and for the first one that is not of its type."""
    try:
        given = signature.bind(*arguments, **named).arguments
    except TypeError as error:
        names = [each.name if each.kind == each.POSITIONAL_OR_KEYWORD else f"{each.name}=..." for each in signature.parameters.values()
                 if each.name not in ("self", "kwargs")]
        raise TypeError(f"{what}: {error} (it has {', '.join(names)})") from None
    for name, value in given.items():
        annotation = signature.parameters[name].annotation
        text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
        wanted = [_type_of(each) for each in re.split(r" \| (?![^\[]*\])", re.sub(r"Optional\[(.*)\]", r"\1 | None", text))]
        if not any(fits(value) for _, fits in wanted):
            raise TypeError(f"{what}: {name}: found {short(value)}, wanted {' or '.join(words for words, _ in wanted)}")


def tells_names(function: Callable, what: str = "") -> Callable:
    """The same function, which says what is wrong with its arguments. One with options tells of their names itself.

    What Python has written is checked at each call, and what is compiled where it has refused its arguments.
    """
    signature, what = signature_of(function), what or function.__name__
    known = [name for name in signature.parameters if name != "self"]
    is_checked = inspect.isfunction(function) and "self" not in signature.parameters

    @functools.wraps(function)
    def called(*arguments, **named):
        if is_checked:
            refuse_names(what, known, named)
            refuse_values(what, signature, arguments, named)
        try:
            return function(*arguments, **named)
        except TypeError as error:
            if not any(each.kind == each.VAR_KEYWORD for each in signature.parameters.values()):
                refuse_names(what, known, named)
            if "incompatible" in str(error):
                refuse_values(what, signature, arguments, named)
            raise

    return called


def tell_names_of(cls: type) -> type:
    """Lets the methods of a class, its making, and its attributes say what was meant."""
    for name, member in list(vars(cls).items()):
        if name == "__init__" or callable(member) and not name.startswith("_"):
            setattr(cls, name, tells_names(member, cls.__name__ if name == "__init__" else ""))

    def set_attribute(self, name, value):
        try:
            object.__setattr__(self, name, value)
        except AttributeError:
            if hasattr(self, name):
                doc = re.sub(r"^\(.*?\) ", "", getattr(cls, name).__doc__ or "")
                raise AttributeError(f"{cls.__name__}.{name} cannot be set: {doc}") from None
            part = next((f"{part}.{name}" for part in ("motion", "solver") if hasattr(getattr(self, part, None), name)), "")
            known = [each for each in dir(cls) if not each.startswith("_")]
            raise AttributeError(f"{cls.__name__} has no attribute {name!r} " + (f"(did you mean {part}?)" if part else _meant(name, known))) from None

    cls.__setattr__ = set_attribute
    return cls


@tell_names_of
@dataclasses.dataclass
class Formula:
    """A formula with named constants, for whatever takes a text: Formula("0.1*sin(omega*t)", {"omega": 3.0}).

    text       a text, or a list of texts where several are wanted
    constants  numbers by name
    """

    text: Any
    constants: dict[str, float] = dataclasses.field(default_factory=dict)


@tell_names_of
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


@tell_names_of
@dataclasses.dataclass(eq=False)
class Table:
    """A function of time by its samples, C4 between them. Outside of its times it is an InputError.

    times   float [k], increasing, s
    values  float [k], or [k, 3] for a vector
    """

    times: Any
    values: Any


def short(value: Any) -> str:
    """A repr that stays short: arrays and long lists by their shapes."""
    shape = getattr(value, "shape", None)
    if shape is None and isinstance(value, (list, tuple, dict)) and len(value) > 8:
        shape = (len(value),)
    if shape is not None and (len(shape) != 1 or shape[0] > 8):
        return "<" + " x ".join(str(size) for size in shape) + ">"
    return repr(value)


def count(number: int, noun: str) -> str:
    """"1 point", "2 points"."""
    return f"{number} {noun}" + "s" * (number != 1)


def _name_of(group: Any, number: int, what: str) -> str:
    return getattr(group, "name", "") or f"{getattr(group, 'kind', what.removesuffix('s'))}{number}"


def _group_in_words(group: Any, number: int, what: str) -> str:
    """"links (4 rods)", "gravity0": the name of a group with the count of its members."""
    kind, name = getattr(group, "kind", what.removesuffix("s")), _name_of(group, number, what)
    nouns = {"points": "point", "at": "guide", "tuples": "tuple", "pairs": kind, "triples": kind, "quadruples": kind}
    for field in dataclasses.fields(group) if dataclasses.is_dataclass(group) else ():
        members = getattr(group, field.name)
        if field.name in nouns and (numpy.isscalar(members) or len(members) > 0):
            noun = "tuple" if type(group).__name__ in ("Potential", "UserConstraints") else nouns[field.name]
            return f"{name} ({count(1 if numpy.isscalar(members) else len(members), noun)})"
    return name


def _masses_in_words(system: "System") -> str:
    """"masses 0.5 to 0.7, 2.5 in all": of the points that are no supports."""
    try:
        masses = numpy.array(numpy.broadcast_to(numpy.asarray(system.masses, float), len(system.positions)))
        for support in system.supports:
            masses[support.points] = numpy.nan
    except (AttributeError, IndexError, TypeError, ValueError):  # nothing is checked yet
        return ""
    masses = masses[~numpy.isnan(masses)]
    if not len(masses):
        return ""
    least, most = f"{masses.min():.6g}", f"{masses.max():.6g}"
    return f"masses {least}" + f" to {most}" * (least != most) + f", {masses.sum():.6g} in all"


def short_repr(self: Any) -> str:
    """The repr of a kind, of options or of a report: fields that hold nothing are left out."""
    names = getattr(self, "_fields", None) or [field.name for field in dataclasses.fields(self)]
    fields = [(name, getattr(self, name)) for name in names]
    said = [f"{name}={short(value)}" for name, value in fields
            if value is not None and not (hasattr(value, "__len__") and len(value) == 0) and (name, value) != ("restitution", 0.0)]
    return f"{type(self).__name__}({', '.join(said)})"


def reduce_report(self: Any) -> tuple:
    """How pickle and copy keep a report: as a plain namespace with the same fields."""
    return types.SimpleNamespace, (), {name: getattr(self, name) for name in [*vars(self), *self._fields]}


def split_options(what: str, first: Any, solver: Any, named: dict) -> tuple:
    """Options from their fields by name; what was given whole is kept and changed in a copy."""
    parts = [first, solver]
    if not all(map(dataclasses.is_dataclass, parts)):
        return first, solver  # whoever reads them refuses them
    names = [[field.name for field in dataclasses.fields(part)] for part in parts]
    refuse_names(what, [*names[0], *names[1]], named)
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
    return tell_names_of(dataclasses.make_dataclass(table["name"], fields, namespace=namespace, eq=False, slots=True))


def _list_carried(system: "System") -> list:
    """The functions, kernels and units of a system that was a scene file's, each with its path."""
    paths = [(name,) for name in ("cell", "units")]
    for what in ("supports", "constraints", "forces", "friction", "coordinates"):
        paths += [(what, number, field.name) for number, group in enumerate(getattr(system, what)) for field in dataclasses.fields(group)]
    return [(value, path) for path in paths if isinstance(value := _follow(system, path), _core.Carried)]


def _follow(value: Any, path: tuple) -> Any:
    for step in path:
        value = value[step] if isinstance(step, int) else getattr(value, step)
    return value


def note_origins(system: "System", scene: "Scene") -> "System":  # noqa: F821
    """Notes whence carried values are, so that pickle can keep them: the state of their scene, and their place in it."""
    carried_values = _list_carried(system)
    state = scene.__getstate__()[:-1] if carried_values else ()  # the last entry is what was looked at
    for value, path in carried_values:
        value.origin = state, path
    return system


@functools.lru_cache(maxsize=1)
def _system_of(scene: tuple) -> "System":
    made = _core.Scene.__new__(_core.Scene)
    made.__setstate__((*scene, {}))
    return made.system


def carried(scene: tuple, path: tuple) -> Any:
    """A value of a scene file that was pickled."""
    return _follow(_system_of(scene), path)


# What the library reads off a kernel, and Python must be told.
_EXTRA = {
    "UserFriction": [("num_multipliers", "int", "equations of the guides at a point: 1 on a surface, 2 on a wire")],
    "UserCoordinates": [("names", "Sequence[str]", "of the coordinates, as the formulas of the kernel spell them")],
}

for _cls in (_core.Scene, _core.Simulation, _core.Dynamics, _core.InverseDynamics, _core.Constrainer):
    tell_names_of(_cls)

KINDS = {table["name"]: _make_class(table) for table in _core._descriptions()}


@tell_names_of
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

    def __getitem__(self, name: str) -> Any:
        """The group of a name: system["coil"].stiffness."""
        lists = ("coordinates", "friction", "forces", "supports", "constraints")
        found = {_name_of(group, number, what): group for what in lists for number, group in enumerate(getattr(self, what))}
        if name not in found:
            raise no_name(name, found)
        return found[name]

    def __repr__(self) -> str:
        num_points = len(self.positions) if hasattr(self.positions, "__len__") else 0  # nothing is checked yet
        parts = [count(num_points, "point"), _masses_in_words(self)]
        for what in ("supports", "constraints", "forces", "friction", "coordinates"):
            groups = getattr(self, what) or ()
            groups = groups if isinstance(groups, (list, tuple)) else [groups]
            said = [_group_in_words(group, number, what) for number, group in enumerate(groups[:6])]
            said += [f"{len(groups) - 6} more"] * (len(groups) > 6)
            parts.append(f"{what} {', '.join(said)}" if said else "")
        return f"System({self.name!r}: {'; '.join(part for part in parts if part)})"

    def _repr_html_(self) -> str:
        from .plot import picture_of
        return f"<p>{html.escape(repr(self))}</p>" + picture_of(self)
