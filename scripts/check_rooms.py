#!/usr/bin/python3
"""Reads the #include lines of src/ and include/ and fails on a wrong arrow between the rooms, or between the layers,
of the house.

    check_rooms.py [ROOT]        check the tree at ROOT (default: this repository)
    check_rooms.py --self-test   prove that wrong arrows are caught
"""

import pathlib
import re
import sys
import tempfile
from typing import NamedTuple

# Public headers in the order in which they build on each other: each may include those before it, the standard
# library and nothing else.
PUBLIC_HEADERS = ["export", "version", "build_info", "error", "jet", "forward", "curved", "expression", "time_function", "kernel", "recorded", "user_kernel", "kinds/*", "kinds",
                  "units", "cell", "system", "warnings", "ranks",
                  "solver_options", "certificate", "dynamics", "observables", "constrainer", "velocity_verlet", "inverse_dynamics",
                  "direct_problem", "equilibrium", "modes", "motion", "report_fields", "enum_names", "statics_names", "tanor"]


class Sees(NamedTuple):
    rooms: str    # other rooms whose headers it may include; or single headers of a room, which then keep to this rule
                  # too, so that nothing else is reached through them
    public: str   # the last public header (in the order above) that it may include
    foreign: str  # headers that belong neither to us nor to the standard library; "x/" is a folder


# include/tanor.h, for C.
C_HEADER = "tanor.h"

# Headers of a folder of kinds may include one another.
FOLDER = "kinds/*"


def public_name(header: str) -> str:
    """"tanor/kinds/force/drag.hpp" -> "kinds/*", "tanor/jet.hpp" -> "jet"."""
    if header == C_HEADER:
        return header
    inner = header.removeprefix("tanor/").removesuffix(".hpp").removesuffix(".h")
    return FOLDER if inner.startswith("kinds/") else inner


# The folders of src, and the layers whose rooms theirs may see beside their own. The core sees no module.
LAYERS = {
    "core": "",
    "modules": "core",
    "faces": "core modules",
    "program": "core",
    "bindings": "core program",
}

# room: what it may see. Data flows downwards; look upstream.
ROOMS = {
    # core
    "base":     Sees("", "error", "omp.h sys/mman.h Eigen/"),
    "plan":     Sees("", "export", ""),
    "system":   Sees("base", "warnings", "Eigen/"),
    "kinds":    Sees("base system", "system", ""),
    "evaluate": Sees("base system kinds", "system", "Eigen/"),
    "assembly": Sees("base system evaluate plan", "system", "Eigen/"),
    "factor":   Sees("base plan", "solver_options", "omp.h cholmod.h SuiteSparseQR.hpp klu.h metis.h Eigen/"),
    "schur":    Sees("base system evaluate assembly factor plan", "solver_options", ""),
    "dynamics": Sees("base system evaluate assembly factor plan schur", "inverse_dynamics", "Eigen/"),
    "motion":   Sees("base dynamics/mechanics.hpp dynamics/decisions.hpp dynamics/roles.hpp dynamics/corner_functions.hpp dynamics/implicit_equations.hpp "
                     "dynamics/instant.hpp dynamics/power.hpp", "motion", ""),
    # modules
    "friction": Sees("base system evaluate schur dynamics", "dynamics", "Eigen/"),
    "contact":  Sees("base system evaluate schur dynamics factor/sparse_lu.hpp friction/contact_problem.hpp friction/range.hpp", "dynamics", "Eigen/"),
    "statics":  Sees("base system evaluate assembly factor plan schur dynamics contact/exchange.hpp", "modes", "Eigen/ Spectra/"),
    "certificate": Sees("base system evaluate assembly factor schur dynamics", "certificate", "Eigen/"),
    "observe":  Sees("base system evaluate", "observables", ""),
    "host":     Sees("base system evaluate assembly schur dynamics observe", "velocity_verlet", "tanor.h"),
    "ranks":    Sees("base system evaluate assembly factor schur dynamics", "inverse_dynamics", ""),
    # faces
    "simulation": Sees("base system evaluate assembly schur friction dynamics ranks observe certificate motion", "enum_names", "Eigen/"),
    # program
    "scene":    Sees("base/member_names.hpp base/text.hpp base/suggestion.hpp", "tanor", "nlohmann/ fmt/ unistd.h sys/resource.h"),
    "report":   Sees("scene system/members.hpp base/archive.hpp base/checksum.hpp base/member_names.hpp base/text.hpp base/vec3.hpp base/with_unit.hpp", "tanor", "nlohmann/ fmt/ unistd.h fcntl.h spawn.h sys/wait.h sys/ioctl.h "
                     "zlib.h dlfcn.h"),
    "formats":  Sees("report scene", "observables", "fmt/ unistd.h fcntl.h sys/resource.h hdf5.h zip.h"),
    "picture":  Sees("base/vec3.hpp base/with_unit.hpp system/operations.hpp report/colours.hpp report/guides.hpp report/vtp_reader.hpp report/motion_extent.hpp", "system", "cairo.h"),
    "view":     Sees("", "export", "httplib.h sys/socket.h"),
    "cli":      Sees("base/text.hpp base/suggestion.hpp scene report view picture", "tanor",
                     "nlohmann/ fmt/ CLI/ poll.h unistd.h fcntl.h spawn.h sys/file.h sys/mman.h sys/resource.h sys/stat.h dlfcn.h"),
    # bindings
    "python":   Sees("scene system/members.hpp base/member_names.hpp base/suggestion.hpp", "tanor", "pybind11/"),
    "embed":    Sees("", "constrainer", "mpi.h atom.h comm.h domain.h error.h fix.h force.h group.h input.h lammps.h "
                     "modify.h update.h OpenMM.h openmm/"),
    "mpi":      Sees("system/members.hpp system/chosen_members.hpp system/fingerprint.hpp base/disjoint_sets.hpp base/groups.hpp base/checksum.hpp base/archive.hpp base/member_names.hpp cli "
                     "scene report", "tanor",
                     "mpi.h metis.h omp.h unistd.h fcntl.h fmt/"),
}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)


