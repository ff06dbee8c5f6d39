"""Scenes whose samples repeat, in an upright and in a tilted cell, and what their trajectories must give other programs."""

import csv
import pathlib
import re
import subprocess
import xml.etree.ElementTree as ET

import numpy as np

from trajectory_readers import FORMATS, LAMMPS, MDAnalysis, ase, h5py, read_dump, read_npz, vtk_to_numpy, vtkXMLPolyDataReader

# Two beads that turn around each other, joined by a rod through a periodic face, and one that passes by.
PERIODIC = {
    "tanor_scene": 1,
    "name": "through a face",
    "points": {"positions": [[0.1, 1, 1], [1.9, 1, 1], [1, 2, 2]], "velocities": [[0, 0, 0.3], [0, 0, -0.1], [0.1, 0, 0]],
               "masses": [1, 2, 1]},
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0, 1]], "offsets": [[-2, 0, 0]]}],
    "forces": [{"kind": "pair", "law": "wca", "sigma": 0.1, "exclude": "rods", "box": [2, 3, 4]}],
    "motion": {"method": "dop853", "t_end": 1, "output_every": 0.25, "trajectory": FORMATS}}
UPRIGHT = [[2, 0, 0], [0, 3, 0], [0, 0, 4]]

# A ring that closes through the face of a tilted cell, whose corner is not the origin.
CORNER = [-0.4, -0.3, 0.5]
TILT = "0.5 0.2 0.3 xy xz yz\n"
TILTED = [[2, 0, 0], [0.5, 3, 0], [0.2, 0.3, 4]]
RING = """LAMMPS data file, units lj

3 atoms
3 bonds
1 atom types
1 bond types

-0.4 1.6 xlo xhi
-0.3 2.7 ylo yhi
0.5 4.5 zlo zhi
0.5 0.2 0.3 xy xz yz

Masses

1 1

Atoms # molecular

1 1 1 0.5 0.5 1
2 1 1 1.1 1.5 1
3 1 1 0.8 2.5 1

Velocities

1 0 0 0.2
2 0.1 0 -0.3
3 0 0 0.1

Bonds

1 1 1 2
2 1 2 3
3 1 3 1
"""
IMPORTED = {
    "tanor_scene": 1,
    "name": "ring",
    "import": {"file": "ring.data"},
    "equilibrium": {"accept": "any"},
    "motion": {"method": "dop853", "t_end": 1, "start": "project", "output_every": 0.25, "trajectory": FORMATS}}


LAMMPS_CELL = """
units lj
atom_modify map array
region cell {region}
create_box 1 cell
create_atoms 1 single 0.1 0.1 0.1
create_atoms 1 single 0.5 0.5 0.5
create_atoms 1 single 0.9 0.9 0.9
mass * 1
pair_style zero 0.1
pair_coeff * *
read_dump trajectory.dump {frame} x y z vx vy vz replace yes box yes format native
dump once all custom 1 once.dump id xu yu zu vx vy vz
dump_modify once sort id format float %.17g
run 0
print "$(lx:%.17g) 0 0 $(xy:%.17g) $(ly:%.17g) 0 $(xz:%.17g) $(yz:%.17g) $(lz:%.17g)" file cell.txt
print "$(xlo:%.17g) $(ylo:%.17g) $(zlo:%.17g)" file corner.txt
"""


def check_lammps_cell(out: pathlib.Path, arrays: dict, cell: np.ndarray, corner: list) -> None:
    """LAMMPS takes the cell from a frame, and the points up to whole turns around it."""
    frame = len(arrays["time"]) - 1
    is_tilted = np.any(cell != np.diag(np.diag(cell)))
    region = "prism 0 1 0 1 0 1 0 0 0" if is_tilted else "block 0 1 0 1 0 1"  # of the kind that the file tells
    (out / "in.lammps").write_text(LAMMPS_CELL.format(frame=frame, region=region), encoding="utf-8")
    subprocess.run([LAMMPS, "-in", "in.lammps", "-log", "none", "-screen", "none"], cwd=out, check=True)
    assert np.allclose(np.loadtxt(out / "cell.txt").reshape(3, 3), cell, rtol=1e-12, atol=1e-12)
    assert np.allclose(np.loadtxt(out / "corner.txt"), corner, rtol=1e-12, atol=1e-12)
    state = next(iter(read_dump(out / "once.dump").values()))
    turns = np.linalg.solve(cell.T, (state[:, 1:4] - arrays["position"][frame]).T)
    assert abs(turns - np.round(turns)).max() < 1e-9, turns
    assert np.allclose(state[:, 4:7], arrays["velocity"][frame], rtol=1e-9, atol=1e-9)


