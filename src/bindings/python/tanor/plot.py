"""Pictures by matplotlib: histories, histograms of tensions, modes, error against time."""

import csv
import os

import numpy

from . import _core, description


def _axes(axes, **keywords):
    if axes is not None:
        return axes
    from matplotlib import pyplot
    return pyplot.subplots(subplot_kw=keywords)[1]


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


@description.tells_names
def histories(run: "Trajectory", names: str | list[str] | None = None, axes=None):  # noqa: F821
    """Draws observables over time, with their units: "load(hook)", or a column of one, "load(hook).x"; all of them if no names are given.
    "links" and "links[3]" are the tensions of a group and of a member.

    Of an observable with many numbers the first twelve are drawn, and the legend says so. Returns the axes.
    """
    axes = _axes(axes)
    most = 12
    for name in [names] if isinstance(names, str) else names or run.columns:
        columns = run.columns.get(name, [name])
        if name in run.groups:
            columns = [f"{name}[{number}]" for number in range(len(run[name]))]
        observable = next((each for each, parts in run.columns.items() if name in parts), name)
        unit = run.units[observable] if observable in run.units else _core._letters(run.system)["force"]
        for column in columns[:most]:
            values = run[column]
            axes.plot(run.times, getattr(values, "tension", values), label=_with_unit(column, unit))
        if len(columns) > most:
            axes.plot([], [], " ", label=f"and {len(columns) - most} more of {name}")
    axes.set_xlabel(_with_unit("t", run.units["t"]))
    axes.legend()
    return axes


@description.tells_names
def tensions(run: "Trajectory | EquilibriumResult | Modes | Solution | Simulation", group: str, time: float | None = None,  # noqa: F821
             bins: int = 40, axes=None):
    """Draws the histogram of a group's tensions at rest, or at one of the run's times; None: at the end. Returns the axes."""
    units, when, shown = _core._letters(run.system), "", numpy.atleast_2d(run[group].tension)[-1]
    if hasattr(run, "times"):
        frame = -1 if time is None else numpy.argmin(abs(run.times - time))
        if time is not None and not abs(run.times[frame] - time) <= 1e-9 * numpy.ptp(run.times):
            raise ValueError(f"tensions: time: there is no output at {time:g}, the nearest one is at {run.times[frame]:g}")
        when, shown = f" at t = {run.times[frame]:g} {units['time']}".rstrip(), run[group].tension[frame]
    elif time is not None:
        raise ValueError(f"tensions: time: {type(run).__name__} is of one instant")
    shown = numpy.asarray(shown)[numpy.isfinite(shown)]
    if not len(shown):
        raise ValueError(f"tensions: no tension of {group}{when} is known")
    axes = _axes(axes)
    axes.hist(shown, bins=bins)
    axes.set_xlabel(_with_unit(f"tension of {group}{when}", units["force"]))
    axes.set_ylabel("members")
    return axes


@description.tells_names
def modes(result: "Modes", number: int = 0, scale: float | None = None, axes=None):  # noqa: F821
    """Draws the shape of a mode over the state of rest: in the plane in which it lies, else in space. Returns the axes.

    scale  factor of the shape, whose q'Mq is 1; None: the largest deflection is a tenth of the size
    """
    if not -len(result.omega) <= number < len(result.omega):
        raise IndexError(f"modes: number: there are {len(result.omega)} modes, counted from 0, found {number}")
    rest, shape = result.positions, result.shapes[number]
    size, largest = numpy.ptp(rest, axis=0).max(), abs(shape).max()
    moved = rest + (0.1 * (size or 1.0) / largest if scale is None else scale) * shape
    spans = numpy.ptp(numpy.concatenate([rest, moved]), axis=0)
    is_space = (spans > 1e-6 * spans.max()).all() if axes is None else hasattr(axes, "zaxis")
    seen = [0, 1, 2] if is_space else sorted(numpy.argsort(-spans, kind="stable")[:2])
    axes = _axes(axes, **({"projection": "3d"} if is_space else {}))
    pairs = _pairs_of(result.system)
    units = _core._letters(result.system)
    rate = f"rad/{units['time']}" if units["time"] else ""
    for points, colour, label in ((rest, "0.7", "rest"), (moved, "C0", f"omega = {result.omega[number]:.6g} {rate}".rstrip())):
        lines = numpy.full((len(pairs), 3, 3), numpy.nan)  # a gap after each rod
        lines[:, :2] = points[pairs]
        axes.plot(*lines.reshape(-1, 3)[:, seen].T, "-", color=colour)
        axes.plot(*points[:, seen].T, "o", color=colour, markersize=3, label=label)
    for name, axis in zip("xyz", seen):
        getattr(axes, f"set_{name}label")(_with_unit("xyz"[axis], units["length"]))
    axes.set_aspect("equal")
    axes.legend()
    return axes


