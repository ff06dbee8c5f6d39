#!/usr/bin/python3
"""What the measured evaluations would cost on 64 cores and with 1e9 points, by a model that the page states.

    extrapolate.py LINEAR_SOLVERS.json SET_UP.json
"""

import json
import math
import sys

from tabulate_linear_solvers import bytes_in_words, processor, slope

CORES = 64
CHANNELS, CHANNEL_PEAK, SHARE_OF_PEAK = 12, 38.4e9, 0.75  # DDR5-4800; of it the triad sees three quarters
SIZES = (1e6, 1e7, 1e8, 1e9)
MOST_COUNTED, PRODUCTS_A_ROD = 2**31 - 1, 5  # products of S, counted by int: ten at a point where four rods of a net meet
BUNDLED = 32  # chains: two threads each


def seconds_in_words(seconds: float) -> str:
    if seconds >= 1:
        return f"{seconds:.2g} s" if seconds < 100 else f"{seconds:.0f} s"
    return f"{1e3 * seconds:.3g} ms"


def family(rows: list, name: str) -> list:
    return sorted((row for row in rows if row["scene"].split()[0] == name), key=lambda row: row["members"])


def stream_seconds(row: dict, members: float, cores: int) -> float:
    """Of an evaluation whose rods share nothing but the memory."""
    alone = 1e-9 * row["ours_ns"] * members / cores
    shared = row["bytes"] * members / (CHANNELS * CHANNEL_PEAK * SHARE_OF_PEAK)
    return max(alone, shared)


def bytes_each(set_up: list, scene: str) -> float:
    return next(row["bytes"] for row in set_up if row["scene"].startswith(scene) and row["method"] == "rattle")


def print_streams(rows: list, set_up: list) -> None:
    print("\n## Chains, clusters, beads\n")
    print("| scenes | members | 1 core | 64 cores | bound by | memory with rattle |\n|---|--:|--:|--:|---|--:|")
    for name, scene, title, cores in (("chain", "chain 1e6", "one chain (2 threads at most)", 2),
                                      ("chain", "chain 1e6", f"{BUNDLED} chains or more", CORES),
                                      ("clusters", "clusters", "clusters of 10 rods", CORES),
                                      ("spheres", "spheres", "beads on spheres", CORES)):
        members = family(rows, name)
        if not members:
            continue
        row = members[-1]
        for size in SIZES:
            one, many = stream_seconds(row, size, 1), stream_seconds(row, size, cores)
            is_shared = many > 1e-9 * row["ours_ns"] * size / cores
            print(f"| {title} | {size:.0e} | {seconds_in_words(one)} | {seconds_in_words(many)} "
                  f'| {"the channels" if is_shared else "the cores"} | {bytes_in_words(size * bytes_each(set_up, scene))} |')


def print_nets(rows: list, set_up: list, dense: float) -> None:
    nets = family(rows, "net")
    if len(nets) < 2:
        return
    last = nets[-1]
    flops_exponent = slope([(row["members"], row["flops"]) for row in nets])
    # nnz(L) a rod grows as a + b log2 N (nested dissection of a plane)
    first = nets[0]
    growth = (last["factor_nonzeros"] - first["factor_nonzeros"]) / math.log2(last["members"] / first["members"])
    share = last["flops"] / (1e-9 * last["ours_ns"]) / dense

    def nonzeros(members: float) -> float:
        return members * (last["factor_nonzeros"] + growth * math.log2(members / last["members"]))

    print("\n## One net\n")
    print(f"Flops of the factorization a rod ~ N^{flops_exponent:.2f} (fitted to the {len(nets)} nets; 0.5 in theory), at the "
          f"{100 * share:.0f} % of dgemm that the largest net reaches, on one core;")
    print("more threads share a net (fronts.md has what two gain). nnz(L) a rod = "
          f'{last["factor_nonzeros"]:.0f} + {growth:.1f} log2(N/{last["members"]:.1g}).\n')
    print("| rods | evaluation | nnz(L) | memory with rattle |\n|--:|--:|--:|--:|")
    fixed = bytes_each(set_up, "net") - 8.0 * last["factor_nonzeros"]
    for size in SIZES:
        flops = last["flops"] * (size / last["members"]) ** flops_exponent * size
        seconds, entries = flops / (share * dense), nonzeros(size)
        if size * PRODUCTS_A_ROD > MOST_COUNTED:
            print(f"| {size:.0e} | refused | {entries:.1e} | |")
        else:
            print(f"| {size:.0e} | {seconds_in_words(seconds)} | {entries:.1e} | {bytes_in_words(fixed * size + 8.0 * entries)} |")
    print(f"\nAbove about {MOST_COUNTED / PRODUCTS_A_ROD:.0e} rods S has more than 2^31 - 1 products: such a net is refused with that "
          "number. Many nets")
    print("side by side are factorized in up to 16 parts, side by side as well.")


def main() -> None:
    with open(sys.argv[1], encoding="utf-8") as file:
        evaluations = json.load(file)
    with open(sys.argv[2], encoding="utf-8") as file:
        set_up = json.load(file)
    rows, machine = evaluations["rows"], evaluations["machine"]
    together = CHANNELS * CHANNEL_PEAK * SHARE_OF_PEAK
    print("# 64 cores, 1e9 points: an extrapolation\n")
    print("Nothing on this page was run at these sizes; `bench/extrapolate.py` makes it from `linear_solvers.json` and "
          "`set_up.json`.\n")
    print(f'Measured (on {processor()}, {machine["cores"]} cores): nanoseconds and bytes a member at the largest size '
          'of each')
    print("family, flops and nonzeros of L of the nets, the speed of dgemm, bytes a member with rattle.\n")
    print(f"Assumed: {CORES} cores, each as fast as the measured one; {CHANNELS} memory channels of {CHANNEL_PEAK / 1e9:.1f} GB/s, of "
          f"which a program sees {SHARE_OF_PEAK:.0%} as the")
    print(f"triad counts ({together / 1e9:.0f} GB/s together); pages beside the cores that use them; no time for "
          "starting and")
    print("joining threads; time a member does not grow beyond the largest measured size, where all arrays are "
          "outside the")
    print("caches already; 1e9 members are counted by int (2^31 - 1 is the limit), which was tried up to 1e7 only.\n")
    print("    chains, clusters, beads:  t = N max(t_member/cores, bytes/bandwidth of all channels)")
    print("    one net:                  t = flops(N)/(share of dgemm x dgemm)")
    print("    memory:                   bytes a member x N")
    print_streams(rows, set_up)
    print_nets(rows, set_up, machine["dense_flops"])


if __name__ == "__main__":
    main()
