#!/usr/bin/python3
"""A melt of 32,000 beads with FENE bonds and cosine bending: tanor's bonds and bendings beside LAMMPS' own.

    energies.py [--rounds 5] [--steps 100] [--drift STEPS] [--generated]

Writes build/data/melt_bonds.data from the melt of scripts/fetch_examples (FENE: K 30, R0 1.5; bending: K 1.5), runs
`lmp` and build/bench/energies on it in turn, one thread, and prints the medians: LAMMPS' "Bond" time a step, which is
that of bonds and angles, and tanor's evaluation of both. LAMMPS computes the repulsion of bonded beads with the bond,
tanor with the pairs. --drift runs both for so many steps of 0.003 and prints |E - E(0)| over the kinetic energy.
--generated takes a melt of tanor's own generator in place of the fetched one (320 chains of 100 beads, which begin as a
crystal; needs tanor's package for Python, build/python).
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCE, DATA = ROOT / "build/data/data.chain", ROOT / "build/data/melt_bonds.data"


def make_data() -> None:
    """The melt with coefficients and an angle at every inner bead of a chain."""
    lines = SOURCE.read_text().splitlines()
    start = lines.index("Bonds") + 2
    bonds = [tuple(map(int, line.split()[2:4])) for line in lines[start:] if line.strip()]
    angles = [(i, j, l) for (i, j), (k, l) in zip(bonds, bonds[1:]) if j == k]
    text = "\n".join(lines)
    text = re.sub(r"^0 angles", f"{len(angles)} angles", text, count=1, flags=re.M)
    text = re.sub(r"^0 angle types", "1 angle types", text, count=1, flags=re.M)
    coefficients = "Bond Coeffs # fene\n\n1 30 1.5 1 1\n\nAngle Coeffs # cosine\n\n1 1.5\n\nAtoms # molecular\n"
    text = re.sub(r"^Atoms.*\n", lambda _: coefficients, text, count=1, flags=re.M)
    text += "\n\nAngles\n\n" + "\n".join(f"{k + 1} 1 {i} {j} {l}" for k, (i, j, l) in enumerate(angles)) + "\n"
    DATA.write_text(text)


def make_generated_data() -> None:
    """The same of `generate: melt` with energies: its beads, chain by chain, with their velocities."""
    sys.path.insert(0, str(ROOT / "build/python"))
    import tanor

    chains, beads = 320, 100
    scene = {"tanor_scene": 1, "generate": {"kind": "melt", "bonds": "energies", "chains": chains, "count": beads - 1,
                                            "spacing": 1, "mass": 1}}
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "melt.json"
        file.write_text(json.dumps(scene))
        start = tanor.Simulation(tanor.Scene(file), tanor.MotionOptions(method="rattle", step=0.003))
    positions, velocities = start.positions.tolist(), start.velocities.tolist()
    pitch = 0.85**(-1 / 3)
    edges = [max(r[axis] for r in positions) + pitch for axis in range(3)]
    number = range(1, chains * beads + 1)
    bonds = [(k, k + 1) for k in number if k % beads != 0]
    angles = [(k, k + 1, k + 2) for k in number if (k - 1) % beads < beads - 2]
    rows = ["generate: melt with energies", "", f"{len(number)} atoms", f"{len(bonds)} bonds", f"{len(angles)} angles", "1 atom types", "1 bond types",
            "1 angle types", ""]
    rows += [f"0 {edge:.17g} {axis}lo {axis}hi" for edge, axis in zip(edges, "xyz")]
    rows += ["", "Masses", "", "1 1", "", "Bond Coeffs # fene", "", "1 30 1.5 1 1", "", "Angle Coeffs # cosine", "", "1 1.5"]
    rows += ["", "Atoms # molecular", ""]
    rows += [f"{k} {(k - 1) // beads + 1} 1 {x:.17g} {y:.17g} {z:.17g}" for k, (x, y, z) in zip(number, positions)]
    rows += ["", "Velocities", ""] + [f"{k} {x:.17g} {y:.17g} {z:.17g}" for k, (x, y, z) in zip(number, velocities)]
    rows += ["", "Bonds", ""] + [f"{n + 1} 1 {i} {j}" for n, (i, j) in enumerate(bonds)]
    rows += ["", "Angles", ""] + [f"{n + 1} 1 {i} {j} {k}" for n, (i, j, k) in enumerate(angles)]
    DATA.write_text("\n".join(rows) + "\n")


def run_lammps(steps: int, thermo: int) -> str:
    commands = ["units lj", "atom_style angle", "special_bonds fene", "bond_style fene", "angle_style cosine",
                f"read_data {DATA}", "pair_style lj/cut 1.122462048309373",
                "pair_modify shift yes", "pair_coeff 1 1 1 1", "neighbor 0.4 bin", "neigh_modify every 1 delay 1",
                "timestep 0.003",
                "fix 1 all nve",
                "thermo_style custom step pe ke etotal", "thermo_modify norm no format float %.15g",
                f"thermo {thermo}", f"run {steps}"]
    with tempfile.TemporaryDirectory() as folder:
        script = pathlib.Path(folder) / "in"
        script.write_text("\n".join(commands) + "\n")
        return subprocess.run(["lmp", "-in", script, "-log", "none"], check=True, capture_output=True, text=True,
                              env={"OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"}).stdout


def bond_time(log: str, steps: int) -> float:
    """The processor's, ms a step: LAMMPS prints the clock's, and which part of it the processor had."""
    share = float(re.search(r"([0-9.]+)% CPU use", log).group(1)) / 100.0
    return 1e3 * share * float(re.search(r"^Bond *\| *([0-9.e+-]+)", log, re.M).group(1)) / steps


def write_scene(folder: pathlib.Path) -> pathlib.Path:
    scene = json.loads((ROOT / "examples/melt_bonds.json").read_text())
    scene["import"]["file"] = str(DATA)
    path = folder / "melt.json"
    path.write_text(json.dumps(scene))
    return path


def compare_times(rounds: int, steps: int) -> None:
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as folder:
        scene = write_scene(pathlib.Path(folder))
        for _ in range(rounds):
            theirs.append(bond_time(run_lammps(steps, steps), steps))
            out = subprocess.run([ROOT / "build/bench/energies", scene, str(steps)], check=True, capture_output=True,
                                 text=True).stdout
            ours.append(float(out.split()[0]))
    print(f"LAMMPS bond + angle: {statistics.median(theirs):.3f} ms a step, tanor {statistics.median(ours):.3f} ms, "
          f"tanor/LAMMPS {statistics.median(o / t for o, t in zip(ours, theirs)):.2f}")


def compare_drifts(steps: int) -> None:
    rows = [list(map(float, row.split())) for row in run_lammps(steps, max(1, steps // 20)).splitlines()
            if re.fullmatch(r" *\d+( +-?[0-9.e+]+){3} *", row)]
    start = max(k for k, row in enumerate(rows) if k == 0 or row[0] <= rows[k - 1][0])
    motion = rows[start:]
    drift = max(abs(row[3] - motion[0][3]) for row in motion) / motion[-1][2]
    last = abs(motion[-1][3] - motion[0][3]) / motion[-1][2]
    print(f"LAMMPS nve, {steps} steps: |E - E(0)| {last:.3e} of the kinetic energy at the end, at most {drift:.3e}")
    with tempfile.TemporaryDirectory() as folder:
        scene, out = write_scene(pathlib.Path(folder)), pathlib.Path(folder) / "out"
        subprocess.run([ROOT / "build/src/cli/tanor", "run", scene, "--quiet", "--out", out, "--step", "0.003", "--threads", "1",
                        "--t-end", str(0.003 * steps)], check=True)
        energy = json.loads((out / "summary.json").read_text())["energy"]
    print(f"tanor rattle, {steps} steps: |E - E(0)| {abs(energy['end'] - energy['start']) / energy['kinetic']:.3e} at the end")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--drift", type=int, default=0)
    parser.add_argument("--generated", action="store_true")
    options = parser.parse_args()
    DATA.parent.mkdir(parents=True, exist_ok=True)
    if options.generated:
        make_generated_data()
    else:
        subprocess.run([ROOT / "scripts/fetch_examples", "melt"], check=True, stdout=subprocess.DEVNULL)
        make_data()
    compare_times(options.rounds, options.steps)
    if options.drift:
        compare_drifts(options.drift)


if __name__ == "__main__":
    main()