@description.tells_names
def error_time(file: str | os.PathLike, axes=None):
    """Draws error against seconds of each method from an `error_time.csv` of `tanor error-time`. Returns the axes."""
    axes = _axes(axes)
    curves: dict[str, list] = {}
    unit = ""
    with open(file, newline="", encoding="utf-8") as table:
        for row in csv.DictReader(table):
            if not {"method", "wall_s", "trouble"} <= set(row) or not {"error", "error_m"} & set(row):
                raise ValueError(f"error_time: {os.fspath(file)} is no table of tanor error-time: it has the columns {', '.join(map(str, row))}")
            is_old = "error_m" in row  # tables of 0.2
            error = float(row["error_m" if is_old else "error"] or "nan")
            unit = "m" if is_old else row.get("unit_of_length", unit)
            if not row["trouble"] and error > 0:
                curves.setdefault(row["method"], []).append((float(row["wall_s"]), error))
    for method, points in curves.items():
        axes.loglog(*numpy.array(points).T, "o-", label=method)
    axes.set_xlabel("seconds")
    axes.set_ylabel(_with_unit("error", unit))
    axes.legend()
    return axes


def _pairs_of(system: "System | Scene") -> numpy.ndarray:  # noqa: F821
    """The pairs of points [k, 2] that rods, springs and bonds join."""
    system = getattr(system, "system", system)
    pairs = [numpy.reshape(getattr(group, "pairs", ()), (-1, 2)) for group in (*system.constraints, *system.forces)]
    pairs = numpy.concatenate([numpy.zeros((0, 2), int), *pairs]).astype(int)
    return pairs[((pairs >= 0) & (pairs < len(system.positions))).all(axis=1)]  # a system that is not valid is looked at, too


def picture_of(system: "System | Scene", positions: numpy.ndarray | None = None, size: int = 320) -> str:  # noqa: F821
    """A system as a small SVG, at other positions [n, 3] if they are given: along y, or along z where all lie in the plane of x and y.

    Of many thousands some two thousand are drawn.
    """
    most = 2000
    positions = numpy.asarray(getattr(system, "system", system).positions if positions is None else positions, float).reshape(-1, 3)
    if len(positions) == 0:
        return ""
    low, high = positions.min(axis=0), positions.max(axis=0)
    axes = [0, 1] if high[2] - low[2] < 1e-9 * (high - low).max() else [0, 2]
    extent = float(max((high - low)[axes].max(), 1e-300))
    at = (positions - 0.5 * (low + high))[:, axes] / extent * [0.9 * size, -0.9 * size] + 0.5 * size
    rods = _pairs_of(system)
    lines = "".join(f'<path d="M{at[i][0]:.1f} {at[i][1]:.1f}L{at[j][0]:.1f} {at[j][1]:.1f}"/>' for i, j in rods[:: max(1, len(rods) // most)])
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2"/>' for x, y in at[:: max(1, len(at) // most)])
    return (f'<svg width="{size}" height="{size}" viewBox="0 0 {size} {size}" fill="currentColor">'
            f'<g stroke="#888">{lines}</g>{dots}</svg>')
