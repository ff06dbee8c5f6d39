#!/usr/bin/python3
"""Every file that tanor writes names what it has, with the letters of the scene's units, and has none where the scene has none.

    name_results.py TANOR FOLDER

Runs each command that writes results, with letters that stand nowhere else and without units, and walks over all files: one
that no check of this script knows is an error. What was observed must be the same numbers in CSV, NPZ, H5MD and summary.json,
under the same names. Without h5py the H5MD file is passed over, but not under CI.
"""

import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np

from trajectory_readers import FORMATS, h5py, read_npz

LETTERS = {"length": "lenQ", "mass": "masQ", "time": "timQ of 32 eyes, or more or less", "force": "forQ", "energy": "eneQ",
           "temperature": "temQ", "pressure": "preQ"}
TIME = LETTERS["time"]
SPEED = f"lenQ/({TIME})"

# A bead on three rods between two hooks, and what is asked of it: numbers, vectors, members, vectors of members, formulas.
OBSERVED = [
    {"what": "max tension(links)", "every_step": True}, "tension(links)", "load(hooks)", "each load(hooks)", "temperature()",
    {"name": "weight/g, 'quoted'", "what": "load(hooks).z/9.81", "unit": "masQ"}, {"name": "speed", "what": "velocity(1).norm"}, "energy()",
    {"name": "tension", "what": "min tension(links)"}, {"name": "turn", "what": "moment(hooks, y)"}, "angle(0, 1, 2)",
    {"name": "weight|g, 'quoted'", "what": "2*t"}, {"name": "observed tension", "what": "3*t"}, {"name": ".", "what": "4*t"},
    {"name": "α\\\U0001f600", "what": "5*t"}, {"name": "β\\\U0001f601", "what": "6*t"}]
UNITS = ["forQ", "forQ", "forQ", "forQ", "temQ", "masQ", SPEED, "eneQ", "forQ", "forQ lenQ", "rad", "", "", "", "", ""]
# Names of groups of H5MD that would meet another, or that HDF5 reads otherwise.
GROUPS = {"weight|g, 'quoted'": "observed weight|g, 'quoted'", "tension": "observed tension",
          "observed tension": "observed observed tension", ".": "observed ."}
SCENE = {
    "tanor_scene": 1,
    "points": {"positions": [[0, 0, 0], [0.6, 0, -0.7], [1.5, 0, -0.7], [2.2, 0, 0]], "masses": 2,
               "velocities": [[0, 0, 0], [0, 0, 0], [0, 1, 0], [0, 0, 0]]},
    "supports": [{"name": "hooks", "points": [0, 3]}],
    "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [1, 2], [2, 3]]},
                    {"name": "rail", "kind": "line", "points": [1], "origin": [0.6, 0, -0.7], "direction": [1, 0, -1]}],
    "forces": [{"name": "weight", "kind": "gravity", "acceleration": [0, 0, -9.81]}],
    "observe": OBSERVED,
    "motion": {"method": "dop853", "t_end": 0.5, "output_every": 0.1, "start": "project", "trajectory": FORMATS}}
HANGING = {key: value for key, value in SCENE.items() if key != "constraints"} | {
    "constraints": [SCENE["constraints"][0] | {"length": 0.9}]}


class Folder:
    """The results of one command, and the letters that they must have; none are empty."""

    def __init__(self, path: pathlib.Path, command: str, letters: dict):
        self.path, self.command, self.letters = path, command, letters

    def unit(self, text: str) -> str:
        return text if self.letters else ""

    def head(self, name: str, unit: str) -> str:
        return f"{name} [{unit}]" if self.letters else name


def expect_letters(text: str, wanted: list, folder: Folder, file: pathlib.Path) -> None:
    for letters in LETTERS.values():
        assert folder.letters or letters not in text, f"{file} has {letters} without units"
    for letters in wanted if folder.letters else []:
        assert letters in text, f"{file} does not name {letters}"


