#!/usr/bin/python3
"""Pictures of what scripts/bench, scripts/error-time and bench/rivals measured, by matplotlib (Debian: python3-matplotlib).

    draw_results.py [FOLDER]     default bench/results

Writes FOLDER/error_time/*/error_time.svg (error against wall time, a line a method), FOLDER/linear_solvers.svg (time
of a solve beside Eigen's and the general solver's) and FOLDER/rivals_PROBLEM.svg (error against time of all programs). Colours are those of Okabe and Ito, which colour-blind readers tell
apart; lines also differ by marks, and all is readable at half its size.
"""

import csv
import json
import math
import pathlib
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402: the backend comes first

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bench/rivals"))
from compare import PROBLEMS  # noqa: E402

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#56B4E9", "#E69F00", "#7F7F7F", "#B2A800", "#44307A"]
MARKS = ["o", "s", "^", "D", "v", "P", "X", "<", ">", "*"]
plt.rcParams.update({
    "font.size": 17, "axes.linewidth": 1.2, "lines.linewidth": 2.4, "lines.markersize": 9, "legend.frameon": False,
    "figure.figsize": (10, 6.5), "figure.constrained_layout.use": True, "savefig.facecolor": "white",
    "svg.hashsalt": "tanor", "svg.fonttype": "path"})


def save(figure: plt.Figure, path: pathlib.Path) -> None:
    figure.savefig(path, metadata={"Date": None})  # equal numbers are equal files
    plt.close(figure)
    print(path)


def draw_error_time(table: pathlib.Path) -> None:
    with open(table, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if not row["trouble"] and row["error"]]
    figure, axes = plt.subplots()
    for k, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        points = [(float(row["wall_s"]), float(row["error"])) for row in rows
                  if row["method"] == method and float(row["error"]) > 0]
        axes.loglog(*zip(*points), label=method, color=COLOURS[k % 10], marker=MARKS[k % 10])
    references = [float(row["reference_error"]) for row in rows if row["reference_error"]]
    if references:
        axes.axhspan(axes.get_ylim()[0], 3 * max(references), color="#e8e8e8", zorder=0)
        axes.text(0.99, 0.01, "grey: within 3 errors of the reference", transform=axes.transAxes, ha="right",
                  va="bottom", fontsize=13)
    axes.set(title=f"{table.parent.name}: error against run time", xlabel="wall time, s",
             ylabel="largest error at the end, m")
    axes.grid(True, which="major", color="#dddddd")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(figure, table.with_name("error_time.svg"))


def find_front(points: list) -> list:
    """(time, error) from coarse to fine, without what is neither faster nor finer than another one."""
    front = []
    for time, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((time, error))
    return front


def draw_rivals(table: pathlib.Path) -> None:
    with open(table, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["error"] and row["seconds"] and 0 < float(row["error"]) < math.inf]
    for problem in dict.fromkeys(row["problem"] for row in rows):
        figure, axes = plt.subplots(figsize=(11, 6.5))
        groups = list(dict.fromkeys(row["group"] for row in rows if row["problem"] == problem))
        own = [group for group in groups if group.startswith("tanor")]
        for others, filled in ((own, True), ([group for group in groups if group not in own], False)):
            for k, group in enumerate(others):
                front = find_front([(float(row["seconds"]), float(row["error"])) for row in rows
                                    if (row["problem"], row["group"]) == (problem, group)])
                axes.loglog(*zip(*front), label=group, color=COLOURS[k % 10], marker=MARKS[k % 10],
                            linestyle="-" if filled else "--", linewidth=3.2 if filled else 1.8,
                            markerfacecolor=COLOURS[k % 10] if filled else "white")
        axes.set(title=f"{PROBLEMS[problem].title}: tanor (solid) and other programs", xlabel="processor time, s", ylabel="largest error, m")
        axes.grid(True, which="major", color="#dddddd")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        save(figure, table.with_name(f"rivals_{problem}.svg"))


def draw_linear_solvers(table: pathlib.Path) -> None:
    rows = json.loads(table.read_text(encoding="utf-8"))["rows"]
    figure, axes = plt.subplots(figsize=(10, 1.5 + 0.42 * len(rows)))
    for key, name, colour, mark in (("eigen_ns", "plain Eigen program", COLOURS[1], "s"),
                                    ("general_ns", "general solver", COLOURS[0], "^"),
                                    ("ours_ns", "chosen solver", COLOURS[4], "o")):
        points = [(row[key], k) for k, row in enumerate(rows) if row.get(key)]
        if points:
            axes.plot(*zip(*points), mark, color=colour, label=name)
    axes.set_yticks(range(len(rows)), [f"{row['scene']} ({row['linear_solver']})" for row in rows], fontsize=14)
    axes.set(xscale="log", xlabel="time for each constraint, ns")
    axes.invert_yaxis()
    axes.grid(True, which="major", color="#dddddd")
    figure.legend(loc="upper center", ncol=3, columnspacing=1.0, handletextpad=0.2, fontsize=15)
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.955))  # below the legend
    save(figure, table.with_suffix(".svg"))


def main() -> None:
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "bench/results")
    for table in sorted(folder.glob("error_time/*/error_time.csv")):
        draw_error_time(table)
    if (folder / "linear_solvers.json").exists():
        draw_linear_solvers(folder / "linear_solvers.json")
    if (folder / "rivals.csv").exists():
        draw_rivals(folder / "rivals.csv")


if __name__ == "__main__":
    main()
