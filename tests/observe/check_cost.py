#!/usr/bin/python3
"""Checks that the tensions of all rods at every step of a melt cost one substitution: at most 10 % of a step's instructions.

    check_cost.py TANOR BENCH DIRECTORY

BENCH is bench/observables.py, which measures them in seconds, too: below 5 %, since forces of pairs wait for square roots
and quotients and substitutions do not. A solve anew would be 30 % here. The melt is small, so that valgrind runs it in
seconds: 64 chains of 20 beads, side by side in a periodic box at the density of a melt. Exit code 77 without valgrind.
"""

import json
import pathlib
import random
import shutil
import subprocess
import sys

tanor, bench, folder = map(pathlib.Path, sys.argv[1:4])
if not shutil.which("valgrind"):
    sys.exit(77)
folder.mkdir(parents=True, exist_ok=True)
side, beads, bond, gap = 8, 20, 0.97, 1.11
generator = random.Random(1)
positions = [[(k + 0.5) * bond, (i + 0.5) * gap, (j + 0.5) * gap] for i in range(side) for j in range(side) for k in range(beads)]
velocities = [[0.0, generator.gauss(0, 1), generator.gauss(0, 1)] for _ in positions]
pairs = [[i, i + 1] for i in range(len(positions)) if (i + 1) % beads]
scene = {
    "tanor_scene": 1,
    "name": "small melt",
    "points": {"positions": positions, "velocities": velocities, "masses": 1},
    "constraints": [{"kind": "rod", "name": "rods", "pairs": pairs}],
    "forces": [{"kind": "pair", "law": "wca", "epsilon": 1, "sigma": 1, "exclude": "rods",
                "box": [(beads + 1) * bond, side * gap, side * gap]}],
    "motion": {"method": "rattle", "step": 0.004, "start": "project", "t_end": 1},
}
path = folder / "small_melt.json"
path.write_text(json.dumps(scene))
sys.exit(subprocess.run([sys.executable, bench, tanor, path, "--instructions", "--steps", "20", "--most", "10"]).returncode)
