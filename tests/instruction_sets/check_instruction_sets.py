#!/usr/bin/python3
"""check_instruction_sets.py PROGRAM FOLDER: the same answers from the code of every instruction set.

Hot loops are compiled for several instruction sets, of which the best one that the processor has is taken, or the one
that TANOR_ISA names. With each of them, systems large enough for it are solved and moved on several threads: to the same
bits. Then an emulator (qemu-user-static) plays processors of the baseline and with AVX2, which must not meet newer
instructions anywhere. Fused multiplications round differently, so sets agree to rounding, not to the last bit.
"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

SKIPPED = 77  # as CMakeLists.txt says
EMULATOR = "qemu-x86_64-static"
PROCESSORS = ("qemu64", "Haswell")  # x86-64-v1, x86-64-v3
SETS = ("baseline", "avx2", "avx512")
IS_LONG = os.environ.get("TANOR_LONG_TESTS") == "1"
THREADS = ("1", "2", "5") if IS_LONG else ("1", "5")
ROUNDING = 1e-11  # of an instant, relative; an emulated run of a few steps leaves no more either

GRAVITY = {"kind": "gravity", "acceleration": [0.3, 0.2, -9.81]}


def generated(kind: str, **more) -> dict:
    return {"generate": {"kind": kind, "spacing": 0.1, "mass": 0.1, "seed": 3, **more}, "forces": [GRAVITY]}


def beads(count: int, **more) -> dict:
    places = [[math.cos(0.1 * k), math.sin(0.1 * k), 0.0] for k in range(count)]
    return {"points": {"positions": places, "masses": 0.2}, "forces": [GRAVITY], **more}


def list_scenes() -> dict:
    all_points = {"points": "all", "center": [0, 0, 0], "radius": 1}
    circle = {"kind": "circle", "normal": [0, 0, 1], **all_points}
    sphere = {"name": "ball", "kind": "sphere", **all_points}
    friction = [{"kind": "coulomb", "at": "ball", "coefficient": 0.2}]
    moving = [[-math.sin(0.1 * k), math.cos(0.1 * k), 0.5] for k in range(60)]
    rough = beads(60, constraints=[sphere], friction=friction)
    rough["points"]["velocities"] = moving
    return {
        "chain": generated("chain", count=300, direction=[1, 0.2, 0.1], anchored=True),
        "ring": generated("ring", count=40),
        "tree": generated("tree", count=200),
        "clusters": generated("clusters", clusters=30, count=6),
        "net": generated("net", columns=24, rows=20 if IS_LONG else 10),
        "lattice": generated("lattice", size=[7, 7, 7] if IS_LONG else [5, 5, 5]),
        "circles": beads(60, constraints=[circle]),
        "circles in coordinates": beads(60, coordinates=[circle]),
        "spheres": beads(60, constraints=[sphere]),
        "rough spheres": rough,
    }


def list_large_scenes() -> dict:
    """Those of the largest number of points of which a summary tells where they are."""
    held = {"supports": [{"points": [0]}]}
    return {
        "long chain": generated("chain", count=9900, direction=[1, 0.2, 0.1], anchored=True),
        "large tree": {**generated("tree", count=9900), **held},
        "many clusters": generated("clusters", clusters=1200, count=6),
        "large net": {**generated("net", columns=70, rows=60), **held},
        "large lattice": {**generated("lattice", size=[11, 11, 11]), **held},
    }


def check(condition: bool, what: str) -> None:
    print(("ok    " if condition else "WRONG ") + what)
    if not condition:
        sys.exit(1)


def find_numbers(value) -> list:
    if isinstance(value, list):
        return [number for each in value for number in find_numbers(each)]
    return [value] if isinstance(value, (int, float)) and not isinstance(value, bool) else []


def distance(a, b) -> float:
    a, b = find_numbers(a), find_numbers(b)
    if len(a) != len(b) or not a:
        return math.inf
    return max(abs(x - y) for x, y in zip(a, b)) / max(max(abs(x) for x in a), 1e-300)


def answers(command: list, scene: pathlib.Path, out: pathlib.Path, *of_run: str) -> dict:
    """The instant at the start, and where some steps lead."""
    # BLAS chooses by itself: that is not what is compared. With one thread set the program does not start itself again.
    environment = dict(os.environ, OPENBLAS_CORETYPE="Prescott", OPENBLAS_NUM_THREADS="1")
    quiet = {"stderr": subprocess.DEVNULL, "check": True, "env": environment}  # of features that the emulator lacks
    instant = json.loads(subprocess.run([*command, "solve", scene], stdout=subprocess.PIPE, **quiet).stdout)
    subprocess.run([*command, "run", scene, "--out", out, "--quiet", *of_run], stdout=subprocess.DEVNULL, **quiet)
    final = json.loads((out / "summary.json").read_text())["final"]
    return {"accelerations": instant["accelerations"], "multipliers": instant["multipliers"],
            "positions": final["positions"], "velocities": final["velocities"]}


def write_scene(place: pathlib.Path, scene: dict, **motion) -> pathlib.Path:
    place.mkdir(parents=True, exist_ok=True)
    file = place / "scene.json"
    # Points of a ring or a cluster move as their constraints allow.
    file.write_text(json.dumps({"tanor_scene": 1, **scene, "motion": {**motion, "start": "project"}}))
    return file


def compare(name: str, what_plays: str, first: dict, second: dict) -> None:
    for what in first:
        if first[what] == [] or first[what] is None:
            continue
        apart = distance(first[what], second[what])
        check(apart <= ROUNDING, f"{name}: {what} {what_plays} apart by {apart:.1e}")


def check_sets(program: str, folder: pathlib.Path) -> None:
    def has(name: str) -> bool:
        return subprocess.run([program, "--version"], env=dict(os.environ, TANOR_ISA=name), check=False,
                              capture_output=True).returncode == 0

    sets = [name for name in SETS if has(name)]
    check(sets[:1] == ["baseline"], f"the sets of this processor: {', '.join(sets)}")
    taken = {"baseline"}
    for name, scene in list_large_scenes().items():
        place = folder / name.replace(" ", "_")
        file = write_scene(place, scene, t_end=0.002, method="rattle", step=5e-4)
        of_baseline = None
        for pinned in sets:
            os.environ["TANOR_ISA"] = pinned
            alone, *others = (answers([program], file, place / pinned, "--threads", threads) for threads in THREADS)
            check(all(other == alone for other in others), f"{name}: {pinned} has the same bits on any threads")
            if of_baseline is not None:
                taken |= {pinned} if alone != of_baseline else set()
                # Velocities of long chains are the rounding of places over a step.
                compare(name, f"with {pinned}", {**of_baseline, "velocities": None}, alone)
            of_baseline = of_baseline or alone
    del os.environ["TANOR_ISA"]
    check(taken == set(sets), f"other bits with other sets, which are taken: {', '.join(sorted(taken))}")


def check_processors(program: str, folder: pathlib.Path) -> None:
    for name, scene in list_scenes().items():
        place = folder / name.replace(" ", "_")
        file = write_scene(place, scene, t_end=0.02)
        native = answers([program], file, place / "native")
        for processor in PROCESSORS:
            compare(name, f"on {processor}", native, answers([EMULATOR, "-cpu", processor, program], file,
                                                             place / processor))


def main() -> None:
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    check_sets(program, folder)
    if shutil.which(EMULATOR) is None:
        check(os.environ.get("CI") != "true", f"{EMULATOR} is there, or nobody insists on it")
        sys.exit(SKIPPED)
    check_processors(program, folder)


if __name__ == "__main__":
    main()