def read_table(folder: Folder) -> dict:
    with open(folder.path / "observables.csv", encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head[0] == folder.head("t", TIME), head
    return {name: np.array([float(row[k] or "nan") for row in rows]) for k, name in enumerate(head)}


def list_columns() -> list:
    """Names and units of all numbers that are observed, spelled once more."""
    members = {"tension(links)": [f"tension(links): links[{k}]" for k in range(3)],
               "load(hooks)": [f"load(hooks).{part}" for part in "xyz"],
               "each load(hooks)": [f"each load(hooks): hooks[{k}].{part}" for k in range(2) for part in "xyz"]}
    names = [each if isinstance(each, str) else each.get("name", each["what"]) for each in OBSERVED]
    return [(column, unit) for name, unit in zip(names, UNITS) for column in members.get(name, [name])]


def check_observables(folder: Folder, file: pathlib.Path) -> None:
    heads = list(read_table(folder))[1:]
    known = [folder.head(name, unit) if unit else name for name, unit in list_columns()]
    assert heads == known, f"{file}: {heads}, not {known}"


def check_units_of_json(told: dict, folder: Folder, file: pathlib.Path) -> None:
    units = told["units"]
    assert units["name"] == ("own" if folder.letters else "none"), f"{file}: {units}"
    assert {key: units[key] for key in LETTERS} == (folder.letters or dict.fromkeys(LETTERS)), f"{file}: {units}"


def check_json(folder: Folder, file: pathlib.Path) -> None:
    told = json.loads(file.read_text(encoding="utf-8"))
    if "tanor_scene" in told:  # the equilibrium as a scene
        assert told.get("units") == (folder.letters or None), told.get("units")
        return
    check_units_of_json(told, folder, file)
    if folder.command != "modes":
        groups, multipliers = {group.pop("name"): group for group in told["groups"]}, told.get("multipliers", [])
        count = told.get("equations", len(np.load(file.parent / multipliers) if isinstance(multipliers, str) else multipliers))
        assert groups["links"] == {"kind": "rod", "first": 0, "members": 3, "rows": 1}, f"{file}: {groups}"
        assert sum(group["members"] * group["rows"] for group in groups.values()) == count, f"{file}: {groups}"
        if "rail" in groups:
            assert groups["rail"] == {"kind": "line", "first": 3, "members": 1, "rows": 2}, f"{file}: {groups}"
    if folder.command == "forces":
        return
    observed = told["observables"]
    assert [each["unit"] or "" for each in observed] == [folder.unit(unit) for unit in UNITS], f"{file}: {observed}"
    assert observed[2]["parts"] == ["x", "y", "z"] and observed[1]["members"] == ["links[0]", "links[1]", "links[2]"]
    assert observed[0]["name"] == "max tension(links)" and observed[0]["member"].startswith("links[")
    if folder.command == "solve":
        return
    table = list(read_table(folder).values())
    last = np.concatenate([each["values"] for each in observed])
    assert last.tolist() == [column[-1] for column in table[1:]], f"{file} and observables.csv differ"
    if folder.command == "run":
        check_extremes(observed, table)


def check_extremes(observed: list, table: list) -> None:
    """Extremes are those of the frames, and where all steps were asked for no narrower; they have their times."""
    first, times = 1, table[0]
    for k, each in enumerate(observed):
        width, count = len(each["values"]), len(each["least"])
        numbers = np.array(table[first:first + width]).reshape(-1, count, len(times))
        for part in range(count):
            least, largest = each["least"][part], each["largest"][part]
            assert least["value"] <= numbers[:, part].min() and largest["value"] >= numbers[:, part].max(), each["name"]
            if k > 0:
                assert least["value"] == numbers[:, part].min() and largest["value"] == numbers[:, part].max(), each["name"]
                place = np.argmin(abs(times - largest["t"]))
                assert abs(times[place] - largest["t"]) < 1e-12 and largest["value"] in numbers[:, part, place], each["name"]
            assert bool(largest["member"]) == bool(each["members"] or each["member"]), each
        first += width


def check_npz(folder: Folder, file: pathlib.Path) -> None:
    arrays, table = read_npz(file.parent), read_table(folder)
    observed = arrays["observables"]
    assert observed["t"].tolist() == table.pop(folder.head("t", TIME)).tolist()
    assert observed.dtype["load(hooks)"].shape == (3,) and observed.dtype["each load(hooks)"].shape == (2, 3)
    assert list(observed.dtype.names[1:]) == [each if isinstance(each, str) else each.get("name", each["what"]) for each in OBSERVED]
    flat = np.concatenate([observed[name].reshape(len(observed), -1) for name in observed.dtype.names[1:]], axis=1)
    assert np.array_equal(flat.T, np.array(list(table.values()))), "numbers of observables.csv"
    assert [name.decode() for name in arrays["observable_columns"]] == [name for name, _ in list_columns()]
    assert [unit.decode() for unit in arrays["observable_units"]] == [folder.unit(unit) for unit in UNITS]
    known = [TIME, "lenQ", SPEED, f"{SPEED}^2", "forQ"]
    assert [unit.decode() for unit in arrays["units"]] == [folder.unit(unit) for unit in known]
    assert arrays["rod_names"].tolist() == [b"links[0]", b"links[1]", b"links[2]"]


def check_h5md(folder: Folder, file: pathlib.Path) -> None:
    """Each observable is a group {step, time, value} of H5MD, which has the numbers of observables.csv."""
    if not h5py:
        return
    table = read_table(folder)
    times = table.pop(folder.head("t", TIME))
    with h5py.File(file, "r") as data:
        for group in [*data["observables"].values(), *(data[f"particles/all/{name}"] for name in ("position", "velocity", "force"))]:
            assert sorted(group) == ["step", "time", "value"] and len(group["value"]) == len(group["step"]), group.name
            assert group["time"][:].tolist() == times.tolist(), group.name
        columns = iter(table.values())
        for each, unit in zip(OBSERVED, UNITS):
            name = each if isinstance(each, str) else each.get("name", each["what"])
            value = data["observables"][GROUPS.get(name, name.replace("/", "|"))]["value"]
            assert value.attrs.get("unit", b"").decode() == folder.unit(unit), name
            for column in value[:].reshape(len(times), -1).T:
                assert np.array_equal(column, next(columns)), name
        value = data["observables/each load(hooks)/value"]
        assert value.attrs["members"].tolist() == [b"hooks[0]", b"hooks[1]"] and value.attrs["parts"].tolist() == [b"x", b"y", b"z"] and value.shape[1:] == (2, 3)
        assert data["observables/speed/value"].attrs["observable"] == b"velocity(1).norm"
        assert data["observables/tension/value"].attrs["members"].tolist() == [b"links[0]", b"links[1]", b"links[2]"]
        told = {}
        tell = lambda name, thing: told.update({name: thing.attrs.get("unit", thing.attrs.get("units", b"")).decode()})  # noqa: E731
        data.visititems(tell)  # what has several names by one of them
        tell("particles/all/position/time", data["particles/all/position/time"])
    known = {"particles/all/position/value": "lenQ", "particles/all/position/time": TIME, "particles/all/velocity/value": SPEED,
             "particles/all/force/value": "forQ", "particles/all/constraint_force/value": "forQ", "particles/all/mass": "masQ",
             "observables/tension/value": "forQ", "observables/total_energy/value": "eneQ"}
    for name, unit in known.items():
        assert told[name] == folder.unit(unit), f"{name}: {told[name]}"
    assert folder.letters or not any(told[name] for name in told if name != "observables/angle(0, 1, 2)/value"), told


def check_csv(folder: Folder, file: pathlib.Path) -> None:
    head = next(csv.reader([file.read_text(encoding="utf-8").splitlines()[0]]))
    known = [("t", TIME), *((f"{v}{axis}{k}", SPEED if v else "lenQ") for k in range(4) for v in ("", "v") for axis in "xyz"),
             *((f"tension(links[{k}])", "forQ") for k in range(3))]
    assert head == [folder.head(name, unit) for name, unit in known], head


def check_line(pattern: str, *wanted: str):
    """Returns a check of the first line that has a pattern: all of the letters wanted, or without units none."""
    def check(folder: Folder, file: pathlib.Path) -> None:
        text = file.read_text(encoding="utf-8")
        lines = re.findall(pattern, text)
        assert bool(lines) == bool(folder.letters), f"{file}: {lines}"
        expect_letters(lines[0] if lines else text, list(wanted), folder, file)
    return check


def check_vtp(folder: Folder, file: pathlib.Path) -> None:
    text = file.read_bytes().decode("latin-1")
    found = {name: "".join(chr(int(code)) for code in codes.split()[:-1])
             for name, codes in re.findall(r'<Array type="String" Name="unit of (\w+)"[^>]*>([^<]*)</Array>', text)}
    assert found == {key: folder.letters[key] for key in ("time", "length", "mass", "force") if folder.letters}, f"{file}: {found}"
    assert 'Name="velocity"' in text and 'Name="tension"' in text, file
    names = {name: "".join(chr(int(code)) for code in codes.split()[:-1])
             for name, codes in re.findall(r'<Array type="String" Name="group (\d+)"[^>]*>([^<]*)</Array>', text)}
    assert names == {"0": "links"}, f"{file}: {names}"


def check_words(*wanted: str):
    return lambda folder, file: expect_letters(file.read_text(encoding="utf-8"), list(wanted), folder, file)


def check_error_time(folder: Folder, file: pathlib.Path) -> None:
    rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    assert rows and all(float(row["error"]) >= 0 for row in rows)
    assert {(row["unit_of_length"], row["unit_of_time"]) for row in rows} == {(folder.unit("lenQ"), folder.unit(TIME))}, rows[0]


def check_npy(folder: Folder, file: pathlib.Path) -> None:
    """A summary beside tells what lies along each axis, with its unit."""
    (about,) = [told["arrays"][file.name] for told in map(json.loads, (each.read_text(encoding="utf-8") for each in file.parent.glob("*.json")))
                if file.name in told.get("arrays", {})]
    array = np.load(file)
    assert len(about["axes"]) == array.ndim and (about["axes"][-1] != "x, y, z" or array.shape[-1] == 3), f"{file}: {about}"
    what = re.sub(r"^.*?_(cause\d_)?", "", file.stem)
    known = ({"positions": "lenQ", "velocities": SPEED, "accelerations": f"{SPEED}^2", "shapes": "1/sqrt(masQ)", "lowest_shape": "1/sqrt(masQ)"} |
             dict.fromkeys(("multipliers", "multipliers_unique"), "")).get(what.replace("tangent_", "").replace("normal_", ""), "forQ")
    assert (about["unit"] or "") == folder.unit(known), f"{file}: {about}"


def check_nothing(_folder: Folder, _file: pathlib.Path) -> None:
    """What a run goes on with, lists of other files and pictures that a file beside them names."""


CHECKS = {
    "summary.json": check_json, "forces.json": check_json, "solve.json": check_json, "equilibrium.json": check_json,
    "report.txt": check_words("forQ", "eneQ"), "report.html": check_words("forQ", "lenQ"), "observables.csv": check_observables,
    "trajectory.csv": check_csv, "trajectory.npz": check_npz, "trajectory.h5": check_h5md,
    "trajectory.xyz": check_line('Units="[^"]*"', TIME, "lenQ", SPEED), "equilibrium.xyz": check_line('Units="[^"]*"', TIME, "lenQ", SPEED),
    "trajectory.dump": check_line(r"ITEM: UNITS\ntime [^;]*", TIME, "lenQ", SPEED, "forQ"),
    "trajectory_rods.dump": check_line(r"ITEM: UNITS\ntime [^;]*", "lenQ", "forQ"),
    "*.vtp": check_vtp, "error_time.csv": check_error_time, "error_time.md": check_words("lenQ", TIME),
    "error_time.svg": check_words("lenQ"), "error_time.png": check_nothing, "*.pvd": check_nothing, "*.npy": check_npy,
    "checkpoint": check_nothing, "recording": check_nothing}


def check_folder(folder: Folder) -> set:
    files = [path for path in folder.path.rglob("*") if path.is_file()]
    for file in files:
        check = next((each for pattern, each in CHECKS.items() if file.match(pattern)), None)
        assert check, f"{file} is a result whose names and units nobody checks"
        check(folder, file)
    return {file.name for file in files}


def without_units(observed: list) -> list:
    return [each if isinstance(each, str) else {key: each[key] for key in each if key != "unit"} for each in observed]


def main() -> int:
    tanor, place = sys.argv[1], pathlib.Path(sys.argv[2])
    if os.environ.get("CI") and not h5py:
        print("not installed: h5py", file=sys.stderr)
        return 1
    shutil.rmtree(place, ignore_errors=True)
    seen, rest, speeds = set(), SCENE["points"]["positions"], SCENE["points"]["velocities"]
    for name, letters, more in (("own", LETTERS, 0), ("none", {}, 0), ("many", LETTERS, 10_000)):
        work = place / name
        work.mkdir(parents=True)
        for stem, scene in (("moving", SCENE), ("hanging", HANGING)):
            named = scene | ({"units": letters} if letters else {"observe": without_units(OBSERVED)})
            if more:  # points that stand beside, with which arrays are written to files
                named["points"] = dict(named["points"], positions=[*rest, *[[9, 9, 9]] * more], velocities=[*speeds, *[[0, 0, 0]] * more])
                named["supports"] = [*named["supports"], {"points": list(range(len(rest), len(rest) + more))}]
                named["motion"] = named["motion"] | {"output_points": [0, 1, 2, 3]}
            (work / f"{stem}.json").write_text(json.dumps(named), encoding="utf-8")
        rows = [[t, *(number for point in rest for number in point), *[9] * 3 * more] for t in (0, 1, 2, 3, 4, 5)]
        (work / "still.csv").write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n", encoding="utf-8")

        def run(command: str, *words: str, work=work, letters=letters) -> None:
            out = work / command
            done = subprocess.run([tanor, command, *words, "--quiet"], cwd=work, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{command}: {done.stderr}"
            seen.update(check_folder(Folder(out, command, letters)))

        run("run", "moving.json", "--out", "run", "--report")
        run("equilibrium", "hanging.json", "--out", "equilibrium", "--modes", "1")
        run("modes", "equilibrium/equilibrium.json", "--out", "modes", "--pictures")
        run("forces", "moving.json", "--motion", "still.csv", "--out", "forces")
        run("error-time", "moving.json", "--methods", "rk4", "--t-end", "0.1", "--out", "error-time")
        (work / "solve").mkdir()
        run("solve", "moving.json", "--out", "solve/solve.json")
    missing = {pattern for pattern in CHECKS if not any(pathlib.Path(name).match(pattern) for name in seen)}
    allowed = {"error_time.png", "report.html", "recording"}  # without rsvg-convert, without zlib
    assert missing <= allowed, f"nobody writes {missing - allowed}"
    page = (pathlib.Path(__file__).parents[2] / "docs/scene-format.md").read_text(encoding="utf-8")
    unnamed = {name for name in CHECKS if "*" not in name and f"`{name}`" not in page}
    assert unnamed == {"solve.json"}, f"the page of formats does not name {unnamed}"
    print(f"{len(seen)} names of files")
    return 0


if __name__ == "__main__":
    sys.exit(main())
