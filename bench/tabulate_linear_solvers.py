#!/usr/bin/python3
"""A page of what the benchmarks measured.

    tabulate_linear_solvers.py LINEAR_SOLVERS.json [SET_UP.json] [STEP_COST.json] [PHASES.json]      files that are not there are left out
"""

import collections
import datetime
import json
import math
import os
import platform
import sys

LONG, WANTED_OF_LONG = 1e7, 8e9  # members, bytes
SLOWER_IS_INVALID = 1.5  # times what is listed for the Eigen program
MELT = "phantom polymer melt"
LONG_CHAIN, WANTED_OF_TWO_THREADS = "chain 1e6", 1.8
WANTED_EXPONENT = {"chain": 1.05, "clusters": 1.05}


def processor() -> str:
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def slope(points: list) -> float:
    """Of log y in log x, least squares."""
    x, y = [math.log(a) for a, _ in points], [math.log(b) for _, b in points]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)


def bytes_in_words(count: float) -> str:
    for unit in ("B", "kB", "MB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} GB"


def read(name: str):
    if not os.path.exists(name):
        return None
    with open(name, encoding="utf-8") as file:
        return json.load(file)


def is_valid(row: dict) -> bool:
    return row["listed_eigen_ns"] == 0 or row["eigen_ns"] <= SLOWER_IS_INVALID * row["listed_eigen_ns"]


def verdict(row: dict) -> str:
    if not is_valid(row):
        return "**invalid**"
    if row["bar"] == 0:
        return ""
    for word, ns in (("held", row["called_ns"]), ("held inexact", row["inexact_ns"]), ("held by ours", row["ours_ns"])):
        if row["eigen_ns"] / ns >= row["bar"]:
            return word
    return "**missed**"


def print_evaluations(rows: list) -> None:
    threads = list(rows[0]["speedups"])
    print("Nanoseconds a rod (or bead), one thread, medians of runs taken in turn: evaluate, assemble, factorize, "
          "solve, w.")
    print("Called: what a host waits for, `Dynamics::solve` on its own arrays in its own order, with multipliers, three "
          "calls after\neach evaluation of the Eigen program; inexact: the same with `SolverOptions::exact` "
          "false, so that it refines no further than the Eigen program, which does not refine;\nours: without that, as steps of a Simulation "
          "take it.")
    print("Wanted is a ratio of the call; held inexact and held by ours say in which of the next columns it is reached instead.")
    print("Eigen: what anybody would write first (`bench/eigen_baseline.hpp`, -O3 -march=native; K from triplets "
          "once, then its")
    print("values; one analysis); general: assembly + sparse factors; CHOLMOD: the same, factorized and solved by CHOLMOD alone. **invalid**: the Eigen program itself was more than "
          f"{SLOWER_IS_INVALID}")
    print("times slower than is listed for it, the machine was not quiet.")
    print("Plain: for paths in natural order, one pass of scalars (`bench/path_baseline.cpp`), the plainest program that does the job.\n")
    print("| scene | linear solver | Eigen | general | CHOLMOD | called | ours | Eigen/called | Eigen/inexact | Eigen/ours | called/plain | wanted | |" + "".join(f" {n} threads |" for n in threads))
    print("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|" + "--:|" * len(threads))
    for row in rows:
        plain = f'{row["called_ns"] / row["plain_ns"]:.2f}' if row.get("plain_ns") else ""
        wanted = f'{row["bar"]:g}' if row["bar"] > 0 else ""
        cholmod = f'{row["cholmod_ns"]:.0f}' if "cholmod_ns" in row else ""
        print(f'| {row["scene"]} | {row["linear_solver"]} | {row["eigen_ns"]:.0f} | {row["general_ns"]:.0f} | {cholmod} | {row["called_ns"]:.1f} '
              f'| {row["ours_ns"]:.1f} | {row["eigen_ns"] / row["called_ns"]:.1f} | {row["eigen_ns"] / row["inexact_ns"]:.1f} | {row["ratio"]:.1f} | {plain} | {wanted} | {verdict(row)} |'
              + "".join(f' {row["speedups"][n]:.2f}x |' for n in threads))
    for row in rows:
        if row["scene"] == LONG_CHAIN and "2" in row["speedups"]:
            gain = row["speedups"]["2"]
            word = "held" if gain >= WANTED_OF_TWO_THREADS else "**missed**"
            print(f"\nOne chain of 1e6 rods by two threads: {gain:.2f} times as fast, wanted {WANTED_OF_TWO_THREADS}: {word}.")


def passes_in_words(row: dict) -> str:
    return f'{row["passes_ns"]:.1f}' if row["passes_ns"] > 0 else ""


def print_limits(machine: dict, rows: list) -> None:
    print("\n## Beside what the machine can do\n")
    levels = ", ".join(f"{bandwidth / 1e9:.0f} GB/s over {bytes_in_words(size)}"
                       for size, bandwidth in machine["bandwidth_by_bytes"])
    shared = ", ".join(f"{bandwidth / 1e9:.1f} GB/s by {threads}" for threads, bandwidth in machine["bandwidth_by_threads"])
    print(f"One thread's triad a = b + s c: {levels}; far beyond the caches {shared} threads. dgemm: "
          f'{machine["dense_flops"] / 1e9:.0f} Gflop/s.')
    print("Bytes: what one evaluation must move at least, each array of the solver once a pass (`bench/traffic.hpp`), "
          "as the triad")
    print("is counted; bandwidth: the triad's over as many bytes as the scene's arrays have, measured beside it. "
          "Flops: of the")
    print("factorization alone, over the time of the whole evaluation.")
    print("Passes alone: the same arrays moved in the same order with next to nothing computed "
          "(`bench/machine.cpp`), ns a rod.\n")
    print("| scene | arrays | bytes a rod | GB/s | of the triad | ours, ns | passes alone | flops a rod | of dgemm |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
    for row in rows:
        print(f'| {row["scene"]} | {bytes_in_words(row["working_set"])} | {row["bytes"]:.0f} '
              f'| {row["bytes"] / row["ours_ns"]:.1f} | {100 * row["of_bandwidth"]:.0f} % | {row["ours_ns"]:.1f} '
              f'| {passes_in_words(row)} | {row["flops"]:.0f} '
              f'| {100 * row["of_dense"]:.0f} % |')


def print_exponents(rows: list) -> None:
    families = collections.defaultdict(list)
    for row in rows:
        families[row["scene"].split()[0]].append(row)
    print("\n## Cost in size\n")
    print("Time of an evaluation ~ size^p, beside what memory alone makes of it: a is the time a rod at the smallest "
          "size without")
    print("its passes, m the passes alone at each size. One after the other: a + m; overlapped without a gap: the "
          "larger of a + m")
    print("of the smallest size and m. What p is above the first is traffic that waits longer between arithmetic "
          "than in a loop")
    print("of its own; `profile.md` shows in which functions. Nets and lattices have fill besides: flops a rod ~ "
          "N^(1/2), N.\n")
    print("| scenes | sizes | p | wanted | | one after the other | overlapped | passes alone | bytes/bandwidth |\n"
          "|---|---|--:|--:|---|" + "--:|" * 4)
    for name, members in families.items():
        if len({row["members"] for row in members}) < 2:
            continue

        def exponent(ns_each) -> str:
            return f"{slope([(row['members'], row['members'] * ns_each(row)) for row in members]):.2f}"

        least = min(members, key=lambda row: row["members"])
        arithmetic = least["ours_ns"] - least["passes_ns"]
        models = ["", "", ""]
        if least["passes_ns"] > 0:
            models = [exponent(lambda row: arithmetic + row["passes_ns"]),
                      exponent(lambda row: max(least["ours_ns"], row["passes_ns"])),
                      exponent(lambda row: row["passes_ns"])]
        sizes = [row["members"] for row in members]
        p, wanted = exponent(lambda row: row["ours_ns"]), WANTED_EXPONENT.get(name)
        word = "" if wanted is None else f"{wanted} | held" if float(p) <= wanted else f"{wanted} | **missed**"
        print(f'| {name} | {min(sizes):.0e} … {max(sizes):.0e} | {p} | {word or " |"} | '
              + " | ".join(models) + f' | {exponent(lambda row: row["bytes"] / row["bandwidth"])} |')


def print_set_up(rows: list) -> None:
    print("\n## Set-up and memory\n")
    print("Constructor of a Simulation (numbering, plan, analysis, a consistent start), one thread, and what stays "
          "in memory")
    print("after two steps, the description of the system included; most: of the whole process, with the making of "
          "the scene.")
    print("The flat net hangs by two adjacent corners: the 299 rods between them depend on each other, are found and "
          "held rigid.\n")
    print("| scene | linear solver | method | seconds | wanted | | bytes a rod | in all | most |\n|---|---|---|--:|--:|---|--:|--:|--:|")
    for row in rows:
        wanted = f'{row["bar"]:g}' if row["bar"] > 0 else ""
        held = "" if row["bar"] == 0 else "held" if row["seconds"] <= row["bar"] else "**missed**"
        print(f'| {row["scene"]} | {row["linear_solver"]} | {row["method"]} | {row["seconds"]:.2f} | {wanted} | {held} '
              f'| {row["bytes"]:.0f} | {bytes_in_words(row["bytes"] * row["members"])} '
              f'| {bytes_in_words(row["most_resident"])} |')
    longest = max(rows, key=lambda row: row["members"])
    if longest["members"] >= LONG:
        most = longest["most_resident"]
        print(f'\nA chain of {longest["members"]:.0e} beads: {most / 1e9:.2f} GB ({most / 2**30:.2f} GiB) at most, wanted '
              f'{WANTED_OF_LONG / 1e9:g} GB: {"held" if most < WANTED_OF_LONG else "**missed**"}.')


def print_step_cost(rows: list) -> None:
    print("\n## Steps beside one evaluation by the Eigen program\n")
    print("ns a rod, one thread, in turn; all constraints to 1e-13 after each step, whose projections are counted. "
          "Evaluation: through")
    print("the library's `Dynamics::solve`, refined to rounding, numbers in the user's order. rk4: four evaluations and "
          "what ends a step.\n")
    print("| scene | Eigen, one evaluation | ours, one evaluation | rattle, a step | rattle/Eigen | wanted | | rk4, a step |\n"
          "|---|--:|--:|--:|--:|--:|---|--:|")
    for row in rows:
        share = row["rattle_ns"] / row["eigen_ns"]
        bar = f'0.25 | {"held" if share <= 0.25 else "**missed**"}' if row["scene"] == MELT else " |"
        print(f'| {row["scene"]} | {row["eigen_ns"]:.0f} | {row["ours_ns"]:.0f} | {row["rattle_ns"]:.0f} | {share:.2f} '
              f'| {bar} | {row["rk4_ns"]:.0f} |')
    for row in rows:
        if row["scene"] == MELT:
            print(f'\nThe melt has {row["rods"]:,} rods: {row["rods"] * row["rattle_ns"] / 1e6:.1f} ms a step of rattle.')


def print_phases(report: dict) -> None:
    print("\n## Phases of the general solver\n")
    print("Google Benchmark, ns a rod, one thread (`build/bench/phases`).\n")
    table = collections.defaultdict(dict)
    for run in report["benchmarks"]:
        phase, scene = run["name"].split("/")[:2]
        table[scene][phase] = 1e9 / run["items_per_second"]
    phases = list(next(iter(table.values())))
    print("| scene | " + " | ".join(phases) + " | sum |\n|---|" + "--:|" * (len(phases) + 1))
    for scene, times in table.items():
        print(f"| {scene} | " + " | ".join(f"{times[phase]:.1f}" for phase in phases) + f" | {sum(times.values()):.0f} |")


def main() -> None:
    evaluations, set_up, step_cost, phases = ([read(name) for name in sys.argv[1:]] + [None] * 4)[:4]
    print("# One evaluation by each linear solver\n")
    print(f"Measured {datetime.date.today()} on {processor()}, load {os.getloadavg()[0]:.2f}; repeat with "
          "`scripts/bench`.")
    print_evaluations(evaluations["rows"])
    print_limits(evaluations["machine"], evaluations["rows"])
    print_exponents(evaluations["rows"])
    for rows, show in ((set_up, print_set_up), (step_cost, print_step_cost), (phases, print_phases)):
        if rows:
            show(rows)


if __name__ == "__main__":
    main()
