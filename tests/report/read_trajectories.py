#!/usr/bin/python3
"""Runs a scene with all formats of a trajectory and reads each back with another program's reader: numpy, h5py, ASE, VTK,
LAMMPS (`read_dump` and `rerun`), MDAnalysis (H5MD), ParaView (pvpython).

    read_trajectories.py TANOR FOLDER [--all] [--page FILE]

A run in two parts must give the files of one run, and compressed ones those of plain ones; samples that repeat, upright and
tilted, must be told with their boxes. Readers that are not installed are left out; under CI h5py and ASE must be there, with
`--all` all but ParaView. The last line names who has read, FILE gets a table of it. No program reads a dump local of
LAMMPS back (`read_dump` and `rerun` take atoms alone): this script reads the tensions of rods there.
"""

import csv
import datetime
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET

import numpy as np

from periodic_trajectories import CORNER, IMPORTED, PERIODIC, RING, TILT, TILTED, UPRIGHT, check_cells, check_periodic
from trajectory_readers import (FORMATS, LAMMPS, PVPYTHON, MDAnalysis, ase, ask_versions, h5py, read_dump, read_npz,
                                vtk_to_numpy, vtkXMLPolyDataReader)

# Beads on a chain that hangs on a support, and one on a sphere; point 0 is not shown.
SCENE = {
    "tanor_scene": 1,
    "name": "all formats",
    "units": "si",
    "points": {"positions": [[5, 5, 5], [0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [0, 1, 0]],
               "masses": [1, 1, 0.1, 0.2, 0.3]},
    "supports": [{"points": [1]}],
    "constraints": [{"name": "ball", "kind": "sphere", "points": [4], "center": [0, 0.5, 0]},
                    {"name": "rods", "kind": "rod", "pairs": [[1, 2], [2, 3]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
    "motion": {"method": "dop853", "t_end": 1.0, "output_every": 0.125, "output_points": [1, 2, 3, 4],
               "trajectory": FORMATS}}
GROUPS_AND_MEMBERS = [[1, 0], [1, 1]]  # of the rods


def run(tanor: str, folder: pathlib.Path, *options: str) -> None:
    subprocess.run([tanor, "run", "scene.json", "--quiet", *options], cwd=folder, check=True)


def check_npz(out: pathlib.Path) -> dict:
    arrays = read_npz(out)
    assert arrays["time"].tolist() == [0.125 * k for k in range(9)]
    assert arrays["position"].shape == (9, 4, 3) and arrays["tension"].shape == (9, 2)
    assert arrays["points"].tolist() == [1, 2, 3, 4] and arrays["rods"].tolist() == [[1, 2], [2, 3]]
    assert arrays["rod_names"].tolist() == [b"rods[0]", b"rods[1]"]
    assert arrays["units"].tolist() == [b"s", b"m", b"m/s", b"m/s^2", b"N"]
    # Rods keep their lengths, and the ball its radius: what is read is the motion.
    r = arrays["position"]
    assert abs(np.linalg.norm(r[:, 2] - r[:, 1], axis=1) - 0.1).max() < 1e-10
    assert abs(np.linalg.norm(r[:, 3] - [0, 0.5, 0], axis=1) - 0.5).max() < 1e-10
    # Newton along the last bead: m w = gravity + T (r_1 - r_2)/l
    pull = arrays["tension"][:, 1, None] * (r[:, 1] - r[:, 2]) / 0.1
    assert abs(0.2 * arrays["acceleration"][:, 2] - pull - [0, 0, -0.2 * 9.81]).max() < 1e-9
    return arrays


def check_csv(out: pathlib.Path, arrays: dict, suffix: str = "") -> None:
    path = out / f"trajectory.csv{suffix}"
    with (gzip.open(path, "rt") if suffix else open(path, encoding="utf-8")) as file:
        rows = list(csv.DictReader(file))
    assert [float(row["t [s]"]) for row in rows] == arrays["time"].tolist()
    assert [float(row["z3 [m]"]) for row in rows] == arrays["position"][:, 2, 2].tolist()
    assert [float(row["vy4 [m/s]"]) for row in rows] == arrays["velocity"][:, 3, 1].tolist()
    assert [float(row["tension(rods[1]) [N]"]) for row in rows] == arrays["tension"][:, 1].tolist()


def check_h5md(out: pathlib.Path, arrays: dict) -> None:
    with h5py.File(out / "trajectory.h5", "r") as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert file["h5md/creator"].attrs["name"].decode() == "tanor"
        particles = file["particles/all"]
        assert particles["box"].attrs["dimension"] == 3
        assert [word.decode() for word in particles["box"].attrs["boundary"]] == ["none"] * 3
        for element, key in (("position", "position"), ("velocity", "velocity")):
            assert np.array_equal(particles[element]["value"][:], arrays[key]), element
            assert np.array_equal(particles[element]["time"][:], arrays["time"])
            assert particles[element]["step"] == particles["position/step"], "one array for all"
        steps = particles["position/step"][:]
        assert steps[0] == 0 and (np.diff(steps) > 0).all()
        assert particles["species"][:].tolist() == [1, 0, 0, 0] and particles["id"][:].tolist() == [1, 2, 3, 4]
        mass = particles["mass"][:]
        assert np.array_equal(particles["force/value"][:], mass[None, :, None] * arrays["acceleration"])
        # On the last bead: force = gravity + constraint force.
        left = particles["force/value"][:, 2] - particles["constraint_force/value"][:, 2] - [0, 0, -0.2 * 9.81]
        assert abs(left).max() < 1e-9
        rods = file["connectivity/rods"]
        assert rods[:].tolist() == [[1, 2], [2, 3]] and file[rods.attrs["particles_group"]] == particles
        assert np.array_equal(file["observables/tension/value"][:], arrays["tension"])
        tension = file["observables/tension/value"].attrs
        assert tension["unit"] == b"N" and tension["members"].tolist() == [b"rods[0]", b"rods[1]"]
        assert particles["position/value"].attrs["units"] == b"m" and particles["position/time"].attrs["units"] == b"s"
        assert file["observables/total_energy/value"].attrs["unit"] == b"J"
        energy = file["observables/total_energy/value"][:]
        assert abs(energy - energy[0]).max() < 1e-6


def check_mdanalysis(out: pathlib.Path, arrays: dict) -> None:
    """It keeps single precision."""
    universe = MDAnalysis.Universe.empty(4, trajectory=False)
    universe.load_new(str(out / "trajectory.h5"), format="H5MD", convert_units=False)
    assert len(universe.trajectory) == len(arrays["time"])
    mass = np.array([1, 0.1, 0.2, 0.3])[:, None]
    for k, frame in enumerate(universe.trajectory):
        assert abs(frame.time - arrays["time"][k]) < 1e-12
        for read, known in ((frame.positions, arrays["position"][k]), (frame.velocities, arrays["velocity"][k]),
                            (frame.forces, mass * arrays["acceleration"][k])):
            assert np.allclose(read, known, rtol=1e-6, atol=1e-6)


def check_ase(out: pathlib.Path, arrays: dict) -> None:
    for name, style in (("trajectory.xyz", "extxyz"), ("trajectory.dump", "lammps-dump-text")):
        frames = ase.io.read(out / name, index=":", format=style)
        assert len(frames) == 9, name
        for k, frame in enumerate(frames):
            assert np.allclose(frame.positions, arrays["position"][k], rtol=1e-9, atol=1e-9), name
    frames = ase.io.read(out / "trajectory.xyz", index=":")
    assert all(frame.get_chemical_symbols() == ["X", "C", "C", "C"] for frame in frames)


def check_rods(out: pathlib.Path, arrays: dict) -> None:
    lines = (out / "trajectory_rods.dump").read_text(encoding="utf-8").splitlines()
    letters = "time s, length m, velocity m/s, force N; "  # then what the numbers of groups and types stand for
    assert lines[:2] == ["ITEM: UNITS", letters + "groups: 1 rods"], lines[:2]
    with open(out / "trajectory.dump", encoding="utf-8") as file:
        assert [next(file).strip(), next(file).strip()] == ["ITEM: UNITS", letters + "type 2: 2 support0[0]"]
    starts = [k for k, line in enumerate(lines) if line.startswith("ITEM: ENTRIES")]
    assert lines[starts[0]].split()[2:] == ["index", "batom1", "batom2", "length", "tension", "group", "member"]
    for k, start in enumerate(starts):
        rows = np.array([[float(word) for word in line.split()] for line in lines[start + 1:start + 3]])
        assert rows[:, :3].tolist() == [[1, 2, 3], [2, 3, 4]]
        assert rows[:, 5:].tolist() == GROUPS_AND_MEMBERS
        assert np.allclose(rows[:, 4], arrays["tension"][k], rtol=1e-9) and np.allclose(rows[:, 3], 0.1)
    assert len(starts) == 9


def check_vtk(out: pathlib.Path, arrays: dict) -> None:
    """VTK's own reader on every frame that the list names."""
    frames = ET.parse(out / "trajectory.pvd").findall("Collection/DataSet")
    assert [float(frame.get("timestep")) for frame in frames] == arrays["time"].tolist()
    for k, frame in enumerate(frames):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(out / frame.get("file")))
        reader.Update()
        data = reader.GetOutput()
        points, cells, field = data.GetPointData(), data.GetCellData(), data.GetFieldData()
        assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), arrays["position"][k])
        for key in ("velocity", "acceleration"):
            assert np.array_equal(vtk_to_numpy(points.GetArray(key)), arrays[key][k]), key
        assert vtk_to_numpy(points.GetArray("support")).tolist() == [1, 0, 0, 0]
        # The point on the ball is no rod's: a vertex, which comes first.
        assert data.GetNumberOfVerts() == 1 and data.GetNumberOfLines() == 2
        tensions = vtk_to_numpy(cells.GetArray("tension"))
        assert vtk_to_numpy(cells.GetArray("group")).tolist() == [-1] + [group for group, _ in GROUPS_AND_MEMBERS]
        assert vtk_to_numpy(cells.GetArray("member")).tolist() == [-1] + [member for _, member in GROUPS_AND_MEMBERS]
        group = GROUPS_AND_MEMBERS[0][0]
        assert field.GetAbstractArray(f"group {group}").GetValue(0) == "rods"
        assert field.GetAbstractArray("unit of time").GetValue(0) == "s"
        assert np.isnan(tensions[0]) and np.array_equal(tensions[1:], arrays["tension"][k])
        assert vtk_to_numpy(data.GetLines().GetConnectivityArray()).tolist() == [0, 1, 1, 2]
        assert field.GetArray("TimeValue").GetValue(0) == arrays["time"][k]
        assert vtk_to_numpy(field.GetArray("gravity")).tolist() == [0, 0, -9.81]
        assert vtk_to_numpy(field.GetArray("guide sphere ball")).tolist() == [0, 0.5, 0, 0.5]
        # The ball alone holds point 3: its force is m w - m g there.
        held = vtk_to_numpy(points.GetArray("guide_force"))[3]
        assert abs(held - 0.3 * (arrays["acceleration"][k, 3] - [0, 0, -9.81])).max() < 1e-9


PARAVIEW = """
import sys
from paraview.simple import PVDReader
from paraview import servermanager
from vtkmodules.util.numpy_support import vtk_to_numpy
reader = PVDReader(FileName=sys.argv[1])
for time in reader.TimestepValues:
    reader.UpdatePipeline(time)
    data = servermanager.Fetch(reader)
    numbers = vtk_to_numpy(data.GetPoints().GetData()).ravel().tolist() + vtk_to_numpy(data.GetCellData().GetArray("tension")).tolist()
    print(repr(time), *map(repr, numbers))
"""


def check_paraview(out: pathlib.Path, arrays: dict) -> None:
    """ParaView opens the list and goes through its times."""
    script = out.parent / "read_pvd.py"
    script.write_text(PARAVIEW, encoding="utf-8")
    told = subprocess.run([PVPYTHON, "--force-offscreen-rendering", str(script), str(out / "trajectory.pvd")], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    rows = np.array([[float(word) for word in line.split()] for line in told.splitlines()])
    assert rows[:, 0].tolist() == arrays["time"].tolist()
    assert np.array_equal(rows[:, 1:13], arrays["position"].reshape(-1, 12))
    assert np.array_equal(rows[:, 14:], arrays["tension"])


LAMMPS_INPUT = """
units si
atom_modify map array
region everywhere block -10 10 -10 10 -10 10
create_box 2 everywhere
create_atoms 1 single 0 0 0
create_atoms 1 single 1 0 0
create_atoms 1 single 2 0 0
create_atoms 1 single 3 0 0
create_atoms 1 single 4 0 0
mass * 1
pair_style zero 1
pair_coeff * *
comm_modify cutoff 10
read_dump {dump} 8 x y z vx vy vz replace yes box no format native
dump once all custom 1 once.dump id x y z vx vy vz
dump_modify once sort id format float %.17g
run 0
undump once
thermo 1
thermo_style custom step
dump again all custom 1 again.dump id x y z
dump_modify again sort id format float %.17g
rerun {dump} dump x y z box no replace yes
"""


def check_lammps(out: pathlib.Path, arrays: dict) -> None:
    """LAMMPS takes one frame for its state, and goes through all of them. Its first atom is the point that is not shown."""
    (out / "in.lammps").write_text(LAMMPS_INPUT.format(dump="trajectory.dump"), encoding="utf-8")
    subprocess.run([LAMMPS, "-in", "in.lammps", "-log", "none", "-screen", "none"], cwd=out, check=True)
    once, again = read_dump(out / "once.dump"), read_dump(out / "again.dump")
    state = next(iter(once.values()))[1:]
    assert np.allclose(state[:, 1:4], arrays["position"][8], rtol=1e-9, atol=1e-9)
    assert np.allclose(state[:, 4:7], arrays["velocity"][8], rtol=1e-9, atol=1e-9)
    assert sorted(again) == list(range(9))
    for step, rows in again.items():
        assert np.allclose(rows[1:, 1:4], arrays["position"][step], rtol=1e-9, atol=1e-9), step


# Two rods hold one weight together, in any share, and a third another one alone.
SHARED = {
    "tanor_scene": 1,
    "points": {"positions": [[0, 0, 0], [0, 0, -1], [1, 0, 0], [1, 0, -1]], "masses": 2},
    "supports": [{"points": [0, 2]}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0, 1], [0, 1], [2, 3]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -10]}],
    "motion": {"t_end": 0.1, "output_every": 0.05, "trajectory": FORMATS}}


