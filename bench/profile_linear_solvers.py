#!/usr/bin/python3
"""Where the nanoseconds go: of an evaluation as scenes outgrow the caches, and of a step of a chain by power series.
Samples of perf, by function.

    profile_linear_solvers.py BUILD/bench/linear_solvers [SECONDS]      prints a page; nothing where there is no perf
"""

import collections
import os
import re
import shutil
import subprocess
import sys
import tempfile

from tabulate_linear_solvers import processor

FAMILIES = {"Chains": ["chain 1e3", "chain 1e4", "chain 1e5", "chain 1e6"],
            "Clusters": ["clusters 1e2 x 10", "clusters 1e3 x 10", "clusters 1e4 x 10", "clusters 1e5 x 10"],
            "Points on spheres": ["spheres 1e3", "spheres 1e4", "spheres 1e5", "spheres 1e6"],
            "Rings of one island": ["ring 1e3", "ring 1e5"]}
REMARKS = {"Chains": """Only the recurrences (`find_pivots`, `substitute_forward`, `substitute_backward`) are not side by side, a third of the time
in the caches. Eight pieces of a path in lanes would save most of that, and bring r, v, w, K and lambda in and out of lanes at
each evaluation instead: clusters, and the melt's chains of 99 rods, which are so computed, take as long a rod (`linear_solvers.md`).
Series keep their coefficients in lanes over all orders of a step, so they do have the pieces (`schur/group_series.hpp`).
`linear_solvers.md` has a step of `rk4`, too: about half of it are its four evaluations, the rest is what ends a step."""}
LEAST_SHOWN = 0.3  # ns
SERIES = {"an error of 1e-6 m": "1e-4", "of 1e-9 m": "1e-7"}  # relative tolerances
LEAST_OF_SERIES = 1.0  # ns


def profile(command: list, pattern: str) -> dict:
    """ns a rod by function, of those that match; "all" is the clock's."""
    with tempfile.TemporaryDirectory() as folder:
        data = os.path.join(folder, "perf.data")
        run = subprocess.run(["perf", "record", "-q", "-e", "cpu-clock:u", "-o", data, *command], check=True,
                             capture_output=True, text=True)
        each = float(run.stdout.split()[1])
        report = subprocess.run(["perf", "report", "-i", data, "--stdio", "-F", "sample,symbol"], check=True,
                                capture_output=True, text=True).stdout
    samples = collections.Counter()
    for line in report.splitlines():
        found = re.match(r"\s*(\d+)\s+\[\.\]\s+(.*)", line)
        if found and re.search(pattern, found[2]):
            samples[short_name(found[2])] += int(found[1])
    total = sum(samples.values())
    return {"all": each} | {name: each * count / total for name, count in samples.items()}


def short_name(symbol: str) -> str:
    name = re.sub(r"\(anonymous namespace\)::|tanor(_kernels)?::", "", symbol)
    inside = re.search(r"<(?:Family<.*?>::)?(\w+(?:::\w+)?)[^<]*::\{lambda", name)  # a loop of Parallel
    return inside[1] if inside else re.sub(r"\(.*|<.*|\[.*", "", name).strip()


def print_table(columns: list, profiles: list, least: float) -> None:
    names = sorted(set().union(*profiles), key=lambda name: -profiles[-1].get(name, 0.0))
    print("\n| | " + " | ".join(columns) + " |\n|---|" + "--:|" * len(columns))
    for name in names:
        if max(each.get(name, 0.0) for each in profiles) >= least:
            print(f"| {name} | " + " | ".join(f"{each.get(name, 0.0):.1f}" for each in profiles) + " |")


def main() -> None:
    if shutil.which("perf") is None:
        print("profile_linear_solvers: no perf here", file=sys.stderr)
        return
    seconds = sys.argv[2] if len(sys.argv) > 2 else "2"
    print("# Where an evaluation spends its time, by size\n")
    print(f"ns a rod by function, one thread, on {processor()}: samples of `perf record -e cpu-clock` "
          "(`bench/profile_linear_solvers.py`).")
    print("Functions whose numbers do not grow work in the first cache whatever the size (128 rods, or 8 islands, at "
          "a time).")
    print("Those that grow touch the scene's arrays first, or call for them ahead: `evaluate` (r, v; block, b), "
          "`find_pivots` and")
    print("`substitute_backward` (which call for the next rods' numbers) and `accelerate` (block, lambda; w) along paths; "
          "of bundles")
    print("what gathers, scatters and calls for sequences, and `eliminate` (factors). `linear_solvers.md` has the passes alone "
          "beside: beyond")
    print("the caches a chain's arrays take as long to pass as all its arithmetic, so exponents above 1 stay.")
    for title, scenes in FAMILIES.items():
        # What makes the scene is no part of an evaluation.
        profiles = [profile([sys.argv[1], "--repeat", seconds, scene], r"kernels::|ForwardDynamics::|Linearization::|Projector::")
                    for scene in scenes]
        print(f"\n## {title}")
        print_table(scenes, profiles, LEAST_SHOWN)
        if title in REMARKS:
            print("\n" + REMARKS[title])
    print("\n## A step by power series\n")
    print("Chain of 1000 rods released level, 1 s, at the tolerances that meet two errors (problem P1 of `rivals.md`); "
          "ns a rod")
    print("and step. `advance` and `begin` are the series themselves (`schur/group_series.hpp`), what follows is the "
          "step: sums,")
    print("projections, the acceleration at its end, error estimates.")
    print("A third of `advance` is products of coefficients, the rest elimination, substitution and the moving of points "
          "out of")
    print("the lanes. Tried without gain (each within 2 %): error ratios from the far end, fewer numbers a rod between "
          "the orders.")
    print("125 rods cost as much a rod as 1000: the size of the second cache does not matter.")
    profiles = [profile([sys.argv[1], "--series", seconds, rtol], r"tanor") for rtol in SERIES.values()]
    print_table(list(SERIES), profiles, LEAST_OF_SERIES)


if __name__ == "__main__":
    main()