def is_standard(header: str) -> bool:
    """<vector>, <cmath>: the standard library has neither a folder nor an ending."""
    return re.fullmatch(r"[a-z0-9_]+", header) is not None


def is_listed(header: str, foreign: str) -> bool:
    return any(header == entry or (entry.endswith("/") and header.startswith(entry)) for entry in foreign.split())


def wrong_public_header(header: str, last: str) -> str | None:
    """Why `header` (tanor/x.hpp) must not be seen by one who may see the public headers up to `last`."""
    name = public_name(header)
    if name not in PUBLIC_HEADERS:
        return "unknown public header: give it its place in PUBLIC_HEADERS"
    if PUBLIC_HEADERS.index(name) > PUBLIC_HEADERS.index(last):
        return f"the public headers end at <tanor/{last}.hpp> here"
    return None


def wrong_include_of_layer(layers: dict[str, str], room: str, header: str) -> str | None:
    """`layers`: room -> its layer."""
    own, other = layers[room], layers.get(header.split("/")[0])
    if other is None or other == own or other in LAYERS[own].split():
        return None
    return f"{own} may see: {LAYERS[own] or 'no other layer'}"


def wrong_include_of_room(room: str, sees: Sees, quoted: bool, header: str) -> str | None:
    first = header.split("/")[0]
    if quoted:
        if first not in ROOMS or "/" not in header or ".." in header:
            return 'write our own headers as "room/file.hpp"'
        if first != room and first not in sees.rooms.split() and header not in sees.rooms.split():
            return f"{room} may see: {sees.rooms or 'no other room'}"
        return None
    if first == "tanor":
        return wrong_public_header(header, sees.public)
    if first in ROOMS:
        return 'write our own headers as "room/file.hpp"'
    if is_standard(header) or is_listed(header, sees.foreign):
        return None
    return f"foreign headers of {room}: {sees.foreign or 'none'}"


def wrong_include_of_file(file: str, quoted: bool, header: str) -> str | None:
    """The rule of the file's room, and of the rooms that see just this header. `file` begins with its room."""
    room = file.split("/")[0]
    rule = wrong_include_of_room(room, ROOMS[room], quoted, header)
    for other, sees in ROOMS.items():
        if rule is None and file in sees.rooms.split():
            rule = wrong_include_of_room(other, sees, quoted, header)
    return rule


def wrong_include_of_public_header(own: str, quoted: bool, header: str) -> str | None:
    if own == C_HEADER:
        return None if not quoted and header in ("stddef.h", "stdint.h") else "the C header needs <stddef.h> and <stdint.h> alone"
    if own not in PUBLIC_HEADERS:
        return f"give <tanor/{own}.hpp> its place in PUBLIC_HEADERS"
    if quoted:
        return "public headers include <tanor/...> and the standard library only"
    if header.startswith("tanor/"):
        if own == "export":
            return "<tanor/export.hpp> stands first"
        last = own if own == FOLDER else PUBLIC_HEADERS[PUBLIC_HEADERS.index(own) - 1]
        return wrong_public_header(header, last)
    return None if is_standard(header) else "a user needs the standard library and nothing else"


