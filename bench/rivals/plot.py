#!/usr/bin/python3
"""Error against time of all programs, one picture a problem.

    plot.py FOLDER        reads FOLDER/rivals.csv, writes FOLDER/rivals_PROBLEM.svg
"""

import csv
import math
import pathlib
import sys

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 760, 480, 70, 20, 200, 50
COLOURS = ["#c00000", "#0060b0", "#008040", "#b06000", "#7030a0", "#505050", "#00a0a0", "#a0a000", "#e060a0", "#80a0e0",
           "#000000", "#c0a080", "#60c060"]


def fronts_of(rows: list) -> dict:
    """Group -> (seconds, error) from coarse to fine, without what is neither faster nor finer."""
    fronts = {}
    for group in dict.fromkeys(row["group"] for row in rows):
        front = []
        for seconds, error in sorted((row["seconds"], row["error"]) for row in rows if row["group"] == group):
            if not front or error < front[-1][1]:
                front.append((seconds, error))
        fronts[group] = front
    return fronts


def axis(values: list) -> tuple:
    """The decades that hold all values."""
    return math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))


def draw(fronts: dict) -> str:
    points = [point for front in fronts.values() for point in front]
    (x0, x1), (y0, y1) = axis([s for s, _ in points]), axis([e for _, e in points])
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def place(seconds: float, error: float) -> tuple:
        return (LEFT + wide * (math.log10(seconds) - x0) / (x1 - x0),
                TOP + high * (y1 - math.log10(error)) / (y1 - y0))

    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" '
             'font-size="12">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for x in range(x0, x1 + 1):
        at = place(10.0**x, 10.0**y0)[0]
        lines.append(f'<path d="M{at:.1f} {TOP}V{TOP + high}" stroke="#ddd"/>'
                     f'<text x="{at:.1f}" y="{TOP + high + 18}" text-anchor="middle">1e{x}</text>')
    for y in range(y0, y1 + 1, 1 if y1 - y0 <= 8 else 2):
        at = place(10.0**x0, 10.0**y)[1]
        lines.append(f'<path d="M{LEFT} {at:.1f}H{LEFT + wide}" stroke="#ddd"/>'
                     f'<text x="{LEFT - 8}" y="{at + 4:.1f}" text-anchor="end">1e{y}</text>')
    lines.append(f'<text x="{LEFT + wide / 2}" y="{HEIGHT - 10}" text-anchor="middle">processor time, s</text>'
                 f'<text transform="translate(16 {TOP + high / 2}) rotate(-90)" text-anchor="middle">error, m</text>')
    for k, (group, front) in enumerate(fronts.items()):
        colour, y = COLOURS[k % len(COLOURS)], TOP + 14 + 18 * k
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in (place(*point) for point in front))
        dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>' for x, y in (place(*point) for point in front))
        lines.append(f'<g stroke="{colour}" fill="{colour}"><polyline points="{way}" fill="none" stroke-width="2"/>{dots}'
                     f'<path d="M{WIDTH - RIGHT + 12} {y - 4}h18" stroke-width="2"/></g>'
                     f'<text x="{WIDTH - RIGHT + 36}" y="{y}">{group}</text>')
    return "\n".join(lines + ["</svg>", ""])


def draw_all(folder: pathlib.Path) -> list:
    """Names of the problems that were drawn."""
    with open(folder / "rivals.csv", newline="", encoding="utf-8") as file:
        rows = [{**row, "seconds": float(row["seconds"]), "error": float(row["error"])} for row in csv.DictReader(file)
                if row["error"] and row["seconds"] and 0.0 < float(row["error"]) < math.inf]
    names = list(dict.fromkeys(row["problem"] for row in rows))
    for name in names:
        picture = draw(fronts_of([row for row in rows if row["problem"] == name]))
        (folder / f"rivals_{name}.svg").write_text(picture, encoding="utf-8")
    return names


if __name__ == "__main__":
    draw_all(pathlib.Path(sys.argv[1]))
