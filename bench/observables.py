#!/usr/bin/python3
"""How much of a step do the tensions of all rods at every step cost? Runs scenes with and without them, in turn.

    observables.py TANOR SCENE... [--rounds 9] [--steps 60]

TANOR is the program. Each scene runs with its own method on one thread; processor seconds of a run of one step are taken
off. Prints the median time of a step without observables and the median ratio, less 1.
"""

import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("tanor")
parser.add_argument("scenes", nargs="+", type=pathlib.Path)
parser.add_argument("--rounds", type=int, default=9)
parser.add_argument("--steps", type=int, default=60)
options = parser.parse_args()


def seconds(scene: dict, folder: pathlib.Path, beside: pathlib.Path, steps: int, observe: list) -> float:
    """Processor seconds of a run as long as so many steps."""
    motion = scene["motion"] | {"t_end": steps * scene["motion"]["step"]}
    motion.pop("output_every", None)
    file = beside / f".observables_{os.getpid()}.json"
    file.write_text(json.dumps(scene | {"motion": motion, "observe": observe,
                                "solver": scene.get("solver", {}) | {"certificate": "off"}}))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        subprocess.run([options.tanor, "run", file, "--out", folder / "out", "--overwrite", "--quiet", "--threads", "1"], check=True)
    finally:
        file.unlink()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


with tempfile.TemporaryDirectory() as name:
    for path in options.scenes:
        scene = json.loads(path.read_text())
        plain, ratios = [], []
        for _ in range(options.rounds):
            what = [{"what": "each tension(rods)", "every_step": True}]
            one_step, bare, one_step_observed, observed = (
                seconds(scene, pathlib.Path(name), path.parent, steps, observe)
                for observe in ([], what) for steps in (1, 1 + options.steps))
            plain.append((bare - one_step) / options.steps)
            ratios.append((observed - one_step_observed) / (bare - one_step))
        print(f"{path.stem}, {scene['motion']['method']}: {1e3 * statistics.median(plain):.2f} ms a step, observables "
              f"{100 * (statistics.median(ratios) - 1):+.1f} %", flush=True)
