#!/usr/bin/python3
"""Writes NAME.data, one for each set of styles, and NAME.json: energies and forces by stock LAMMPS (Debian: lammps).

    make_forces.py      in the folder where the files shall lie
"""

import json
import pathlib
import subprocess
import tempfile

# A chain of seven atoms with a branch, out through the upper x face of the box, some sizes like those of alkanes.
PLACES = [[0.31, 0.22, 5.13], [1.52, 1.07, 5.41], [2.41, 0.43, 6.52], [3.83, 1.21, 6.47],
          [4.66, 0.31, 7.38], [6.02, 1.05, 7.57], [3.91, 2.61, 6.93]]
BOX = [-1.0, 5.0]
BONDS = [[1, 1, 2], [2, 2, 3], [1, 3, 4], [2, 4, 5], [1, 5, 6], [1, 4, 7]]
ANGLES = [[1, 1, 2, 3], [2, 2, 3, 4], [1, 3, 4, 5], [2, 4, 5, 6], [1, 3, 4, 7], [2, 5, 4, 7]]
DIHEDRALS = [[1, 1, 2, 3, 4], [2, 2, 3, 4, 5], [1, 3, 4, 5, 6], [2, 2, 3, 4, 7]]

SETS = {
    "fene_cosine_opls": {
        "bond": ("fene", ["30 2.5 0 1", "28.5 2.75 0 1"]),
        "angle": ("cosine", ["1.5", "2.25"]),
        "dihedral": ("opls", ["1.3 -0.5 3.2 0.4", "0.7 1.1 -2.0 0.25"])},
    "harmonic_charmm": {
        "bond": ("harmonic", ["310.5 1.53", "268.25 1.46"]),
        "angle": ("harmonic", ["58.35 112.7", "50.0 180.0"]),
        "dihedral": ("charmm", ["2.5 3 60 0.0", "1.2 2 -35 0.0"])},
    "morse_squared_multi": {
        "bond": ("morse", ["80 1.9 1.53", "95 1.7 1.45"]),
        "angle": ("cosine/squared", ["62.5 111.0", "48.0 109.5"]),
        "dihedral": ("multi/harmonic", ["9.28 12.16 -13.12 -3.06 26.24", "1.0 -2.0 3.0 -4.0 5.0"])},
    "dihedral_harmonic": {
        "bond": ("harmonic", ["300 1.5", "280 1.4"]),
        "angle": ("harmonic", ["55 110", "45 115"]),
        "dihedral": ("harmonic", ["2.0 1 3", "1.5 -1 2"])},
}


def write_data(path: pathlib.Path, styles: dict) -> None:
    lists = {"Bonds": BONDS, "Angles": ANGLES, "Dihedrals": DIHEDRALS}
    lines = [f"LAMMPS data: {path.stem}", "", f"{len(PLACES)} atoms"]
    lines += [f"{len(members)} {name.lower()}" for name, members in lists.items()]
    lines += ["1 atom types", "2 bond types", "2 angle types", "2 dihedral types", "",
              f"{BOX[0]} {BOX[1]} xlo xhi", "-20.0 20.0 ylo yhi", "-20.0 20.0 zlo zhi", "", "Masses", "", "1 14.027"]
    for kind, (style, coefficients) in styles.items():
        lines += ["", f"{kind.capitalize()} Coeffs # {style}", ""]
        lines += [f"{k + 1} {numbers}" for k, numbers in enumerate(coefficients)]
    lines += ["", "Atoms # molecular", ""]
    for k, (x, y, z) in enumerate(PLACES):
        image = 1 if x >= BOX[1] else 0
        lines.append(f"{k + 1} 1 1 {x - 6 * image:.6f} {y} {z} {image} 0 0")
    for name, members in lists.items():
        lines += ["", name, ""]
        lines += [f"{k + 1} " + " ".join(map(str, member)) for k, member in enumerate(members)]
    path.write_text("\n".join(lines) + "\n")


def run_lammps(data: pathlib.Path, styles: dict) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        commands = ["units lj", "atom_style molecular", "newton on"]
        commands += [f"{kind}_style {style}" for kind, (style, _) in styles.items()]
        commands += ["special_bonds lj/coul 0 1 1", f"read_data {data.resolve()}", "pair_style zero 8.0",
                     "pair_coeff * *", "neighbor 1.0 bin",
                     "thermo_style custom ebond eangle edihed", "thermo_modify format float %.17g",
                     f"dump f all custom 1 {folder}/forces id fx fy fz",
                     'dump_modify f sort id format float "%.17g"', "run 0"]
        script = pathlib.Path(folder) / "in"
        script.write_text("\n".join(commands) + "\n")
        log = subprocess.run(["lmp", "-in", script, "-log", "none"], check=True, capture_output=True, text=True).stdout
        rows = log.splitlines()
        title = next(k for k, row in enumerate(rows) if row.split()[:1] == ["E_bond"])
        bond, angle, dihedral = map(float, rows[title + 1].split())
        forces = [[float(x) for x in row.split()[1:]]
                  for row in pathlib.Path(folder, "forces").read_text().splitlines()[9:]]
    return {"energies": {"bond": bond * len(PLACES), "angle": angle * len(PLACES), "dihedral": dihedral * len(PLACES)},
            "forces": forces}


def main() -> None:
    for name, styles in SETS.items():
        data = pathlib.Path(name + ".data")
        write_data(data, styles)
        data.with_suffix(".json").write_text(json.dumps(run_lammps(data, styles), indent=1) + "\n")


if __name__ == "__main__":
    main()
