#!/usr/bin/python3
"""Bundles an installed tanor, moves it, and runs it: nothing that it loads is from elsewhere but libraries of C and C++.

    check_portable.py BUILD CMAKE VERSION WORK
"""

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

for home in (root, work / "site"):
    binaries = [file for file in home.rglob("*") if file.is_file() and open(file, "rb").read(4) == b"\x7fELF"]
    assert len(binaries) > 10, home
    for binary in binaries:
        for name, file in re.findall(r"^\s*(\S+) => (.*?)(?: \(0x|$)", run("ldd", binary, env=CLEAN), re.MULTILINE):
            is_given = re.match(r"lib(c|m|dl|rt|pthread|resolv|stdc\+\+|gcc_s)\.so", name)
            assert is_given or home in pathlib.Path(file).parents, f"{binary.name} loads {name} from {file}"
assert (root / "share/doc/tanor/licences/libcholmod3").is_file()
