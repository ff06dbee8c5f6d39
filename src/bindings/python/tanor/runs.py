"""Whole runs, kept as arrays."""

import dataclasses
import html
import os
import sys
from collections.abc import Callable

import numpy

from ._core import EquilibriumResult, MotionReport, Observed, Outcome, Scene, Simulation


class Failed(RuntimeError):
    """A run that the numbers ended.

    outcome     Outcome, why
    trajectory  Trajectory, what it went through until then
    """

    def __init__(self, outcome: Outcome, trajectory: "Trajectory") -> None:
        super().__init__(outcome.what)
        self.outcome = outcome
        self.trajectory = trajectory


@dataclasses.dataclass(eq=False)
class Group:
    """A group of constraints along a run, or at rest.

    name         as in the system
    multipliers  float64 [k, members, equations a member]; at rest without k
    """

    name: str
    multipliers: numpy.ndarray

    @property
    def tension(self) -> numpy.ndarray:
        """float64 [k, members], at rest [members], N: -lambda, of rods and ropes."""
        if self.multipliers.shape[-1] != 1:
            raise AttributeError(f"{self.name} has {self.multipliers.shape[-1]} equations a member and no tension")
        return -self.multipliers[..., 0]

    def __repr__(self) -> str:
        times = f"{self.multipliers.shape[0]} times" if self.multipliers.ndim > 2 else "rest"
        return f"Group({self.name!r}, {self.multipliers.shape[-2]} members at {times})"


@dataclasses.dataclass(eq=False)
class Trajectory:
    """What a run went through.

    times       float64 [k], s
    positions   float64 [k, n, 3], m
    velocities  float64 [k, n, 3], m/s
    outcome     Outcome of the run
    report      MotionReport at its end
    observables  structured array [k]: the time `t` and a field for each observable
    units        units of the observables by name
    multipliers  float64 [k, equations]
    groups       first equation, members and equations a member of each group of constraints, by name

    run["torque"] is an observable over time, run["links"].tension those of a group of rods.
    """

    times: numpy.ndarray
    positions: numpy.ndarray
    velocities: numpy.ndarray
    outcome: Outcome
    report: MotionReport
    observables: numpy.ndarray
    units: dict[str, str]
    multipliers: numpy.ndarray
    groups: dict[str, tuple]

    def __getitem__(self, name: str) -> "numpy.ndarray | Group":
        if name in self.observables.dtype.names:
            return self.observables[name]
        if name in self.groups:
            row, members, rows = self.groups[name]
            part = self.multipliers[:, row:row + members * rows]
            return Group(name, part.reshape(len(self.times), members, rows))
        raise KeyError(f"{name}: there are {', '.join([*self.observables.dtype.names, *self.groups])}")

    def to_pandas(self) -> "pandas.DataFrame":  # noqa: F821
        """The observables as a table with a column for each number; the index is the time."""
        import pandas
        columns = {}
        for name in self.observables.dtype.names[1:]:
            values = self.observables[name].reshape(len(self.times), -1)
            for k in range(values.shape[1]):
                columns[name if values.shape[1] == 1 else f"{name}.{k}"] = values[:, k]
        return pandas.DataFrame(columns, index=pandas.Index(self.times, name="t"))

    def __repr__(self) -> str:
        names = ", ".join(self.observables.dtype.names[1:])
        return (f"Trajectory({len(self.times)} times to t = {self.times[-1]:g}, {self.positions.shape[1]} points, "
                f"{'ok' if self.outcome.ok else self.outcome.what}; observables {names})")

    def _repr_html_(self) -> str:
        from .plot import picture_of
        return f"<p>{html.escape(repr(self))}</p>" + picture_of(self.positions[-1])


def _shape_of(each: Observed) -> tuple:
    return tuple(len(names) for names in (each.members, each.parts) if names)


def _record_of(observed: list) -> numpy.dtype:
    """The type of a row of observables."""
    return numpy.dtype([("t", "<f8"), *((each.name, "<f8", _shape_of(each)) for each in observed)])


def at_rest(rest: EquilibriumResult, name: str) -> "numpy.ndarray | float | Group":
    """rest["load(hook)"] is an observable of a state of rest, rest["links"].tension those of a group of rods."""
    observed = {each.name: each for each in rest.observables}
    if name in observed:
        return numpy.reshape(observed[name].values, _shape_of(observed[name]))[()]
    if name in rest.groups:
        row, members, rows = rest.groups[name]
        return Group(name, rest.multipliers[row:row + members * rows].reshape(members, rows))
    raise KeyError(f"{name}: there are {', '.join([*observed, *rest.groups])}")


class _Line:
    """Tells on one line of the terminal, or of a notebook's cell, how far a run is."""

    def __init__(self, begin: float, end: float) -> None:
        self.begin, self.end_time, self.shown = begin, end, -1

    def __call__(self, report: MotionReport) -> None:
        percent = int(100.0 * (report.time - self.begin) / (self.end_time - self.begin))
        if percent != self.shown:
            self.shown = percent
            print(f"\r{percent:3d} %, {report.steps} steps of {report.method}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        print(file=sys.stderr)


def run(simulation: Simulation, t_end: float, every: float = 0.0,
        progress: Callable[[MotionReport], bool | None] | bool | None = None, check: bool = True) -> Trajectory:
    """Steps a Simulation to t_end and keeps the state at the start, at the multiples of `every` and at the end.

    t_end     s
    every     s; 0: start and end only
    progress  called with a MotionReport after every step; False ends the run there. True: a line tells how far it is
    check     raises Failed where the numbers end the run; False: see `outcome`

    An event that stops ends the run, too; see `simulation.time`.
    """
    if progress is True:
        progress = _Line(simulation.time, t_end)
    times, positions, velocities, rows, multipliers = [], [], [], [], []
    observed = simulation.observe()
    record = _record_of(observed)

    def keep() -> None:
        times.append(simulation.time)
        positions.append(simulation.positions.copy())
        velocities.append(simulation.velocities.copy())
        multipliers.append(simulation.multipliers.copy())
        values = [numpy.reshape(each.values, record[each.name].shape) for each in simulation.observe()]
        rows.append((simulation.time, *values))

    keep()
    outcome, t_end = simulation.outcome, end_at_output(t_end, every)
    while outcome.ok and simulation.time < t_end:
        end = next_output_time(simulation.time, every, t_end)
        outcome = simulation.advance_to(end, progress)
        keep()
        if simulation.time < end:
            break
    if isinstance(progress, _Line):
        progress.end()
    result = Trajectory(numpy.array(times), numpy.array(positions), numpy.array(velocities), outcome, simulation.report,
                        numpy.array(rows, record), {each.name: each.unit for each in observed},
                        numpy.array(multipliers), simulation.groups)
    if check and not outcome.ok:
        raise Failed(outcome, result)
    return result


def end_at_output(t_end: float, every: float) -> float:
    """The multiple of `every` that t_end is up to rounding, as the program `tanor` finds it, else t_end."""
    if every <= 0.0:
        return t_end
    nearest = float(numpy.round(t_end / every)) * every
    return nearest if abs(nearest - t_end) <= 4.0 * numpy.finfo(float).eps * abs(t_end) else t_end


def next_output_time(time: float, every: float, t_end: float) -> float:
    """The first multiple of `every` behind `time`, as the program `tanor` finds it, or t_end."""
    if every <= 0.0:
        return t_end
    following = (numpy.floor(time / every + 1e-6) + 1.0) * every
    return float(following) if following < t_end - 1e-6 * every else t_end


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
