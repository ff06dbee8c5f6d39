"""Whole runs, kept as arrays."""

import dataclasses
import html
import operator
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy

from . import _core
from ._core import (Constrainer, Dynamics, EquilibriumResult, InputError, InverseDynamics, Modes, MotionReport, Observed, Outcome, Scene,
                    Simulation, Solution)
from .description import count, no_name, tells_names


class Failed(RuntimeError):
    """A run that the numbers ended.

    outcome     Outcome, why
    trajectory  Trajectory, what it went through until then
    """

    def __init__(self, outcome: Outcome, trajectory: "Trajectory") -> None:
        super().__init__(outcome.what)
        self.outcome = outcome
        self.trajectory = trajectory

    def __reduce__(self) -> tuple:
        return Failed, (self.outcome, self.trajectory)


@dataclasses.dataclass(eq=False, repr=False)
class Member:
    """A member of a group of constraints, springs or bonds along a run, or at one instant: run["links[3]"] or run["links"][3].

    name         as in results, links[3]
    multipliers  float64 [k, equations a member], at one instant without k; NaN once an event has taken it out
    pulls        float64 [k], of rods, ropes, springs and bonds; else None
    """

    name: str
    multipliers: numpy.ndarray
    pulls: numpy.ndarray | None = None

    @property
    def tension(self) -> numpy.ndarray:
        """float64 as multipliers, without equations, N: of rods, ropes, springs and bonds; -lambda of other constraints."""
        if self.pulls is not None:
            return self.pulls
        if self.multipliers.shape[-1] != 1:
            raise AttributeError(f"{self.name} has {self.multipliers.shape[-1]} equations a member and no tension")
        return -self.multipliers[..., 0]

    def __repr__(self) -> str:
        members, own = ("", 1) if type(self) is Member else (", " + count(len(self), "member"), 2)
        times = f" at {count(self.multipliers.shape[0], 'time')}" if self.multipliers.ndim > own else ""
        return f"{type(self).__name__}({self.name!r}{members}{times})"


@dataclasses.dataclass(eq=False, repr=False)
class Group(Member):
    """A group of constraints, springs or bonds along a run, or at one instant.

    name         as in the system
    multipliers  float64 [k, members, equations a member], at one instant without k; NaN of what events have taken out
    pulls        float64 [k, members], likewise
    """

    def __len__(self) -> int:
        return self.multipliers.shape[-2]

    def __getitem__(self, number: int | slice) -> Member | list[Member]:
        members = len(self)
        if isinstance(number, slice):
            return [self[each] for each in range(*number.indices(members))]
        if isinstance(number, str):
            raise TypeError(f"{self.name}[{number!r}]: members have numbers, 0 to {members - 1}")
        if not -members <= operator.index(number) < members:
            raise IndexError(f"{self.name} has {count(members, 'member')}, counted from 0")
        number %= members
        return Member(f"{self.name}[{number}]", self.multipliers[..., number, :], None if self.pulls is None else self.pulls[..., number])


def _look_up(name: str, observed: dict[str, numpy.ndarray], columns: dict[str, list[str]], groups: dict[str, tuple],
             multipliers: numpy.ndarray, tensions: dict[str, numpy.ndarray]):
    """What result[name] is: a group, an observable, a column of one ("load(hook).x"), or a member."""
    if name in groups:
        row, members, rows = groups[name]
        part = multipliers[..., row:row + members * rows]
        return Group(name, part.reshape(*part.shape[:-1], members, rows), tensions.get(name))
    if name in observed:
        return observed[name]
    for each, names in columns.items():
        if name in names:
            values = numpy.asarray(observed[each])
            return values.reshape(*multipliers.shape[:-1], len(names))[..., names.index(name)]
    group, _, number = str(name).removesuffix("]").rpartition("[")
    if group in groups and number.isdecimal():
        if int(number) < groups[group][1]:
            return _look_up(group, {}, {}, groups, multipliers, tensions)[int(number)]
        raise KeyError(f"{name}: {group} has {count(groups[group][1], 'member')}, counted from 0")
    raise no_name(name, [*observed, *groups])


