#!/usr/bin/python3
"""Twice as many clusters on two ranks, against two programs side by side that know nothing of each other.

    weak_scaling.py TANOR_MPI [CLUSTERS] [ROUNDS]

CLUSTERS (5,000) chains of 10 rods a rank, rattle, 200 steps. Each round runs both, in turn; medians of wall times, and the
efficiency: independent programs over ranks.
"""

import json
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import time

# Else two programs side by side are both bound to the first core.
MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n"]


def scene(count):
    draw = random.Random(7)
    positions, pairs = [], []
    for k in range(count):
        place = [2.0 * k, 0.0, 0.0]
        for i in range(11):
            positions.append(list(place))
            if i > 0:
                pairs.append([len(positions) - 2, len(positions) - 1])
            step = [draw.gauss(0, 1) for _ in range(3)]
            length = sum(x * x for x in step) ** 0.5
            place = [x + 0.1 * d / length for x, d in zip(place, step)]
    return {"name": f"{count} clusters", "points": {"positions": positions, "masses": 0.1},
            "constraints": [{"kind": "rod", "pairs": pairs}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
            "motion": {"method": "rattle", "step": 1e-3, "t_end": 0.2}, "solver": {"certificate": "off"}}


def wall_of(commands):
    """Seconds of stepping: all of a run but set-up and output, the slowest of those side by side."""
    running = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for command, _ in commands]
    for process in running:
        if process.wait() != 0:
            sys.exit("a run failed")
    walls = [json.loads((out / "summary.json").read_text(encoding="utf-8"))["wall_s"] for _, out in commands]
    return max(wall["total"] - wall["setup"] - wall["output"] for wall in walls)


def main():
    program = sys.argv[1]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 5000
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for clusters in (count, 2 * count):
            (folder / f"{clusters}.json").write_text(json.dumps({"tanor_scene": 1} | scene(clusters)), encoding="utf-8")

        def command(ranks, clusters, out):
            return (MPIRUN + [str(ranks), program, "run", str(folder / f"{clusters}.json"), "--quiet", "--out",
                              str(folder / out)], folder / out)

        alone, together = [], []
        for _ in range(rounds):
            begin = time.monotonic()
            alone.append(wall_of([command(1, count, "a"), command(1, count, "b")]))
            together.append(wall_of([command(2, 2 * count, "c")]))
            print(f"side by side {alone[-1]:.3f} s, two ranks {together[-1]:.3f} s ({time.monotonic() - begin:.0f} s)",
                  flush=True)
        print(f"efficiency {statistics.median(alone) / statistics.median(together):.2f}")


main()
