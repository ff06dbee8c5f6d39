#!/usr/bin/python3
"""Bundles an installed tanor, moves it, and runs it: nothing that it loads is from elsewhere but libraries of C and C++.
The answers that users come for take at most 15 lines there, in an empty folder, and are closed forms to 1e-9.

    check_portable.py BUILD CMAKE VERSION WORK
"""

import math
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

build, cmake, version, work = sys.argv[1], sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4])
source = pathlib.Path(__file__).resolve().parents[2]
CLEAN = {"PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8"}


def run(*command, **options) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout


shutil.rmtree(work, ignore_errors=True)
for component in ("runtime", "development", "program", "python"):
    run(cmake, "--install", build, "--component", component, "--prefix", work / "made")
run(source / "scripts/bundle.py", work / "made", version)
root = (work / "made").rename(work / "moved")

scene = source / "examples/pendulum.json"
run(root / "bin/tanor", "selftest", env=CLEAN)
run(root / "bin/tanor", "run", scene, "--out", work / "run", "--trajectory", "h5md,npz", "--quiet", env=CLEAN)
assert all((work / "run" / name).stat().st_size > 0 for name in ("trajectory.h5", "trajectory.npz", "summary.json"))

(wheel,) = root.glob("*.whl")
with zipfile.ZipFile(wheel) as archive:
    archive.extractall(work / "site")
    listed = [line.split(",")[0] for line in archive.read(f"tanor-{version}.dist-info/RECORD").decode().split()]
    assert sorted(listed) == sorted(archive.namelist()), "RECORD lists other files"
said = run("/usr/bin/python3", "-c", "import tanor; print(tanor.__version__, tanor.__file__)",
           env=CLEAN | {"PYTHONPATH": str(work / "site"), "PYTHONDONTWRITEBYTECODE": "1"})
assert said.split() == [version, str(work / "site/tanor/__init__.py")], said



def answer(name: str, *arguments) -> list[float]:
    """The numbers that an example prints."""
    script = source / "examples/answers" / f"{name}.py"
    assert len(script.read_text().splitlines()) <= 15, name
    folder = work / name
    folder.mkdir()
    said = run("/usr/bin/python3", script, *arguments, cwd=folder,
               env=CLEAN | {"PYTHONPATH": str(work / "site"), "PYTHONDONTWRITEBYTECODE": "1"})
    return [float(number) for number in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]\d+)?", said)]


def solve(function, low: float, high: float) -> float:
    """The root of an increasing function."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return low


def expect(found: float, wanted: float) -> None:
    assert abs(found - wanted) <= 1e-9 * abs(wanted), (found, wanted)


# A link with the vertical force V and the horizontal one H covers H/sqrt(H^2 + V^2) of its length; V = (4.5 - k) m g.
vertical = [(4.5 - k) * 2 * 9.81 for k in range(10)]
horizontal = solve(lambda h: sum(h / math.hypot(h, v) for v in vertical) - 8, 1, 1e4)
ends, middle = answer("cable")
expect(ends, math.hypot(horizontal, vertical[0]))
expect(middle, math.hypot(horizontal, vertical[4]))


def rocker_energy(t: complex) -> complex:
    """m v^2/2 + m g y of the rocker's end B, from |B - A| = 3, |B - C| = 2.5 with the crank's end A and the hinge C."""
    import cmath
    a, c = (cmath.cos(2 * t), cmath.sin(2 * t)), (3, 0)
    d = (c[0] - a[0], c[1] - a[1])
    square = d[0]**2 + d[1]**2
    along = (square + 9 - 6.25) / (2 * square)
    aside = cmath.sqrt(9 / square - along**2)
    b = (a[0] + along * d[0] - aside * d[1], a[1] + along * d[1] + aside * d[0])
    # The rates of both lengths are 0: (B - A).(v - v_A) = 0 and (B - C).v = 0.
    va = (-2 * a[1], 2 * a[0])
    u, w = (b[0] - a[0], b[1] - a[1]), (b[0] - c[0], b[1] - c[1])
    right = u[0] * va[0] + u[1] * va[1]
    det = u[0] * w[1] - u[1] * w[0]
    v = (right * w[1] / det, -right * w[0] / det)
    return 1.5 * (v[0]**2 + v[1]**2) + 3 * 9.81 * b[1]


# The motor's power is the rate of the energy; by a complex step it has no error of differences.
torque = rocker_energy(1e-30j).imag / 1e-30 / 2
expect(answer("four_bar")[0], torque)

# 3 m g sin a = 20 N, and t is the integral of da/sqrt(2 g sin a); a = u^2 takes the singularity away.
last = math.sqrt(math.asin(20 / (3 * 9.81)))
n = 2000
nodes = [last * (k + x) / n for k in range(n) for x in (0.5 - math.sqrt(15) / 10, 0.5, 0.5 + math.sqrt(15) / 10)]
weights = [last / n * w for _ in range(n) for w in (5 / 18, 4 / 9, 5 / 18)]
instant = sum(w * 2 * u / math.sqrt(2 * 9.81 * math.sin(u * u)) for u, w in zip(nodes, weights))
expect(answer("breaking_rod")[-1], instant)

# The tensions of the melt are those that the program writes, in 10 digits, as a dump local.
melt = source / "examples/melt_generated.json"
run(root / "bin/tanor", "run", melt, "--t-end", "0.02", "--out", work / "dump", "--trajectory", "lammps", "--quiet", env=CLEAN)
rows = (work / "dump/trajectory_rods.dump").read_text().split("ITEM: ENTRIES")[-1].splitlines()[1:]
tensions = [float(row.split()[-1]) for row in rows]
bins = answer("melt", melt)
edges, counts = bins[0::2], bins[1::2]
assert len(counts) == 20 and sum(counts) == len(tensions) == 31680
assert abs(edges[0] - min(tensions)) < 0.01
width = (max(tensions) - min(tensions)) / 20
for k, count in enumerate(counts):
    first = min(tensions) + k * width
    there = sum(first <= tension < first + width or (k == 19 and tension >= first) for tension in tensions)
    near = sum(abs(tension - edge) < 1e-8 for tension in tensions for edge in (first, first + width))
    assert abs(there - count) <= near, (k, there, count)

for home in (root, work / "site"):
    binaries = [file for file in home.rglob("*") if file.is_file() and open(file, "rb").read(4) == b"\x7fELF"]
    assert len(binaries) > 10, home
    for binary in binaries:
        for name, file in re.findall(r"^\s*(\S+) => (.*?)(?: \(0x|$)", run("ldd", binary, env=CLEAN), re.MULTILINE):
            is_given = re.match(r"lib(c|m|dl|rt|pthread|resolv|stdc\+\+|gcc_s)\.so", name)
            assert is_given or home in pathlib.Path(file).parents, f"{binary.name} loads {name} from {file}"
assert (root / "share/doc/tanor/licences/libcholmod3").is_file()
