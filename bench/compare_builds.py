#!/usr/bin/python3
"""Is one build slower than another? Runs both in turn, one thread, and prints the ratio NEW/OLD of each scene.

    compare_builds.py OLD NEW [--pairs 15] [--only TEXT]

OLD and NEW are checkouts with a release build in build/ (targets linear_solvers, tanor_cli). Evaluations are those of
all scenes of `linear_solvers`, own and as a host calls them (`--repeat`, `--repeat-call`), by its own clock; runs are
whole programs, by their processor time. The interval is that of
the median of the ratios, by order statistics: it covers the true median in at least 95 of 100 comparisons. A scene is
slower where the whole interval lies above 1.03; the exit code is 1 then.
"""

import argparse
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile

RUNS = {"run chain.json (dop853)": ["chain.json", "--t-end", "60", "--method", "dop853"],
        "run chain.json (taylor)": ["chain.json", "--t-end", "60", "--method", "taylor"],
        "run chain.json (rattle)": ["chain.json", "--t-end", "60", "--method", "rattle", "--step", "1e-4"],
        "run chain.json (radau5)": ["chain.json", "--t-end", "20", "--method", "radau5"],
        "run honey.json": ["honey.json", "--t-end", "40"],
        "run rough_hoop.json (friction)": ["rough_hoop.json", "--t-end", "200"],
        "run net.json": ["net.json"],
        "run melt_generated.json": ["melt_generated.json", "--t-end", "0.02"]}
MEMORY = "/dev/shm"  # thousands of frames on a disk scatter by a tenth
SECONDS = "0.15"
LIMIT = 1.03


def list_scenes(tree: str) -> list:
    done = subprocess.run([f"{tree}/build/bench/linear_solvers", "--list"], check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


def time_evaluation(tree: str, way: str, scene: str) -> float:
    """ns a rod or bead."""
    done = subprocess.run([f"{tree}/build/bench/linear_solvers", way, SECONDS, scene], check=True, capture_output=True,
                          text=True)
    return float(done.stdout.split()[1])


def time_run(tree: str, arguments: list) -> float:
    """s of the processor, of the program and what it calls."""
    with tempfile.TemporaryDirectory(dir=MEMORY if os.path.isdir(MEMORY) else None) as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([f"{tree}/build/src/cli/tanor", "run", f"{tree}/examples/{arguments[0]}", *arguments[1:],
                        "--threads", "1", "--quiet", "--out", f"{folder}/out"], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def interval_of_median(values: list) -> tuple:
    """The shortest pair of order statistics around the median that holds it with 95 % probability."""
    values = sorted(values)
    n = len(values)
    outside, k = 0.0, 0
    while k < n // 2 and 2 * (outside + math.comb(n, k) / 2**n) <= 0.05:
        outside += math.comb(n, k) / 2**n
        k += 1
    return values[max(k - 1, 0)], values[min(n - k, n - 1)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

    measures = {name + end: (lambda tree, way=way, name=name: time_evaluation(tree, way, name))
                for name in list_scenes(options.new) for way, end in (("--repeat", ""), ("--repeat-call", ", called"))}
    measures |= {name: (lambda tree, run=run: time_run(tree, run)) for name, run in RUNS.items()}
    slower = []
    print("| scene | median new/old | 95 % interval |\n|---|---:|---:|")
    for name, measure in measures.items():
        if options.only not in name:
            continue
        ratios = []
        for pair in range(options.pairs):  # each goes first in every other pair
            trees = [options.old, options.new] if pair % 2 == 0 else [options.new, options.old]
            times = {tree: measure(tree) for tree in trees}
            ratios.append(times[options.new] / times[options.old])
        low, high = interval_of_median(ratios)
        print(f"| {name} | {statistics.median(ratios):.3f} | {low:.3f} – {high:.3f} |", flush=True)
        if low > LIMIT:
            slower.append(name)
    print(f"\n{options.pairs} pairs a scene; slower: {', '.join(slower) or 'none'}")
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
