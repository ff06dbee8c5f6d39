#!/usr/bin/python3
"""Tries the portable archive in a clean root, a Debian of few packages without network: the program in one that has but
libraries of C, then the wheel, then projects that link with it. The answers that users come for take at most 15
lines there, in an empty folder, and are closed forms to 1e-9.

    check_portable.py FROM WORK [--fresh]

FROM is the archive, or the build of which it is made. The root has files of packages that are installed here, as dpkg
lists them; with --fresh it is a Debian 12 that mmdebstrap fetches. Where nobody may mount, the same commands run in the
system as it is, without its environment: what a system lacks does not show there, all else does.
"""

import cmath
import csv
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

given, work = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
is_fresh = "--fresh" in sys.argv[3:]
source = pathlib.Path(__file__).resolve().parents[2]
root = work / "root"
PLACE = "opt/tanor"  # of the archive in the root
# What the oldest system has: glibc 2.36 and the libraries of GCC 12, which is of the same year.
NEWEST = {"GLIBC": (2, 36), "GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13), "GCC": (12, 0, 0)}


def run(*command, **options) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout


# Mounts and the network are those of a namespace, which goes with its command.
CLEAN = ["unshare", *([] if os.geteuid() == 0 else ["--map-root-user"]), "--mount", "--net", "--pid", "--fork", "bash", "-euc",
         """mount -t proc proc "$1/proc"
mount --rbind /dev "$1/dev"
exec chroot "$1" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/root LC_ALL=C.UTF-8 bash -euo pipefail -c "cd '$2'; $3" """, "bash"]


def inside(command: str, folder: str = "/tmp") -> str:
    """Runs a command in the root, in which BASE is empty, or beside it."""
    if BASE:
        bare = ["env", "-i", "PATH=/usr/bin:/bin", f"HOME={BASE}/root", "LC_ALL=C.UTF-8", "bash", "-euo", "pipefail", "-c"]
        return run(*bare, f"cd '{BASE}{folder}'; {command}")
    return run(*CLEAN, root, folder, command)


def add_packages(*names: str) -> None:
    if BASE:
        return
    if is_fresh:
        run("chroot", root, "env", "DEBIAN_FRONTEND=noninteractive", "LC_ALL=C.UTF-8", "apt-get", "-q", "install", "--yes",
            "--no-install-recommends", "-o", "Dpkg::Use-Pty=0", *names)
        return
    needed, left = [], list(names)
    while left:
        name = left.pop()
        asked = ["dpkg-query", "--show", "--showformat=${db:Status-Status} ${Pre-Depends}, ${Depends}", name]
        said = subprocess.run(asked, capture_output=True, text=True, check=False).stdout
        if name not in needed and said.startswith("installed "):  # the others have an alternative that is
            needed.append(name)
            left += re.findall(r"[a-z0-9][a-z0-9+.-]+", re.sub(r"\(.*?\)|:any", "", said[10:]))
    assert set(names) <= set(needed), f"not installed: {set(names) - set(needed)}"
    files = [line[1:] for line in run("dpkg-query", "--listfiles", *needed).splitlines()
             if line.startswith("/") and not re.match("/.?$|/usr/share/(doc|locale|man)/", line)]
    (work / "files").write_text("\n".join(files))
    run("bash", "-euc", 'tar -C / -c --no-recursion --ignore-failed-read --files-from="$1" 2>/dev/null | tar -x -C "$2"', "bash",
        work / "files", root)
    # Links of alternatives are of no package; numpy finds its BLAS by the cache.
    inside("/sbin/ldconfig /usr/lib/x86_64-linux-gnu/blas /usr/lib/x86_64-linux-gnu/lapack 2>/dev/null")


def list_binaries(home: pathlib.Path) -> list:
    files = [file for file in home.rglob("*") if file.is_file() and not file.is_symlink()]
    return [file for file in files if open(file, "rb").read(4) == b"\x7fELF"]


def check_binaries(home: pathlib.Path) -> None:
    """They load nothing from elsewhere but libraries of C and, apart from the program, C++, and of these nothing too new."""
    binaries = list_binaries(home)
    assert len(binaries) > 10, home
    there = f"{BASE}/{home.relative_to(root)}"
    for binary in binaries:
        for name, file in re.findall(r"^\s*(\S+) => (.*?)(?: \(0x|$)", inside(f"ldd {BASE}/{binary.relative_to(root)}"), re.MULTILINE):
            of_cxx = "" if binary.parent.name == "bin" else r"|stdc\+\+|gcc_s"
            is_given = re.match(rf"lib(c|m|dl|rt|pthread|resolv{of_cxx})\.so", name)
            assert is_given or os.path.normpath(file).startswith(there + "/"), f"{binary.name} loads {name} from {file}"
        for name, number in re.findall(r"\((GLIBC|GLIBCXX|CXXABI|GCC)_([\d.]+)\)", run("objdump", "-T", binary)):
            assert tuple(map(int, number.split("."))) <= NEWEST[name], f"{binary.name} needs {name}_{number}"


def follow_page(title: str) -> None:
    """Types what the page in the archive says."""
    page = (root / PLACE / "README.md").read_text(encoding="utf-8")
    inside(re.search(f"^## {re.escape(title)}$.*?^```sh\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[1], "/tmp/user")


def expect(found: float, wanted: float, scale: float = 0) -> None:
    assert abs(found - wanted) <= 1e-9 * max(abs(wanted), scale), (found, wanted)


def answer(name: str, *arguments: str) -> list:
    """The numbers that an example prints in an empty folder."""
    script = root / EXAMPLES / f"answers/{name}.py"
    lines = script.read_text().splitlines()
    assert len(lines) <= 15 and max(map(len, lines)) <= 120, name
    (root / "tmp" / name).mkdir()
    said = inside(f"{BASE}/tmp/user/env/bin/python {BASE}/{EXAMPLES}/answers/{name}.py {' '.join(arguments)}", f"/tmp/{name}")
    assert not any((root / "tmp" / name).iterdir()), name
    return [float(number) for number in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]\d+)?", said)]


def solve(function, low: float, high: float) -> float:
    """The root of an increasing function."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return low


def rocker_energy(t: complex) -> complex:
    """m v^2/2 + m g y of the rocker's end B, from |B - A| = 3, |B - C| = 2.5 with the crank's end A and the hinge C."""
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


def torque(t: float) -> float:
    """The motor's power is the rate of the energy; by a complex step it has no error of differences."""
    return rocker_energy(t + 1e-30j).imag / 1e-30 / 2


def breaking_instant() -> float:
    """3 m g sin a = 20 N, and t is the integral of da/sqrt(2 g sin a); a = u^2 takes the singularity away."""
    last = math.sqrt(math.asin(20 / (3 * 9.81)))
    n = 2000
    nodes = [last * (k + x) / n for k in range(n) for x in (0.5 - math.sqrt(15) / 10, 0.5, 0.5 + math.sqrt(15) / 10)]
    weights = [last / n * w for _ in range(n) for w in (5 / 18, 4 / 9, 5 / 18)]
    return sum(w * 2 * u / math.sqrt(2 * 9.81 * math.sin(u * u)) for u, w in zip(nodes, weights))


def check_program() -> None:
    inside(f"mkdir user; ln -s {BASE}/{PLACE}/* user")
    follow_page("The program")
    assert (root / "tmp/user/motor/picture.png").stat().st_size > 0
    said = inside(f"""{BASE}/{PLACE}/bin/tanor --version
for scene in {BASE}/{EXAMPLES}/*.json; do {BASE}/{PLACE}/bin/tanor info $scene >info; done  # none needs a file that is not there
for scene in pendulum breaking_rod four_bar_motor; do
  {BASE}/{PLACE}/bin/tanor run {BASE}/{EXAMPLES}/$scene.json --out runs/$scene --trajectory vtp,h5md,npz --report --quiet
  {BASE}/{PLACE}/bin/tanor picture runs/$scene 2>&1
  for file in trajectory.h5 trajectory.npz report.html picture.png summary.json; do test -s runs/$scene/$file; done
done
{BASE}/{PLACE}/bin/tanor run {BASE}/{EXAMPLES}/melt_generated.json --t-end 0.02 --out runs/melt --trajectory lammps --quiet""")
    assert VERSION in said and "Fontconfig" not in said, said
    (passage,) = json.loads((root / "tmp/runs/breaking_rod/summary.json").read_text())["passages"]
    expect(passage["t"], breaking_instant())
    with open(root / "tmp/runs/four_bar_motor/observables.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    (column,) = (name for name in rows[0] if name.startswith("torque"))
    (clock,) = (name for name in rows[0] if re.match(r"t\b", name))
    assert len(rows) > 100
    for row in rows:
        expect(float(row[column]), torque(float(row[clock])), scale=max(abs(float(each[column])) for each in rows))


def check_wheel() -> None:
    (wheel,) = (root / PLACE).glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        listed = [line.split(",")[0] for line in archive.read(f"tanor-{VERSION}.dist-info/RECORD").decode().split()]
        assert sorted(listed) == sorted(archive.namelist()), "RECORD lists other files"
    follow_page("Python")
    said = inside("env/bin/python -c 'import tanor; print(tanor.__version__, tanor.__file__)'", "/tmp/user")
    site = next((root / "tmp/user/env/lib").glob("python3.*/site-packages")).relative_to(root)
    assert said.split() == [VERSION, f"{BASE}/{site}/tanor/__init__.py"], said
    check_binaries(root / site)

    # A link with the vertical force V and the horizontal one H covers H/sqrt(H^2 + V^2) of its length; V = (4.5 - k) m g.
    vertical = [(4.5 - k) * 2 * 9.81 for k in range(10)]
    horizontal = solve(lambda h: sum(h / math.hypot(h, v) for v in vertical) - 8, 1, 1e4)
    ends, middle = answer("cable")
    expect(ends, math.hypot(horizontal, vertical[0]))
    expect(middle, math.hypot(horizontal, vertical[4]))
    start, largest, when = answer("four_bar")
    expect(start, torque(0))
    expect(largest, torque(when))
    assert all(torque(0.01 * k) <= largest * (1 + 1e-9) for k in range(315))
    expect(answer("breaking_rod")[-1], breaking_instant())

    # The tensions of the melt are those that the program writes, in 10 digits, as a dump local.
    rows = (root / "tmp/runs/melt/trajectory_rods.dump").read_text().split("ITEM: ENTRIES")[-1].splitlines()[1:]
    tensions = [float(row.split()[4]) for row in rows]
    bins = answer("melt", f"{BASE}/{EXAMPLES}/melt_generated.json")
    edges, counts = bins[0::2], bins[1::2]
    assert len(counts) == 20 and sum(counts) == len(tensions) == 31680
    assert abs(edges[0] - min(tensions)) < 0.01
    width = (max(tensions) - min(tensions)) / 20
    for k, count in enumerate(counts):
        first = min(tensions) + k * width
        there = sum(first <= tension < first + width or (k == 19 and tension >= first) for tension in tensions)
        near = sum(abs(tension - edge) < 1e-8 for tension in tensions for edge in (first, first + width))
        assert abs(there - count) <= near, (k, there, count)


def check_projects() -> None:
    """That of tests/package, and its program by hand."""
    project, docs = root / "tmp/user/project", root / "tmp/docs"
    for folder in (project, docs):
        folder.mkdir()
    for name in ("CMakeLists.txt", "chain_host.cpp", "pendulum_host.c"):
        shutil.copy(source / "tests/package" / name, project)
    shutil.copy(project / "chain_host.cpp", project.parent / "host.cpp")
    shutil.copy(source / "docs/embedding.md", docs)
    follow_page("C++ and C")
    inside("./host; project/build/chain_host; project/build/host; project/build/pendulum_host", "/tmp/user")


shutil.rmtree(work, ignore_errors=True)
for folder in ("proc", "dev", "tmp", "opt", "root"):
    (root / folder).mkdir(parents=True)
tries_mount = [*CLEAN[:CLEAN.index("bash")], "mount", "-t", "proc", "proc", root / "proc"]
BASE = "" if subprocess.run(tries_mount, check=False).returncode == 0 else str(root)
if is_fresh:
    assert not BASE, "nobody may mount here"
    shutil.rmtree(root)
    run("mmdebstrap", "--variant=minbase", "bookworm", root)
    run("chroot", root, "apt-get", "-q", "update")
elif not BASE:
    for name in ("bin", "sbin", "lib", "lib64"):
        if os.path.islink(f"/{name}"):
            (root / os.readlink(f"/{name}")).mkdir(parents=True)
            (root / name).symlink_to(os.readlink(f"/{name}"))
    add_packages("bash", "coreutils", "dash", "libc-bin")
if given.is_dir():
    run(source / "scripts/bundle.py", given, root / PLACE)
else:
    (root / PLACE).mkdir(parents=True)
    run("tar", "-xf", given, "-C", root / PLACE, "--strip-components=1")
EXAMPLES = f"{PLACE}/share/doc/tanor/examples"
VERSION = re.search(r"VERSION ([\d.]+)", (source / "CMakeLists.txt").read_text().split("project(")[1])[1]
# The program brings what a system may lack.
aside = [] if BASE else [(file, file.with_name(f"aside.{file.name}")) for name in ("libstdc++.so*", "libgcc_s.so*")
                         for file in (root / "usr/lib/x86_64-linux-gnu").glob(name)]
for file, kept in aside:
    file.rename(kept)
check_program()
check_binaries(root / PLACE)
for file, kept in aside:
    kept.rename(file)
add_packages("python3", "python3-venv", "python3-numpy", "libstdc++6")
check_wheel()
add_packages("cmake", "g++", "make")
check_projects()
docs = {file.name for file in (root / PLACE / "share/doc/tanor/docs").iterdir()}
assert {"scene-format.md", "observables.md", "python.md"} <= docs, docs
licences = {file.name for file in (root / PLACE / "share/doc/tanor/licences").iterdir()}
assert {"libcholmod3", "libmetis5", "libgomp1", "libstdc++6", "libeigen3-dev", "libcairo2"} <= licences, licences
shutil.rmtree(work)
print("The archive runs beside this system, where nobody may mount." if BASE else "The archive runs in a clean Debian.")
