#!/usr/bin/python3
"""Installs tanor with the libraries that it needs beside it, for any x86-64 Linux of glibc 2.36 or later.

    bundle.py BUILD ROOT

Libraries of C and C++ are those of the system, as in manylinux (PEP 600), but that the program brings the one of C++; all
others go into ROOT/lib, with their licences, and those of what is compiled in, in ROOT/share/doc/tanor/licences. Programs and libraries find each other by
paths relative to themselves. The package of Python becomes a wheel, ROOT/*.whl.
"""

import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

OF_THE_SYSTEM = re.compile(r"ld-linux|lib(c|m|dl|rt|pthread|resolv|util|mvec|stdc\+\+|gcc_s)\.so")
# Headers of which code lies in the binaries: the Debian packages that have them, and those of them for Python.
OF_PYTHON = ["libeigen3-dev", "libspectra-dev", "nlohmann-json3-dev", "pybind11-dev"]
COMPILED_IN = [*OF_PYTHON, "libcli11-dev"]
# CHOLMOD is linked with a BLAS, which tanor never calls: the smallest one, whichever stands here as the alternative.
REFERENCE_BLAS = "/usr/lib/x86_64-linux-gnu/blas:/usr/lib/x86_64-linux-gnu/lapack"


def output_of(*command, **options) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def is_elf(file: pathlib.Path) -> bool:
    with open(file, "rb") as content:
        return content.read(4) == b"\x7fELF"


def list_binaries(folder: pathlib.Path) -> list:
    return [file for file in sorted(folder.rglob("*")) if file.is_file() and not file.is_symlink() and is_elf(file)]


def list_libraries(binaries: list, own: pathlib.Path) -> dict:
    """Returns the files of all libraries that the binaries load, by name, without those of the system and `own`."""
    libraries = {}
    for binary in binaries:
        listed = output_of("ldd", binary, env=os.environ | {"LD_LIBRARY_PATH": REFERENCE_BLAS})
        for name, file in re.findall(r"^\s*(\S+) => (.*?) \(0x", listed, re.MULTILINE):
            if not OF_THE_SYSTEM.match(name) and own not in pathlib.Path(file).resolve().parents:
                libraries[name] = pathlib.Path(file)
    missing = [name for name, file in libraries.items() if not file.is_file()]
    if missing:
        sys.exit(f"bundle.py: these libraries are missing: {' '.join(missing)}")
    return libraries


def set_search_path(binary: pathlib.Path, folder: pathlib.Path):
    way = pathlib.Path(*[".."] * len(binary.parent.relative_to(folder.parent).parts)) / folder.name
    path = "$ORIGIN" if binary.parent == folder else f"$ORIGIN/{way}"
    subprocess.run(["patchelf", "--set-rpath", path, binary], check=True)


def find_package(library: pathlib.Path) -> str:
    for file in (library, library.resolve()):
        owner = subprocess.run(["dpkg", "-S", file], capture_output=True, text=True, check=False).stdout
        if not owner and file.is_relative_to("/lib"):
            owner = subprocess.run(["dpkg", "-S", f"/usr{file}"], capture_output=True, text=True, check=False).stdout
        if owner:
            return owner.split(":")[0]
    sys.exit(f"bundle.py: no package has {library}")


def copy_licence(package: str, folder: pathlib.Path):
    shutil.copy(f"/usr/share/doc/{package}/copyright", folder / package)


def bundle(binaries: list, own: pathlib.Path, folder: pathlib.Path, licences: pathlib.Path, compiled_in: list):
    """Puts what `binaries` load from outside `own` into `folder`, and lets all of them look there."""
    folder.mkdir(parents=True, exist_ok=True)
    licences.mkdir(parents=True, exist_ok=True)
    for package in compiled_in:
        copy_licence(package, licences)
    for name, file in list_libraries(binaries, own).items():
        shutil.copy(file, folder / name)
        (folder / name).chmod(0o755)
        copy_licence(find_package(file), licences)
        set_search_path(folder / name, folder)
    for binary in binaries:
        set_search_path(binary, folder)


