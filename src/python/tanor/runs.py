"""Whole runs, kept as arrays."""

import dataclasses
import os
from collections.abc import Callable

import numpy

from ._core import MotionReport, Outcome, Scene, Simulation


@dataclasses.dataclass(eq=False)
class Trajectory:
    """What a run went through.

    times       float64 [k], s
    positions   float64 [k, n, 3], m
    velocities  float64 [k, n, 3], m/s
    outcome     Outcome of the run
    report      MotionReport at its end
    observables structured array [k]: the time `t` and a field for each observable
    units       units of the observables by name
    """

    times: numpy.ndarray
    positions: numpy.ndarray
    velocities: numpy.ndarray
    outcome: Outcome
    report: MotionReport
    observables: numpy.ndarray
    units: dict[str, str]


def _record_of(observed: list) -> numpy.dtype:
    """The type of a row of observables."""
    fields = [("t", "<f8")]
    for each in observed:
        shape = tuple(len(names) for names in (each.members, each.parts) if names)
        fields.append((each.name, "<f8", shape) if shape else (each.name, "<f8"))
    return numpy.dtype(fields)


def run(simulation: Simulation, t_end: float, every: float = 0.0,
        progress: Callable[[MotionReport], bool | None] | None = None) -> Trajectory:
    """Steps a Simulation to t_end and keeps the state at the start, at the multiples of `every` and at the end.

    t_end     s
    every     s; 0: start and end only
    progress  called with a MotionReport after every step; False ends the run there

    A numerical failure, or an event that stops, ends the run, too; see `outcome` and `simulation.time`.
    """
    times, positions, velocities, rows = [], [], [], []
    observed = simulation.observe()
    record = _record_of(observed)

    def keep() -> None:
        times.append(simulation.time)
        positions.append(simulation.positions.copy())
        velocities.append(simulation.velocities.copy())
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
    return Trajectory(numpy.array(times), numpy.array(positions), numpy.array(velocities), outcome, simulation.report,
                      numpy.array(rows, record), {each.name: each.unit for each in observed})


def end_at_output(t_end: float, every: float) -> float:
    """The multiple of `every` that t_end is up to rounding, as the program `tanor` finds it, else t_end."""
    if every <= 0.0:
        return t_end
    nearest = float(numpy.round(t_end / every)) * every
    return nearest if abs(nearest - t_end) <= 4.0 * numpy.finfo(float).eps * t_end else t_end


def next_output_time(time: float, every: float, t_end: float) -> float:
    """The first multiple of `every` behind `time`, as the program `tanor` finds it, or t_end."""
    if every <= 0.0:
        return t_end
    following = (numpy.floor(time / every + 1e-6) + 1.0) * every
    return float(following) if following < t_end - 1e-6 * every else t_end


def run_scene(scene: Scene | str | os.PathLike, progress: Callable[[MotionReport], bool | None] | None = None) -> Trajectory:
    """Runs a scene file, or a Scene, from its start to its t_end; states are kept at its output times.

    Raises InputError where the file is wrong or has no t_end.
    """
    if not isinstance(scene, Scene):
        scene = Scene(scene)
    if not scene.t_end > 0.0:
        raise ValueError(f"{scene.file}: /motion/t_end is missing; give it there, or as t_end of Scene")
    return run(Simulation(scene), scene.t_end, scene.output_every, progress)
