#!/usr/bin/python3
"""Where the nanoseconds of an evaluation go as scenes outgrow the caches: samples of perf, by function and size.

    profile_ways.py BUILD/bench/ways [SECONDS]      prints a page; nothing where there is no perf
"""

import collections
import os
import re
import shutil
import subprocess
import sys
import tempfile

from tabulate_ways import processor

FAMILIES = {"Chains": ["chain 1e3", "chain 1e4", "chain 1e5", "chain 1e6"],
            "Clusters": ["clusters 1e2 x 10", "clusters 1e3 x 10", "clusters 1e4 x 10", "clusters 1e5 x 10"]}
LEAST_SHOWN = 0.3  # ns


def profile(program: str, scene: str, seconds: str) -> dict:
    """ns a rod by function; "all" is the clock's."""
    with tempfile.TemporaryDirectory() as folder:
        data = os.path.join(folder, "perf.data")
        run = subprocess.run(["perf", "record", "-q", "-e", "cpu-clock:u", "-o", data, program, "--repeat", seconds, scene],
                             check=True, capture_output=True, text=True)
        each = float(run.stdout.split()[1])
        report = subprocess.run(["perf", "report", "-i", data, "--stdio", "-F", "sample,symbol"], check=True,
                                capture_output=True, text=True).stdout
    samples = collections.Counter()
    for line in report.splitlines():
        found = re.match(r"\s*(\d+)\s+\[\.\]\s+(.*)", line)
        # What makes the scene is no part of an evaluation.
        if found and re.search(r"kernels::|Sweep::|NormalForm::", found[2]):
            samples[re.sub(r"\(.*|tanor(_kernels)?::|\[.*", "", found[2]).strip()] += int(found[1])
    total = sum(samples.values())
    return {"all": each} | {name: each * count / total for name, count in samples.items()}


def main() -> None:
    if shutil.which("perf") is None:
        print("profile_ways: no perf here", file=sys.stderr)
        return
    seconds = sys.argv[2] if len(sys.argv) > 2 else "2"
    print("# Where an evaluation spends its time, by size\n")
    print(f"ns a rod by function, one thread, on {processor()}: samples of `perf record -e cpu-clock` "
          "(`bench/profile_ways.py`).")
    print("Functions whose numbers do not grow work in the first cache whatever the size (128 rods, or 8 islands, at "
          "a time).")
    print("Those that grow touch the scene's arrays first: `evaluate` (r, v; block, b), `finish_pivots` (pivots, "
          "factors) and")
    print("`accelerate` (block, lambda; w) along paths, gathers and scatters of bundles. `ways.md` has the passes "
          "alone beside.")
    for title, scenes in FAMILIES.items():
        profiles = [profile(sys.argv[1], scene, seconds) for scene in scenes]
        names = sorted(set().union(*profiles), key=lambda name: -profiles[-1].get(name, 0.0))
        print(f"\n## {title}\n\n| | " + " | ".join(scenes) + " |\n|---|" + "--:|" * len(scenes))
        for name in names:
            if max(each.get(name, 0.0) for each in profiles) >= LEAST_SHOWN:
                print(f"| {name} | " + " | ".join(f"{each.get(name, 0.0):.1f}" for each in profiles) + " |")


if __name__ == "__main__":
    main()