def wrong_arrows(root: pathlib.Path) -> list[str]:
    """One line a wrong include: file:line, the include, the rule."""
    found = []
    layers = {room.name: room.parent.name for room in (root / "src").glob("*/*")}
    files = [f for folder in ("include", "src") for f in sorted((root / folder).rglob("*"))
             if f.suffix in (".h", ".hpp", ".cpp")]
    for file in files:
        place = file.relative_to(root)
        text = file.read_text(encoding="utf-8")
        for match in INCLUDE.finditer(text):
            quoted, header = match[1] == '"', match[2]
            if place.parts[0] == "include":
                own = public_name("/".join(place.parts[1:]))
                rule = wrong_include_of_public_header(own, quoted, header)
            elif place.parts[1] not in LAYERS:
                rule = f"src/{place.parts[1]} is no layer: give it its line in LAYERS"
            elif place.parts[2] not in ROOMS:
                rule = f"{place.parent} is no room: give it its line in ROOMS"
            else:
                rule = wrong_include_of_file("/".join(place.parts[2:]), quoted, header)
                if rule is None and quoted:
                    rule = wrong_include_of_layer(layers, place.parts[2], header)
            if rule:
                line = text.count("\n", 0, match.start()) + 1
                found.append(f"{place}:{line}: {match[0].strip()}: {rule}")
    return found


def self_test() -> int:
    """Each case is one file of one line; the checker must say what the case says."""
    wrong = [
        ("src/core/factor/a.cpp", '#include "assembly/gather_plan.hpp"'),
        ("src/core/system/a.cpp", '#include "evaluate/kernels.hpp"'),
        ("src/core/motion/a.cpp", '#include "factor/cholesky.hpp"'),
        ("src/core/motion/a.cpp", '  #  include "dynamics/multiplier_form.hpp"'),
        ("src/core/motion/a.hpp", '#include "factor/cholesky.hpp"'),
        ("src/core/dynamics/mechanics.hpp", '#include "assembly/gather_plan.hpp"'),
        ("src/core/dynamics/roles.hpp", '#include "dynamics/multiplier_form.hpp"'),
        ("src/core/evaluate/a.hpp", "#include <tanor/motion.hpp>"),
        ("src/core/evaluate/a.hpp", "#include <cholmod.h>"),
        ("src/core/dynamics/a.cpp", "#include <metis.h>"),
        ("src/program/scene/a.cpp", '#include "report/summary.hpp"'),
        ("src/program/scene/a.cpp", '#include "base/check.hpp"'),
        ("src/program/cli/a.cpp", "#include <Eigen/Dense>"),
        ("src/core/base/a.hpp", '#include "vec3.hpp"'),
        ("src/core/base/a.hpp", '#include "../system/members.hpp"'),
        ("src/core/base/a.hpp", "#include <system/members.hpp>"),
        ("src/attic/base/a.cpp", "#include <vector>"),
        ("src/core/attic/a.cpp", "#include <vector>"),
        ("src/core/dynamics/a.cpp", '#include "friction/laws.hpp"'),
        ("include/tanor/system.hpp", "#include <Eigen/Core>"),
        ("include/tanor/system.hpp", "#include <tanor/motion.hpp>"),
        ("include/tanor/kinds/force/drag.hpp", "#include <tanor/kinds.hpp>"),
        ("src/core/kinds/a.hpp", '#include "evaluate/family.hpp"'),
        ("include/tanor/system.hpp", '#include "base/vec3.hpp"'),
        ("include/tanor/unheard_of.hpp", "#include <vector>"),
    ]
    right = [
        ("src/core/evaluate/a.cpp", '#include "system/members.hpp"'),
        ("src/core/evaluate/a.cpp", "#include <tanor/system.hpp>"),
        ("src/core/factor/a.cpp", "#include <cholmod.h>"),
        ("src/core/dynamics/a.cpp", '#include "schur/gram_solver.hpp"'),
        ("src/core/motion/a.cpp", "#include <tanor/dynamics.hpp>"),
        ("src/core/motion/a.cpp", '#include "dynamics/mechanics.hpp"'),
        ("src/faces/simulation/simulation.cpp", '#include "certificate/certificate.hpp"'),
        ("src/core/dynamics/mechanics.hpp", '#include "base/parallel.hpp"'),
        ("src/program/cli/a.cpp", '#include "report/summary.hpp"'),
        ("include/tanor/dynamics.hpp", "#include <tanor/system.hpp>"),
        ("include/tanor/kinds/force/drag.hpp", "#include <tanor/kinds/kind.hpp>"),
        ("src/core/evaluate/a.hpp", "#include <tanor/kinds/line_frame.hpp>"),
        ("include/tanor/dynamics.hpp", "#include <vector>"),
    ]
    failures = 0
    for cases, expected in ((wrong, 1), (right, 0)):
        for name, line in cases:
            with tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder) / name
                file.parent.mkdir(parents=True)
                file.write_text("#pragma once\n" + line + "\n", encoding="utf-8")
                answer = wrong_arrows(pathlib.Path(folder))
            if len(answer) != expected:
                failures += 1
                print(f"{'passed by' if expected else 'refused'}: {name}: {line} {answer}")
    print(f"check_rooms self-test: {len(wrong) + len(right)} cases, {failures} wrong")
    return 1 if failures else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--self-test"]:
        return self_test()
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).resolve().parent.parent)
    if not (root / "src").is_dir():
        print(f"{root}: no src/ there", file=sys.stderr)
        return 2
    found = wrong_arrows(root)
    print("\n".join(found) if found else "rooms: every arrow points upstream")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
