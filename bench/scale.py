#!/usr/bin/python3
"""The model of docs/parallel.md: what a factorization, a solve and a step cost on P ranks, and what they tell each other;
checked against bench/ranks on 1 and 2 ranks here, and carried on to 1e4 ranks and 1e9 points.

    scale.py [BENCH_RANKS]      with the program: measures nets and lattices on 1 and 2 ranks beside the model

Islands are cut at points. With n points on a rank, in d dimensions, a piece has about c n^((d-1)/d) cut rods on all its
sides; the front that is handed over has so many rows. Flops and numbers of L are those of nested dissection.
"""

import argparse
import math
import re
import subprocess

# One rank: measured by bench/fronts and bench/linear_solvers on one thread of the machine in bench/results.
FLOPS_PER_SECOND = {"net": 32e9, "lattice": 60e9}     # of the multifrontal factor
SOLVE_BYTES_PER_SECOND = 14e9                         # L counted twice
NS_A_ROD = {"chain": 20.0}                            # an evaluation of islands that are paths
BYTES_A_ROD = 758.0                                   # of a simulation, paths
# Between ranks: a good network.
LATENCY, BYTES_PER_SECOND = 2e-6, 12e9

SHAPES = {"net": 2, "lattice": 3}
CUT = {"net": 1.2, "lattice": 1.0}  # rods that METIS cuts, over those of a straight cut
KEPT = 2.0                          # flops that kept rows add to the fronts beside them, over their number cubed


def factor(shape, n):
    """Flops of a factorization, and numbers of L: fitted to nets of 100 to 500 and lattices of 10 to 30 a side."""
    return (20.0 * n**1.5, 10.0 * n * math.log2(n)) if shape == "net" else (7.0 * n**2, 1.55 * n ** (4 / 3))


def shared(shape, points, ranks):
    """Rods that are cut: of one piece, and of all."""
    if ranks == 1:
        return 0.0, 0.0
    d = SHAPES[shape]
    n = points / ranks
    side = n ** ((d - 1) / d)
    sides = 1.0 if ranks == 2 else 2.0 * d * (1.0 - ranks ** (-1.0 / d))
    face = points ** ((d - 1) / d) if ranks == 2 else side
    return CUT[shape] * sides * face, CUT[shape] * 0.5 * ranks * sides * face


def cost(shape, points, ranks):
    """Seconds and bytes of one factorization and one solve on each rank."""
    own, every = shared(shape, points, ranks)
    flops, numbers = factor(shape, points / ranks)
    rate = FLOPS_PER_SECOND[shape]
    eliminate = (flops + KEPT * own**3) / rate
    spread = every > 3000
    dense = every**3 / 3.0 / rate / (ranks if spread else 1)
    steps = math.ceil(math.log2(ranks)) if ranks > 1 else 0
    sent = 4.0 * own * own if spread else 4.0 * every * every
    tell = steps * LATENCY + sent * (1 if spread else max(1, steps)) / BYTES_PER_SECOND
    solve = 16.0 * numbers / SOLVE_BYTES_PER_SECOND + 4 * steps * LATENCY + 8.0 * every * steps / BYTES_PER_SECOND
    return {"shared": every, "eliminate": eliminate, "dense": dense, "tell": tell, "solve": solve,
            "bytes": sent, "memory": 8.0 * (numbers + 0.5 * own * own) + (0 if spread else 4.0 * every * every)}


def table():
    print("one island: seconds a factorization = eliminate + dense + tell\n")
    print("| island | points | ranks | shared rows | eliminate s | shared rows s | tell s | solve s | sent MB | L, C GB a rank |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    for shape, points, all_ranks in (("net", 9e4, (1, 2, 16)), ("net", 9e6, (1, 16, 256)),
                                     ("net", 1e9, (256, 10000)), ("lattice", 8e3, (1, 2, 4)),
                                     ("lattice", 1e6, (1, 16, 256)), ("lattice", 1e9, (10000,))):
        for ranks in all_ranks:
            c = cost(shape, points, ranks)
            print(f"| {shape} | {points:.0e} | {ranks} | {c['shared']:.3g} | {c['eliminate']:.2g} | {c['dense']:.2g} | "
                  f"{c['tell']:.2g} | {c['solve']:.2g} | {1e-6 * c['bytes']:.3g} | {1e-9 * c['memory']:.2g} |")
    print("\nwhole islands (chains of 1,000 rods): seconds an evaluation, with the reductions of a step of dop853\n")
    print("| points | ranks | compute s | reductions s | efficiency | GB a rank |")
    print("|--:|--:|--:|--:|--:|--:|")
    for points, all_ranks in ((1e8, (16, 256)), (1e9, (16, 256, 10000))):
        for ranks in all_ranks:
            compute = 1e-9 * NS_A_ROD["chain"] * points / ranks
            reductions = 2.0 * 2.0 * math.log2(ranks) * LATENCY
            print(f"| {points:.0e} | {ranks} | {compute:.2g} | {reductions:.2g} | {compute / (compute + reductions):.2f} "
                  f"| {1e-9 * BYTES_A_ROD * points / ranks:.3g} |")


def check(program):
    """The model's ratio of two ranks to one, rows and bytes beside what is measured."""
    print("\nmeasured beside the model (processor time of a rank's elimination over that of one rank)\n")
    print("| island | shared rows | model | own elimination | model | sent kB | model |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for shape, side in (("net", 100), ("net", 300), ("lattice", 10), ("lattice", 20)):
        line = subprocess.run(["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2", program, shape, str(side)],
                              capture_output=True, text=True, check=True).stdout
        found = re.search(r", (\d+) shared .* \(([\d.]+)\) \| factorization sends (\d+) B", line)
        points = side ** SHAPES[shape]
        one, two = cost(shape, points, 1), cost(shape, points, 2)
        print(f"| {shape} {side} | {found[1]} | {two['shared']:.0f} | {found[2]} | "
              f"{two['eliminate'] / one['eliminate']:.2f} | {int(found[3]) / 1e3:.0f} | {1e-3 * two['bytes']:.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", help="build/bench/ranks")
    arguments = parser.parse_args()
    table()
    if arguments.program:
        check(arguments.program)


main()
