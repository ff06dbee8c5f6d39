#!/usr/bin/python3
"""A page of what `build/bench/ways --json FILE` measured.

    tabulate_ways.py FILE
"""

import collections
import datetime
import json
import math
import os
import platform
import sys


def processor() -> str:
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def exponent(rows: list) -> float:
    """Slope of log(time of an evaluation) in log(members), least squares."""
    x = [math.log(row["members"]) for row in rows]
    y = [math.log(row["members"] * row["ours_ns"]) for row in rows]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)


def main() -> None:
    with open(sys.argv[1], encoding="utf-8") as file:
        rows = json.load(file)
    print("# One evaluation on each way\n")
    print(f"Measured {datetime.date.today()} on {processor()}, load {os.getloadavg()[0]:.2f}; repeat with `scripts/bench`.")
    print("Nanoseconds a rod (or bead), one thread, medians of runs taken in turn: evaluate, assemble, factorize, solve, w.")
    print("Eigen: what anybody would write first (`bench/eigen_baseline.hpp`); general: assembly + CHOLMOD.\n")
    print("| scene | way | Eigen | general | ours | Eigen/ours | wanted | | 2 threads |\n|---|---|--:|--:|--:|--:|--:|---|--:|")
    for row in rows:
        held = "" if row["bar"] == 0 else "held" if row["ratio"] >= row["bar"] else "**missed**"
        wanted = f'{row["bar"]:g}' if row["bar"] > 0 else ""
        speedup = "" if row["speedup"] is None else f'{row["speedup"]:.2f}x'
        print(f'| {row["scene"]} | {row["way"]} | {row["eigen_ns"]:.0f} | {row["general_ns"]:.0f} | {row["ours_ns"]:.1f} '
              f'| {row["ratio"]:.1f} | {wanted} | {held} | {speedup} |')
    families = collections.defaultdict(list)
    for row in rows:
        families[row["scene"].split()[0]].append(row)
    print("\nTime of an evaluation ~ size^p:\n\n| scenes | p |\n|---|--:|")
    for name, members in families.items():
        if len({row["members"] for row in members}) > 1:
            print(f"| {name} | {exponent(members):.2f} |")


if __name__ == "__main__":
    main()
