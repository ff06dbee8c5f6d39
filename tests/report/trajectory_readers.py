"""The readers of trajectories that tests/report/read_trajectories.py compares; None stands for one that is not installed."""

import pathlib
import re
import shutil
import subprocess
import sys
import warnings

import numpy as np

try:
    import h5py
except ImportError:
    h5py = None
try:
    import ase.io
except ImportError:
    ase = None
try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkVersion
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
except ImportError:
    vtk_to_numpy = vtkXMLPolyDataReader = None
try:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import MDAnalysis
except ImportError:
    MDAnalysis = None
LAMMPS, PVPYTHON = shutil.which("lmp"), shutil.which("pvpython")

# The formats that scenes ask for.
FORMATS = ["xyz", "vtp", "lammps", "h5md", "csv", "npz"]


def read_npz(out: pathlib.Path) -> dict:
    with np.load(out / "trajectory.npz") as arrays:
        return {key: arrays[key] for key in arrays.files}


def read_dump(path: pathlib.Path) -> dict:
    """Returns {step: rows} of a dump that LAMMPS wrote."""
    lines, frames, k = path.read_text(encoding="utf-8").splitlines(), {}, 0
    while k < len(lines):
        step, count = int(lines[k + 1]), int(lines[k + 3])
        frames[step] = np.array([[float(word) for word in line.split()] for line in lines[k + 9:k + 9 + count]])
        k += 9 + count
    return frames


def ask(*command: str) -> str:
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False).stdout


def ask_versions() -> dict:
    """Returns the version of each reader that is there, as it tells itself."""
    versions = {"Python": ".".join(map(str, sys.version_info[:3])), "numpy": np.__version__}
    versions |= {name: module.__version__ for name, module in (("h5py", h5py), ("ASE", ase), ("MDAnalysis", MDAnalysis)) if module}
    if vtk_to_numpy:
        versions["VTK"] = vtkVersion.GetVTKVersion()
    if LAMMPS:
        versions["LAMMPS"] = re.search(r"- (.*\d{4}.*)", ask(LAMMPS, "-help"))[1]
    if PVPYTHON:
        versions["ParaView"] = ask(PVPYTHON, "--version").split()[-1]
    return versions