def find_nearest_image(d: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """The shortest of d and its images; a search, as no reader of ours does it."""
    steps = range(-2, 3)
    images = [d + np.array([i, j, k]) @ cell for i in steps for j in steps for k in steps]
    return min(images, key=np.linalg.norm)


def check_edges(out: pathlib.Path, cell: np.ndarray, positions: np.ndarray) -> None:
    """MDAnalysis has edges of a cell but no corner: what it reads of H5MD are positions as they are, in single precision."""
    universe = MDAnalysis.Universe.empty(positions.shape[1], trajectory=False)
    universe.load_new(str(out / "trajectory.h5"), format="H5MD", convert_units=False)
    for k, frame in enumerate(universe.trajectory):
        assert np.allclose(frame.triclinic_dimensions, cell, rtol=1e-6, atol=1e-6), frame.triclinic_dimensions
        assert np.allclose(frame.positions, positions[k], rtol=1e-6, atol=1e-6)


def check_cells(out: pathlib.Path, edges: list, corner: list) -> None:
    """The cell as NPZ and the dump of a motion from rest have it, and letters of units."""
    arrays = read_npz(out)
    assert np.array_equal(arrays["box"], edges) and np.array_equal(arrays["origin"], corner)
    assert arrays["units"][:2].tolist() == [b"tau", b"sigma"]
    if ase:
        frame = ase.io.read(out / "trajectory.dump", index=0, format="lammps-dump-text")
        assert np.allclose(frame.get_celldisp().ravel(), corner, rtol=1e-12) and np.allclose(frame.cell[:], edges, rtol=1e-12)


def check_periodic(out: pathlib.Path, edges: list, rods: list, corner: list) -> None:
    """The box is told as it is, with its corner, and rods through its faces keep their lengths in the nearest images."""
    arrays, cell, is_imported = read_npz(out), np.array(edges, float), len(rods) > 1
    assert arrays["rods"].tolist() == rods
    positions, frames = arrays["position"], len(arrays["time"])
    lengths = [np.linalg.norm(find_nearest_image(positions[0, j] - positions[0, i], cell)) for i, j in rods]
    # Some rod is longer than its nearest image: it goes through a face.
    assert max(np.linalg.norm(positions[0, j] - positions[0, i]) / length for (i, j), length in zip(rods, lengths)) > 1.5
    assert abs(positions[-1] - positions[0]).max() > 0.01, "it moves"
    if ase:
        for name, style in (("trajectory.xyz", "extxyz"), ("trajectory.dump", "lammps-dump-text")):
            read = ase.io.read(out / name, index=":", format=style)
            assert len(read) == frames, name
            for k, frame in enumerate(read):
                assert frame.pbc.all() and np.allclose(frame.cell[:], cell, rtol=1e-12, atol=1e-12), (name, frame.cell)
                # Its reader of xyz keeps the corner beside the frame.
                told = frame.get_celldisp().ravel() if style == "lammps-dump-text" else frame.info["Origin"]
                assert np.allclose(told, corner, rtol=1e-12, atol=1e-12), (name, told)
                assert ("Units" in frame.info) == is_imported or style == "lammps-dump-text", frame.info
                assert np.allclose(frame.positions, positions[k], rtol=1e-9, atol=1e-9), name
                found = [frame.get_distance(i, j, mic=True) for i, j in rods]
                assert np.allclose(found, lengths, rtol=1e-8), (name, found, lengths)
    if h5py:
        with h5py.File(out / "trajectory.h5", "r") as file:
            box = file["particles/all/box"]
            assert [word.decode() for word in box.attrs["boundary"]] == ["periodic"] * 3
            assert box["edges/value"].shape == (frames, 3, 3) and (box["edges/value"][:] == cell).all()
            assert np.array_equal(box["offset"][:], corner)
            assert file["connectivity/rods"][:].tolist() == rods
            assert np.array_equal(file["particles/all/position/value"][:], positions)
    if MDAnalysis:
        check_edges(out, cell, positions)
    assert np.array_equal(arrays["box"], cell) and np.array_equal(arrays["origin"], corner)
    with open(out / "trajectory.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    unit = " [sigma]" if is_imported else ""
    told = [[float(row[f"{part}.{axis}{unit}"]) for part in ("box[0]", "box[1]", "box[2]", "origin") for axis in "xyz"] for row in rows]
    assert told == [[*cell.ravel(), *corner]] * frames, told[0]
    comment = (out / "trajectory.xyz").read_text(encoding="utf-8").splitlines()[1]
    told = re.search(r'Origin="([^"]*)"', comment)
    assert np.array_equal([float(word) for word in told[1].split()], corner), comment
    lines = (out / "trajectory_rods.dump").read_text(encoding="utf-8").splitlines()
    starts = [k for k, line in enumerate(lines) if line.startswith("ITEM: ENTRIES")]
    for k, start in enumerate(starts):
        rows = np.array([[float(word) for word in line.split()] for line in lines[start + 1:start + 1 + len(rods)]])
        assert (rows[:, 1:3] - 1).tolist() == rods and np.allclose(rows[:, 3], lengths, rtol=1e-8)
        assert np.allclose(rows[:, 4], arrays["tension"][k], rtol=1e-9)
    assert len(starts) == frames
    if vtk_to_numpy:
        check_images(out, cell, arrays, lengths, corner)
    if LAMMPS:
        check_lammps_cell(out, arrays, cell, corner)


def check_images(out: pathlib.Path, cell: np.ndarray, arrays: dict, lengths: list, corner: list) -> None:
    """A rod through a face is drawn beside its first point, to an image of the other one; the cell stands where it is."""
    for k, frame in enumerate(ET.parse(out / "trajectory.pvd").findall("Collection/DataSet")):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(out / frame.get("file")))
        reader.Update()
        drawn = vtk_to_numpy(reader.GetOutput().GetFieldData().GetArray("guide cell "))
        assert np.array_equal(drawn, [*corner, *cell.ravel()]), drawn
        places = vtk_to_numpy(reader.GetOutput().GetPoints().GetData())
        ends = vtk_to_numpy(reader.GetOutput().GetLines().GetConnectivityArray()).reshape(-1, 2)
        for (i, j), (a, b), length in zip(arrays["rods"], ends, lengths):
            assert a == i and abs(np.linalg.norm(places[b] - places[a]) - length) < 1e-8
            turns = np.linalg.solve(cell.T, places[b] - arrays["position"][k, j])
            assert abs(turns - np.round(turns)).max() < 1e-9
