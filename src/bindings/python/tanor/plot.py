"""Pictures of runs by matplotlib: histories, histograms of tensions, modes, error against time."""

import csv
import os

import numpy

from .runs import Trajectory


def _axes(axes):
    if axes is not None:
        return axes
    from matplotlib import pyplot
    return pyplot.subplots()[1]


def histories(run: Trajectory, names: list[str] | None = None, axes=None):
    """Draws observables over time, with their units; all of them if no names are given. Returns the axes."""
    axes = _axes(axes)
    for name in names or run.observables.dtype.names[1:]:
        values = run.observables[name].reshape(len(run.times), -1)
        unit = run.units.get(name, "")
        for k in range(min(values.shape[1], 12)):
            axes.plot(run.times, values[:, k], label=(name if values.shape[1] == 1 else f"{name} {k}") + (f" [{unit}]" if unit else ""))
    axes.set_xlabel("t")
    axes.legend()
    return axes


def tensions(run: Trajectory, group: str, time: int = -1, bins: int = 40, axes=None):
    """Draws the histogram of a group's tensions at one of the run's times. Returns the axes."""
    axes = _axes(axes)
    axes.hist(run[group].tension[time], bins=bins)
    axes.set_xlabel(f"tension of {group} at t = {run.times[time]:g}")
    axes.set_ylabel("members")
    return axes


def modes(result, number: int = 0, positions=None, scale: float = 1.0, axes=None):
    """Draws the shape of a mode over the positions of rest [n, 3], in the x-z plane. Returns the axes."""
    axes = _axes(axes)
    shape = numpy.asarray(result.shapes)[number]
    rest = numpy.zeros_like(shape) if positions is None else numpy.asarray(positions)
    axes.plot(rest[:, 0], rest[:, 2], "o", color="0.7", label="rest")
    moved = rest + scale * shape
    axes.plot(moved[:, 0], moved[:, 2], "o", label=f"omega = {numpy.asarray(result.omega)[number]:.6g}")
    axes.legend()
    return axes


def error_time(file: str | os.PathLike, axes=None):
    """Draws error against seconds of each method from an `error_time.csv` of `tanor error-time`. Returns the axes."""
    axes = _axes(axes)
    curves: dict[str, list] = {}
    with open(file, newline="", encoding="utf-8") as table:
        for row in csv.DictReader(table):
            try:
                curves.setdefault(row["method"], []).append((float(row["wall_s"]), float(row["error_m"])))
            except (KeyError, TypeError, ValueError):
                continue
    for method, points in curves.items():
        axes.loglog(*numpy.array(points).T, "o-", label=method)
    axes.set_xlabel("seconds")
    axes.set_ylabel("error")
    axes.legend()
    return axes


def picture_of(positions: numpy.ndarray, pairs: numpy.ndarray = (), size: int = 320) -> str:
    """Points [n, 3] and the rods between pairs of them as a small SVG, along y, or along z where all lie in the plane of x and y.

    Of many thousands some two thousand are drawn.
    """
    most = 2000
    positions = numpy.asarray(positions, float).reshape(-1, 3)
    low, high = positions.min(axis=0), positions.max(axis=0)
    axes = [0, 1] if high[2] - low[2] < 1e-9 * (high - low).max() else [0, 2]
    extent = float(max((high - low)[axes].max(), 1e-300))
    at = (positions - 0.5 * (low + high))[:, axes] / extent * [0.9 * size, -0.9 * size] + 0.5 * size
    rods = numpy.asarray(pairs, int).reshape(-1, 2)
    lines = "".join(f'<path d="M{at[i][0]:.1f} {at[i][1]:.1f}L{at[j][0]:.1f} {at[j][1]:.1f}"/>' for i, j in rods[:: max(1, len(rods) // most)])
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2"/>' for x, y in at[:: max(1, len(at) // most)])
    return f'<svg width="{size}" height="{size}" viewBox="0 0 {size} {size}"><g stroke="#888">{lines}</g>{dots}</svg>'