def bring_cxx(root: pathlib.Path, licences: pathlib.Path):
    """Gives the program the library of C++ in a folder where it alone looks. Beside libtanor.so it would come before that of
    a host's own system, which may be newer; linked statically, exceptions would pass between two of them."""
    program, folder = root / "bin/tanor", root / "lib/tanor/c++"
    folder.mkdir()
    for name, file in re.findall(r"(libstdc\+\+\S+|libgcc_s\S+) => (\S+)", output_of("ldd", program)):
        shutil.copy(file, folder / name)
        copy_licence(find_package(pathlib.Path(file)), licences)
        set_search_path(folder / name, folder)
    subprocess.run(["patchelf", "--set-rpath", "$ORIGIN/../lib:$ORIGIN/../lib/tanor/c++", program], check=True)


def make_wheel(root: pathlib.Path, version: str):
    """Moves the package of Python into a wheel (PEP 427) that holds its libraries, in the folder tanor.libs."""
    module = next(root.glob("lib/python3*/**/tanor/_core.cpython-*.so"))
    python = re.search(r"cpython-(\d+)", module.name)[1]
    staged = root / "wheel"
    shutil.copytree(module.parent, staged / "tanor", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.rmtree(next(root.glob("lib/python3*")))
    folder = staged / "tanor.libs"
    folder.mkdir()
    shutil.copy(root / "lib/libtanor.so.0", folder)
    own = [staged / "tanor" / module.name, folder / "libtanor.so.0"]
    for binary in own:
        set_search_path(binary, folder)
    tag = f"cp{python}-cp{python}-manylinux_2_36_x86_64"
    about = staged / f"tanor-{version}.dist-info"
    about.mkdir()
    bundle(own, staged, folder, about / "licenses", OF_PYTHON)
    shutil.copy(root / "share/doc/tanor/LICENSE", about / "licenses")
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: tanor\nVersion: {version}\n"
                                    "Summary: Motion and reactions of large systems of points under constraints\n"
                                    "Requires-Python: >=3.11\nRequires-Dist: numpy<2\n")  # pybind11 before 2.12 does not know numpy 2
    (about / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: tanor\nRoot-Is-Purelib: false\nTag: {tag}\n")
    files = sorted(file for file in staged.rglob("*") if file.is_file())
    with zipfile.ZipFile(root / f"tanor-{version}-{tag}.whl", "w", zipfile.ZIP_DEFLATED) as wheel:
        lines = []
        for file in files:
            name = file.relative_to(staged).as_posix()
            digest = base64.urlsafe_b64encode(hashlib.sha256(file.read_bytes()).digest()).rstrip(b"=").decode()
            lines.append(f"{name},sha256={digest},{file.stat().st_size}")
            wheel.write(file, name)
        wheel.writestr(f"{about.name}/RECORD", "\n".join([*lines, f"{about.name}/RECORD,,", ""]))
    shutil.rmtree(staged)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    build, root = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    cache = (build / "CMakeCache.txt").read_text()
    cmake, version = (re.search(f"^{name}:.*?=(.*)$", cache, re.MULTILINE)[1]
                      for name in ("CMAKE_COMMAND", "CMAKE_PROJECT_VERSION"))
    for component in ("runtime", "development", "program", "python"):
        output_of(cmake, "--install", build, "--component", component, "--prefix", root, "--strip")
    if any(root.glob("lib/python3*")):
        make_wheel(root, version)
    docs = pathlib.Path(__file__).parents[1] / "docs"
    shutil.copy(docs / "portable.md", root / "README.md")
    for_builders = ("architecture.md", "contributing.md", "portable.md", "Doxyfile", "pictures")
    shutil.copytree(docs, root / "share/doc/tanor/docs", ignore=shutil.ignore_patterns(*for_builders))
    for page in (root / "share/doc/tanor/docs").glob("*.md"):  # of links to what stays behind the words are left
        page.write_text(re.sub(r"!?\[([^]]+)\]\(([\w./-]+\.\w+)(#[\w-]+)?\)",
                               lambda link: link[0] if (page.parent / link[2]).exists() else link[1], page.read_text()))
    licences = root / "share/doc/tanor/licences"
    bundle(list_binaries(root), root, root / "lib", licences, COMPILED_IN)
    bring_cxx(root, licences)


main()