@dataclasses.dataclass(eq=False)
class Trajectory:
    """What a run went through.

    times        float64 [k], s
    positions    float64 [k, n, 3], m
    velocities   float64 [k, n, 3], m/s
    outcome      Outcome of the run
    report       MotionReport at its end
    observables  structured array [k]: the time `t` and a field for each observable
    units        units of `t` and of the observables by name
    columns      names of the numbers of each observable, as in observables.csv: "load(hook).x"
    multipliers  float64 [k, equations]; NaN of what events have taken out
    groups       first equation, members and equations a member of each group of constraints, by name; springs and bonds have none
    tensions     float64 [k, members], N, of each group of rods, ropes, springs and bonds, by name
    system       System or Scene, as it was given
    passages     list[Passage]: what events told on the way

    run["torque"] is an observable over time, run["load(hook).x"] a column of one, run["links"].tension that of a group
    of rods, springs or bonds, run["links[3]"].tension that of one. A name of both is the group; `observables` has the other.
    """

    times: numpy.ndarray
    positions: numpy.ndarray
    velocities: numpy.ndarray
    outcome: Outcome
    report: MotionReport
    observables: numpy.ndarray
    units: dict[str, str]
    columns: dict[str, list[str]]
    multipliers: numpy.ndarray
    groups: dict[str, tuple]
    tensions: dict[str, numpy.ndarray]
    system: "System | Scene"  # noqa: F821
    passages: list[_core.Passage] = dataclasses.field(default_factory=list)

    def __getitem__(self, name: str) -> "numpy.ndarray | Group | Member":
        observed = {each: self.observables[each] for each in self.observables.dtype.names}
        return _look_up(name, observed, self.columns, self.groups, self.multipliers, self.tensions)

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.observables.dtype.names, *self.groups]

    def to_pandas(self) -> "pandas.DataFrame":  # noqa: F821
        """The observables as a table with a column for each number; the index is the time, `attrs["units"]` has the units."""
        import pandas
        columns = {column: self[column] for names in self.columns.values() for column in names}
        table = pandas.DataFrame(columns, index=pandas.Index(self.times, name="t"))
        table.attrs["units"] = self.units
        return table

    def __repr__(self) -> str:
        names = [*self.columns]
        said = "; observables " * bool(names) + ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
        return (f"Trajectory({count(len(self.times), 'time')} to t = {self.times[-1]:g}, {count(self.positions.shape[1], 'point')}, "
                f"{'ok' if self.outcome.ok else self.outcome.what}{said})")

    def _repr_html_(self) -> str:
        return _html_of(self, self.positions[-1])


def _html_of(result, positions: numpy.ndarray) -> str:
    from .plot import picture_of
    return f"<p>{html.escape(repr(result))}</p>" + picture_of(result.system, positions)


def _shape_of(each: Observed) -> tuple:
    return tuple(len(names) for names in (each.members, each.parts) if names)


def _record_of(observed: list) -> numpy.dtype:
    """The type of a row of observables."""
    return numpy.dtype([("t", "<f8"), *((each.name, "<f8", _shape_of(each)) for each in observed)])


def _at_one_instant(self, name: str) -> "numpy.ndarray | float | Group | Member":
    """report["load(hook)"] is an observable of a state, report["links"].tension that of a group of rods."""
    if isinstance(self, Constrainer):
        groups, multipliers, tensions, observed = {}, numpy.zeros(0), {}, self.observed
    else:
        groups, multipliers, tensions, observed = self.groups, self.multipliers, self.tensions, []
        if name not in groups:
            observed = (self.observe() if isinstance(self, Simulation) else _core._observe(self.system, self, None) if isinstance(self, Solution)
                        else self.observables or [])
        state = self if isinstance(self, (Simulation, Solution)) else getattr(self, "state", None)  # none where a search failed
        known = [column for each in observed for column in (each.name, *each.columns)]
        if "(" in str(name) and state is not None and name not in known:
            try:
                observed = [*observed, *(self._observe(name) if isinstance(self, Simulation) else _core._observe(self.system, state, name))]
            except InputError as error:
                if "is not known" not in str(error):  # else _look_up says what there is
                    raise KeyError(str(error)) from None
    values = {each.name: numpy.reshape(each.values, _shape_of(each))[()] for each in observed}
    return _look_up(name, values, {each.name: each.columns for each in observed}, groups, multipliers, tensions)


Constrainer.__getitem__ = _at_one_instant
for _kind in (Simulation, Solution, EquilibriumResult, Modes):
    _kind.__getitem__ = _at_one_instant
    _kind._ipython_key_completions_ = lambda self: [*self.groups]
    _kind._repr_html_ = lambda self: _html_of(self, self.positions)


def _named(self, name: str) -> Any:
    """The group of a name: scene["coil"].stiffness."""
    return self.system[name]


Scene.__repr__ = lambda self: f"Scene({self.file!r}, {self.system!r})"
Scene.__getitem__ = _named
Scene._repr_html_ = lambda self: self.system._repr_html_()
Simulation.__repr__ = lambda self: (f"Simulation({self.system.name!r}, {count(len(self.positions), 'point')}, t = {self.time:g}, "
                                    f"{self.report.method})")
Constrainer.__repr__ = lambda self: f"Constrainer({count(self.num_points, 'point')}, {count(self.num_rows, 'row')})"
for _kind in (Dynamics, InverseDynamics):
    _kind.__repr__ = lambda self: f"{type(self).__name__}({count(self.num_points, 'point')}, {count(self.num_equations, 'equation')})"


