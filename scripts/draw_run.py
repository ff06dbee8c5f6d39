#!/usr/bin/python3
"""Draws frames of a run as one picture: rods as lines, coloured by their tension.

    draw_run.py RUN_FOLDER PICTURE.svg [--frames 0,2,4] [--axes xz] [--shift 1.2]

Frames stand side by side, `--shift` apart (in units of the scene's width; 0: on top of each other).
"""

import argparse
import pathlib
import re
import struct
from typing import NamedTuple


class Frame(NamedTuple):
    time: float
    points: list   # (x, y, z)
    rods: list     # (i, j)
    tensions: list


def read_frame(path: pathlib.Path) -> Frame:
    """A .vtp file of ours: XML header, then raw arrays, each behind its size (UInt64)."""
    data = path.read_bytes()
    start = data.index(b"_", data.index(b'<AppendedData encoding="raw">')) + 1
    header = data[:start].decode("ascii")

    def array(name: str, section: str, kind: str) -> tuple:
        block = header[header.index(f"<{section}"):]
        offset = int(re.search(rf'Name="{name}"[^>]*offset="(\d+)"', block).group(1))
        size, = struct.unpack_from("<Q", data, start + offset)
        return struct.unpack_from(f"<{size // struct.calcsize(kind)}{kind}", data, start + offset + 8)

    time = float(re.search(r'Name="TimeValue"[^>]*>([^<]*)<', header).group(1))
    coordinates = array("position", "Points>", "d")
    ends = array("connectivity", "Lines>", "i")
    return Frame(time, list(zip(*[iter(coordinates)] * 3)), list(zip(*[iter(ends)] * 2)),
                 list(array("tension", "CellData", "d")))


def color(fraction: float) -> str:
    """Blue (pushed or slack) over grey to red (pulled most)."""
    low, middle, high = (43, 108, 176), (170, 170, 170), (197, 48, 48)
    a, b, f = (low, middle, 2 * fraction) if fraction < 0.5 else (middle, high, 2 * fraction - 1)
    return "#" + "".join(f"{round(p + f * (q - p)):02x}" for p, q in zip(a, b))


def draw(frames: list, axes: str, shift: float, width: float = 900.0) -> str:
    across, up = ("xyz".index(axis) for axis in axes)
    least = min(point[across] for frame in frames for point in frame.points)
    most = max(point[across] for frame in frames for point in frame.points)
    low = min(point[up] for frame in frames for point in frame.points)
    high = max(point[up] for frame in frames for point in frame.points)
    step = shift * (most - least)
    margin, text = 20.0, 24.0
    scale = (width - 2 * margin) / (most - least + step * (len(frames) - 1))
    height = 2 * margin + text + scale * (high - low)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
             f'font-family="sans-serif" font-size="14">',
             f'<rect width="{width:.0f}" height="{height:.0f}" fill="white"/>']
    for k, frame in enumerate(frames):
        place = [(margin + scale * (p[across] - least + k * step), margin + scale * (high - p[up]))
                 for p in frame.points]
        strongest = sorted(abs(t) for t in frame.tensions)[int(0.98 * (len(frame.tensions) - 1))] or 1.0
        for (i, j), tension in zip(frame.rods, frame.tensions):
            fraction = min(1.0, max(0.0, 0.5 + 0.5 * tension / strongest))
            parts.append('<path d="M{:.1f} {:.1f}L{:.1f} {:.1f}" stroke="{}"/>'.format(
                *place[i], *place[j], color(fraction)))
        parts.append(f'<text x="{margin + k * step * scale:.0f}" y="{height - margin / 2:.0f}">'
                     f't = {frame.time:.3g} s</text>')
    return "\n".join(parts) + "\n</svg>\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=pathlib.Path)
    parser.add_argument("picture", type=pathlib.Path)
    parser.add_argument("--frames", help="numbers, comma separated; default: all")
    parser.add_argument("--axes", default="xz")
    parser.add_argument("--shift", type=float, default=1.1)
    options = parser.parse_args()
    paths = sorted((options.run / "trajectory").glob("frame_*.vtp"))
    if options.frames:
        paths = [paths[int(k)] for k in options.frames.split(",")]
    options.picture.write_text(draw([read_frame(path) for path in paths], options.axes, options.shift))


if __name__ == "__main__":
    main()
