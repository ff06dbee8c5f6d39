#!/usr/bin/python3
"""What fix tanor/rods costs inside Debian's LAMMPS: the melt of its bench data.chain, 31,680 bonds, as rods.

    hosts.py BUILD [--steps N] [--data data.chain] > bench/results/hosts.md

BUILD: a build tree with tanor_lammps. data.chain comes with Debian's lammps-examples. Times are processor times of the
slowest rank, so that they can be taken on a machine that others use too; medians of three runs in turn.
"""

import argparse
import pathlib
import statistics
import sys
import tempfile

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
fix rods all tanor/rods bond 1 length 0.97
thermo_style custom step temp ke etotal press f_rods f_rods[1] f_rods[2] f_rods[3]
thermo_modify norm yes format float %.12g
timestep 0.004
"""


class Run(host_runs.HostTest):
    program = "lmp"

    def go(self, script, ranks):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)
        return self.run_host(script, ranks)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--trend-steps", type=int, default=10000)
    parser.add_argument("--data", default="/usr/share/lammps/examples/COUPLE/multiple/data.chain")
    options = parser.parse_args()
    melt = MELT.format(data=options.data, register=(options.build / "src/embed/lammps/tanor.lmp").resolve())
    rods = 31680

    print("# tanor inside LAMMPS\n")
    print("`bench/hosts.py build`: the melt `data.chain` of LAMMPS 29Sep2021u2 (Debian 12), 320 chains of 100 atoms,")
    print(f"{rods:,} rods of 0.97, NVE, time step 0.004. Processor times of the slowest rank, medians of three runs of")
    print(f"{options.steps} steps.\n")
    print("| ranks | fix, ms a step | in the solver | copies and exchange | iterations | largest violation |")
    print("|--:|--:|--:|--:|--:|--:|")
    script = melt + f"thermo {options.steps}\nrun {options.steps}\n"
    rows = {ranks: [] for ranks in (1, 2, 4)}
    for _ in range(3):
        for ranks, found in rows.items():
            found.append(Run().go(script, ranks)[0][-1])
    for ranks, found in rows.items():
        whole, solver = (statistics.median(row[f"f_rods[{k}]"] for row in found) for k in (2, 3))
        print(f"| {ranks} | {whole:.2f} | {solver:.2f} | {whole - solver:.2f} | {found[0]['f_rods[1]']:.2f} | "
              f"{max(row['f_rods'] for row in found):.1e} |")
    whole = statistics.median(row["f_rods[2]"] for row in rows[1])
    print(f"\nScaled to 51,889 bonds: {whole * 51889 / rods:.2f} ms a step on one rank.\n")

    steps = options.trend_steps
    table = Run().go(melt + f"thermo 1\nrun {steps}\n", 1)[0]
    energies = [row["etotal"] for row in table[steps // 10:]]
    fifth = len(energies) // 5
    drift = statistics.fmean(energies[-fifth:]) - statistics.fmean(energies[:fifth])
    print(f"Over {steps:,} steps on one rank, looked at in every step: largest violation of a bond "
          f"{max(row['f_rods'] for row in table):.1e};")
    print(f"energy an atom {statistics.fmean(energies):.5f}, spread {max(energies) - min(energies):.1e}, mean of the last "
          f"fifth minus that of the first fifth {drift:.1e}.")


if __name__ == "__main__":
    main()