class _Line:
    """Tells how far a run is: on one line of a terminal or of a notebook's cell, line by line in a file."""

    def __init__(self, begin: float, end: float) -> None:
        self.begin, self.end_time, self.shown, self.started = begin, end, -1, time.monotonic()
        is_notebook = type(sys.stdout).__module__.startswith("ipykernel")
        self.file = sys.stdout if is_notebook else sys.stderr
        self.rewrites = is_notebook or self.file.isatty()
        self.said = ""

    def __call__(self, report: MotionReport) -> None:
        part = (report.time - self.begin) / (self.end_time - self.begin)
        shown = int(100 * part) if self.rewrites else 10 * int(10 * part)
        if shown == self.shown:
            return
        self.shown = shown
        left = (time.monotonic() - self.started) * (1 / part - 1)
        said = f"{shown:3d} %, {count(report.steps, 'step')} of {report.method}, {left:.0f} s left"
        print(f"\r{said:{len(self.said)}}" if self.rewrites else said, end="" if self.rewrites else "\n", file=self.file, flush=True)
        self.said = said

    def end(self) -> None:
        if self.rewrites and self.said:
            print(file=self.file)


@tells_names
def run(simulation: Simulation, t_end: "float | ArrayLike", every: float = 0.0,  # noqa: F821
        progress: Callable[[MotionReport], bool | None] | bool | None = None, check: bool = True) -> Trajectory:
    """Steps a Simulation to t_end and keeps the state at the start, at the multiples of `every` and at the end.

    t_end     s; or the increasing instants [k] at which the state is kept, in place of `every`
    every     s; 0: start and end only
    progress  called with a MotionReport after every step; False ends the run there. True: a line tells how far it is
    check     raises Failed where the numbers end the run; False: see `outcome`

    An event that stops ends the run, too; see `simulation.time`.
    """
    instants = _instants(simulation.time, t_end, every)
    if progress is True:
        progress = _Line(simulation.time, max(instants, default=0.0))
    times, positions, velocities, rows, multipliers, tensions = [], [], [], [], [], []
    before = len(simulation.passages)
    observed = simulation.observe()
    record = _record_of(observed)

    def keep() -> None:
        times.append(simulation.time)
        positions.append(simulation.positions.copy())
        velocities.append(simulation.velocities.copy())
        multipliers.append(simulation.multipliers.copy())
        tensions.append(simulation.tensions)
        values = [numpy.reshape(each.values, record[each.name].shape) for each in simulation.observe()]
        rows.append((simulation.time, *values))

    outcome = simulation.outcome
    try:
        # A state is the one behind the events at its time, also at the start.
        for end in (simulation.time, *instants) if outcome.ok else ():
            outcome = simulation.advance_to(end, progress)
            keep()
            is_stopped = any(each.action == "stop" and each.time == simulation.time for each in simulation.passages[before:])
            if not outcome.ok or is_stopped or simulation.time < end:
                break
        if not times:
            keep()
    finally:
        if isinstance(progress, _Line):
            progress.end()
    units = {"t": simulation.units["time"], **{each.name: each.unit for each in observed}}
    result = Trajectory(numpy.array(times), numpy.array(positions), numpy.array(velocities), outcome, simulation.report,
                        numpy.array(rows, record), units, {each.name: each.columns for each in observed},
                        numpy.array(multipliers), simulation.groups, {name: numpy.array([each[name] for each in tensions]) for name in tensions[0]},
                        simulation.system, simulation.passages[before:])
    if check and not outcome.ok:
        raise Failed(outcome, result)
    return result


def _instants(begin: float, t_end: "float | ArrayLike", every: float) -> list[float]:  # noqa: F821
    """Instants of one's own, or the multiples of `every` behind `begin`, as the program `tanor` finds them, and t_end."""
    if numpy.ndim(t_end) > 0:
        instants = [t for t in numpy.ravel(t_end).tolist() if t != begin]
        if (numpy.diff([begin, *instants]) <= 0).any():
            raise ValueError("t_end: the instants must increase, from the time of the simulation on")
        return instants
    if not t_end >= begin or not every >= 0.0:
        raise ValueError(f"t_end: {t_end} lies before the time of the simulation, {begin:g}" if not t_end >= begin else f"every: {every} is negative")
    multiples = numpy.zeros(0)
    if every > 0.0:
        nearest = float(numpy.round(t_end / every)) * every
        t_end = nearest if abs(nearest - t_end) <= 4.0 * numpy.finfo(float).eps * abs(t_end) else t_end
        multiples = every * numpy.arange(numpy.floor(begin / every + 1e-6) + 1.0, numpy.ceil(t_end / every) + 1.0)
    return [t for t in (*multiples[multiples < t_end - 1e-6 * every].tolist(), t_end) if t > begin]


@tells_names
def run_scene(scene: Scene | str | os.PathLike, progress: Callable[[MotionReport], bool | None] | bool | None = None,
              check: bool = True) -> Trajectory:
    """Runs a scene file, or a Scene, from its start to its t_end; states are kept at its output times.

    Raises InputError where the file is wrong or has no t_end.
    """
    if not isinstance(scene, Scene):
        scene = Scene(scene)
    if scene.t_end is None:
        raise ValueError(f"{scene.file}: /motion/t_end is missing; give it there, or as t_end of Scene")
    return run(Simulation(scene), scene.t_end, scene.output_every, progress, check)
