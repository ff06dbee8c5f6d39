#!/usr/bin/python3
"""How much of a step do the tensions of all rods at every step cost? Runs scenes with and without them, in turn.

    observables.py TANOR SCENE... [--rounds 9] [--steps 60] [--instructions] [--most PERCENT]

TANOR is the program. Each scene runs with its own method on one thread; processor seconds of a run of one step are taken
off. Prints the median time of a step without observables and the median ratio, less 1. With --instructions it counts
them under valgrind, once, which says the same on busy machines. Exit code 1 if a ratio is above --most.
"""

import argparse
import json
import os
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("tanor")
parser.add_argument("scenes", nargs="+", type=pathlib.Path)
parser.add_argument("--rounds", type=int, default=9)
parser.add_argument("--steps", type=int, default=60)
parser.add_argument("--instructions", action="store_true")
parser.add_argument("--most", type=float, default=float("inf"))
options = parser.parse_args()


def run(arguments: list) -> float:
    """Processor seconds of a program, or the instructions that it takes."""
    if options.instructions:
        counted = subprocess.run(["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", *arguments],
                                 check=True, capture_output=True, text=True)
        return float(re.search(r"I +refs: +([\d,]+)", counted.stderr)[1].replace(",", ""))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(arguments, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def cost(scene: dict, folder: pathlib.Path, beside: pathlib.Path, steps: int, observe: list) -> float:
    """What a run takes that is as long as so many steps."""
    motion = scene["motion"] | {"t_end": steps * scene["motion"]["step"]}
    motion.pop("output_every", None)
    file = beside / f".observables_{os.getpid()}.json"
    file.write_text(json.dumps(scene | {"motion": motion, "observe": observe,
                                "solver": scene.get("solver", {}) | {"certificate": "off"}}))
    try:
        return run([options.tanor, "run", file, "--out", folder / "out", "--overwrite", "--quiet", "--threads", "1"])
    finally:
        file.unlink()


is_dear = False
with tempfile.TemporaryDirectory() as name:
    for path in options.scenes:
        scene = json.loads(path.read_text())
        plain, ratios = [], []
        for _ in range(1 if options.instructions else options.rounds):
            what = [{"what": "each tension(rods)", "every_step": True}]
            one_step, bare, one_step_observed, observed = (
                cost(scene, pathlib.Path(name), path.parent, steps, observe)
                for observe in ([], what) for steps in (1, 1 + options.steps))
            plain.append((bare - one_step) / options.steps)
            ratios.append((observed - one_step_observed) / (bare - one_step))
        extra = 100 * (statistics.median(ratios) - 1)
        step = statistics.median(plain)
        said = f"{step:.3g} instructions" if options.instructions else f"{1e3 * step:.2f} ms"
        print(f"{path.stem}, {scene['motion']['method']}: {said} a step, observables {extra:+.1f} %", flush=True)
        is_dear |= not extra <= options.most
sys.exit(int(is_dear))