def check_shared(out: pathlib.Path) -> None:
    """No file has a tension that is not unique, and each has the third one."""
    def is_right(tensions) -> bool:
        return np.isnan(tensions[..., :2]).all() and np.allclose(tensions[..., 2], 20, rtol=1e-12)
    assert is_right(read_npz(out)["tension"])
    with open(out / "trajectory.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert is_right(np.array([[float(row[f"tension(rods[{k}])"]) for k in range(3)] for row in rows])), rows
    lines = (out / "trajectory_rods.dump").read_text(encoding="utf-8").splitlines()
    starts = [k for k, line in enumerate(lines) if line.startswith("ITEM: ENTRIES")]
    assert len(starts) == 3
    assert all(is_right(np.array([float(line.split()[4]) for line in lines[k + 1:k + 4]])) for k in starts)
    if h5py:
        with h5py.File(out / "trajectory.h5", "r") as file:
            assert is_right(file["observables/tension/value"][:])
    for frame in ET.parse(out / "trajectory.pvd").findall("Collection/DataSet"):
        data = (out / frame.get("file")).read_bytes()
        offset = int(re.search(rb'Name="tension" .*offset="(\d+)"', data)[1])
        begin = data.index(b"_", data.index(b"<AppendedData")) + 1 + offset + 8  # behind the number of bytes
        assert is_right(np.frombuffer(data, "<f8", 3, begin))


# File, what it must give, by whom it is read.
READINGS = [
    ("trajectory.xyz", "positions", ["ASE"]),
    ("trajectory.pvd, trajectory/", "positions, velocities, accelerations, supports, tensions, forces of guides, gravity", ["VTK"]),
    ("trajectory.pvd, trajectory/", "times, positions, tensions", ["ParaView"]),
    ("trajectory.dump", "positions, velocities, cells upright and tilted (read_dump), all frames (rerun)", ["LAMMPS"]),
    ("trajectory.dump", "positions", ["ASE"]),
    ("trajectory_rods.dump", "ids, lengths, tensions; no other program reads a dump local", ["Python"]),
    ("trajectory.h5", "all", ["h5py"]),
    ("trajectory.h5", "positions, velocities, forces, in single precision", ["MDAnalysis"]),
    ("trajectory.csv", "times, positions, velocities, tensions", ["Python"]),
    ("trajectory.npz", "all; Newton's law of a bead", ["numpy"]),
]


def count_bytes(out: pathlib.Path, files: str) -> int:
    parts = [out / name for name in files.split(", ")]
    return sum(path.stat().st_size for part in parts for path in ([part] if part.is_file() else part.iterdir()))


def write_page(path: pathlib.Path, out: pathlib.Path, packed: pathlib.Path) -> None:
    versions = ask_versions()
    lines = ["# Trajectories read back by other programs", "",
             f"`scripts/test-formats --page bench/results/formats.md`, {datetime.date.today()}: nine frames of four points and two rods,",
             "once at one go, once in two parts by `--resume`, once compressed; what each reader finds is compared with the others.",
             "A file that is compressed as a whole (`.gz`) is unpacked for readers that do not do it themselves.", "",
             "| file | bytes | compressed | read by | what is compared |", "|---|--:|--:|---|---|"]
    for files, what, readers in READINGS:
        names = ", ".join(f"{name} {versions[name]}" if name in versions else f"{name}: not installed" for name in readers)
        plain = [name for name in files.split(", ")]
        squeezed = ", ".join(name if (packed / name).is_dir() or not (packed / f"{name}.gz").exists() else f"{name}.gz" for name in plain)
        lines.append(f"| `{files}` | {count_bytes(out, files)} | {count_bytes(packed, squeezed)} | {names} | {what} |")
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def main() -> int:
    tanor, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    readers = {"h5py": h5py, "ASE": ase, "VTK": vtk_to_numpy, "LAMMPS": LAMMPS, "MDAnalysis": MDAnalysis,
               "ParaView": PVPYTHON}
    missing = [name for name, reader in readers.items() if not reader and name != "ParaView"]
    wanted = missing if "--all" in sys.argv else set(missing) & {"h5py", "ASE"} if os.environ.get("CI") else []
    if wanted:
        print("not installed:", ", ".join(sorted(wanted)), file=sys.stderr)
        return 1
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "scene.json").write_text(json.dumps(SCENE), encoding="utf-8")
    run(tanor, folder, "--out", "whole")
    run(tanor, folder, "--out", "parts", "--t-end", "0.5")
    run(tanor, folder, "--out", "parts", "--resume")
    packed = dict(SCENE, motion=dict(SCENE["motion"], compression=True))
    (folder / "scene.json").write_text(json.dumps(packed), encoding="utf-8")
    run(tanor, folder, "--out", "packed")

    for name in ("whole", "parts", "packed"):
        out = folder / name
        arrays = check_npz(out)
        if h5py:
            check_h5md(out, arrays)
        if MDAnalysis:
            check_mdanalysis(out, arrays)
        check_csv(out, arrays, ".gz" if name == "packed" else "")
        if name == "packed":
            for file in ("trajectory.xyz", "trajectory.dump", "trajectory_rods.dump"):
                (out / file).write_bytes(gzip.decompress((out / f"{file}.gz").read_bytes()))
                assert (out / file).read_bytes() == (folder / "whole" / file).read_bytes(), file
        check_rods(out, arrays)
        if vtk_to_numpy:
            check_vtk(out, arrays)
        if PVPYTHON:
            check_paraview(out, arrays)
        if LAMMPS:
            check_lammps(out, arrays)
        if ase:
            check_ase(out, arrays)
    for file in ("trajectory.xyz", "trajectory.dump", "trajectory_rods.dump", "trajectory.csv", "trajectory.npz"):
        assert (folder / "parts" / file).read_bytes() == (folder / "whole" / file).read_bytes(), file
    (folder / "scene.json").write_text(json.dumps(SHARED), encoding="utf-8")
    run(tanor, folder, "--out", "shared")
    check_shared(folder / "shared")
    ring = [[0, 1], [1, 2], [2, 0]]
    for name, scene, edges, rods, corner in (("upright", PERIODIC, UPRIGHT, [[0, 1]], [0, 0, 0]), ("tilted", IMPORTED, TILTED, ring, CORNER),
                                             ("shifted", IMPORTED, UPRIGHT, ring, CORNER)):
        (folder / "ring.data").write_text(RING if name == "tilted" else RING.replace(TILT, ""), encoding="utf-8")
        (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
        run(tanor, folder, "--out", name)
        check_periodic(folder / name, edges, rods, corner)
        if rods == ring:  # the state of rest is a scene that has the cell and the letters of the file
            subprocess.run([tanor, "equilibrium", "scene.json", "--quiet", "--out", "rest"], cwd=folder, check=True)
            (folder / "scene.json").write_text((folder / "rest/equilibrium.json").read_text(encoding="utf-8"), encoding="utf-8")
            (folder / "ring.data").unlink()
            run(tanor, folder, "--out", "again", "--t-end", "0.5")
            check_cells(folder / "again", edges, corner)
    if "--page" in sys.argv:
        write_page(pathlib.Path(sys.argv[sys.argv.index("--page") + 1]), folder / "whole", folder / "packed")
    print("read back:", ", ".join(["numpy", "csv", "gzip", *(name for name, reader in readers.items() if reader)]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
