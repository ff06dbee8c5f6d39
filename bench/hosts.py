#!/usr/bin/python3
"""What fix tanor/rods costs inside Debian's LAMMPS: the melt of its bench data.chain, 31,680 bonds, as rods.

    hosts.py BUILD [--steps N] [--trend-steps N] > bench/results/hosts.md

BUILD: a build tree with tanor_lammps. data.chain is in Debian's lammps-examples (scripts/fetch_examples). Times are
processor times of the slowest rank, so that they can be taken on a machine that others use too; medians of three runs in
turn. Then a long run, in which all bonds are looked at in every step. Exit code: 1 if one of them was off by more than
1e-12 once.
"""

import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "embed"))
import host_runs  # noqa: E402

MELT = """
units lj
atom_style bond
special_bonds fene
read_data {data}
neighbor 0.4 bin
neigh_modify every 1 delay 1
bond_style zero nocoeff
bond_coeff *
pair_style lj/cut 1.122462
pair_modify shift yes
pair_coeff 1 1 1.0 1.0 1.122462
include {register}
fix move all nve
fix rods all tanor/rods bond 1 length 0.97 {tolerance}
thermo_style custom step temp ke etotal press f_rods f_rods[1] f_rods[2] f_rods[3]
thermo_modify norm yes format float %.12g
timestep 0.004
"""


SAME = 100  # steps after which runs on several ranks are held against that on one
TIGHT = 1e-12  # of a bond, relative


class Run(host_runs.HostTest):
    """One run of the host in a folder of its own."""

    program = "lmp"
    limit = None

    def go(self, script, ranks):
        self.setUp()
        code, self.said = self.call(script, ranks)
        if code != 0:
            sys.exit(self.said[-3000:])
        self.table = host_runs.tables(self.said)[0]
        return self

    def modify_ms(self, steps):
        """Wall time a step of all fixes, by the host's own clock, mean of the ranks."""
        return 1e3 * float(re.search(r"^Modify +\| *\S+ *\| *(\S+)", self.said, re.MULTILINE)[1]) / steps


def tabulate_times(melt, steps):
    print("| ranks | fix, ms a step | in the solver | the rest | all fixes, wall | iterations | largest violation |")
    print("|--:|--:|--:|--:|--:|--:|--:|")
    script = melt + f"thermo {steps}\nrun {steps}\n"
    runs = {ranks: [] for ranks in (1, 2, 4)}
    for _ in range(3):
        for ranks, found in runs.items():
            found.append(Run().go(script, ranks))
    for ranks, found in runs.items():
        last = [run.table[-1] for run in found]
        whole, solver = (statistics.median(row[f"f_rods[{k}]"] for row in last) for k in (2, 3))
        wall = statistics.median(run.modify_ms(steps) for run in found)
        print(f"| {ranks} | {whole:.2f} | {solver:.2f} | {whole - solver:.2f} | {wall:.2f} | {last[0]['f_rods[1]']:.2f} | "
              f"{max(row['f_rods'] for row in last):.1e} |")
    return min(run.table[-1]["f_rods[2]"] for run in runs[1]), statistics.median(
        run.table[-1]["f_rods[2]"] for run in runs[1])


def compare_ranks(melt):
    """The largest differences of positions, and those of iterations, between several ranks and one."""
    script = (melt + f"thermo {SAME}\ndump d all custom {SAME} places id xu yu zu\n"
              f"dump_modify d sort id format float %.17g\nrun {SAME}\n")
    runs = {ranks: Run().go(script, ranks) for ranks in (1, 2, 4)}
    one = runs[1].atoms("places", SAME)
    for ranks in (2, 4):
        other = runs[ranks].atoms("places", SAME)
        worst = max(abs(a - b) for tag in one for a, b in zip(one[tag], other[tag]))
        more = runs[ranks].table[-1]["f_rods[1]"] - runs[1].table[-1]["f_rods[1]"]
        print(f"After {SAME} steps, positions on {ranks} ranks are those on one to {worst:.1e}; iterations a step: {more:+.2f}.")


def find_trend(energies):
    """The slope of a line through these, times their number, and its standard error from ten blocks."""
    n, blocks = len(energies), 10
    size = n // blocks
    means = [statistics.fmean(energies[k * size:(k + 1) * size]) for k in range(blocks)]
    middle = (blocks - 1) / 2
    squares = sum((k - middle) ** 2 for k in range(blocks))
    mean = statistics.fmean(means)
    slope = sum((k - middle) * (y - mean) for k, y in enumerate(means)) / squares
    left = sum((y - mean - slope * (k - middle)) ** 2 for k, y in enumerate(means))
    return slope * blocks, (left / (blocks - 2) / squares) ** 0.5 * blocks


def follow_long_run(melt, steps):
    """Looks at all bonds and at the energy in every step; returns whether the bonds held."""
    table = Run().go(melt + f"thermo 1\nrun {steps}\n", 1).table
    worst = max(row["f_rods"] for row in table)
    late = table[steps // 10:]
    energies = [row["etotal"] for row in late]
    trend, error = find_trend(energies)
    kinetic = statistics.fmean(row["ke"] for row in late)
    print(f"\nOver {steps:,} steps on one rank, looked at in every step ({len(table):,} rows): largest violation of a bond "
          f"{worst:.1e}; all within {TIGHT:.0e}:\n{'yes' if worst <= TIGHT else 'NO'}. Energy an atom after the first tenth: "
          f"mean {statistics.fmean(energies):.6f}, spread {max(energies) - min(energies):.1e}, kinetic {kinetic:.4f}.\n"
          f"A line through it rises by {trend:.1e} +- {error:.1e} over the run, {trend / kinetic:.1e} of the kinetic energy.")
    return len(table) == steps + 1 and worst <= TIGHT


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--trend-steps", type=int, default=10000)
    parser.add_argument("--tolerance", type=float, help="of the fix; without it bonds hold to rounding")
    options = parser.parse_args()
    fetched = subprocess.run([ROOT / "scripts" / "fetch_examples", "melt"], check=True, stdout=subprocess.PIPE, text=True)
    melt = MELT.format(data=fetched.stdout.strip(), register=(options.build / "src/embed/lammps/tanor.lmp").resolve(),
                       tolerance="" if options.tolerance is None else f"tolerance {options.tolerance:g}")
    rods, scaled = 31680, 51889

    print("# tanor inside LAMMPS\n")
    print(f"`bench/hosts.py build --steps {options.steps}`: the melt `data.chain` of LAMMPS 29Sep2021u2 (Debian 12), 320 "
          "chains of 100 atoms,")
    print(f"{rods:,} rods of 0.97, NVE, time step 0.004. Processor times of the slowest rank and wall times by LAMMPS' own")
    print(f"clock, medians of three runs of {options.steps} steps. Load of the machine ({os.cpu_count()} cores) before the "
          f"runs: {os.getloadavg()[0]:.1f}.\n")
    best, median = tabulate_times(melt, options.steps)
    print(f"\nScaled to {scaled:,} bonds: {median * scaled / rods:.2f} ms a step on one rank; best run: {best:.2f} ms, scaled "
          f"{best * scaled / rods:.2f} ms.\nLoad behind them: {os.getloadavg()[0]:.1f}.\n")
    compare_ranks(melt)
    sys.exit(0 if follow_long_run(melt, options.trend_steps) else 1)


if __name__ == "__main__":
    main()
