#!/usr/bin/python3
"""tanor-mpi on 1, 2 and 4 ranks against tanor: the same summary; runs that go on on other numbers of ranks; failures.

    check_program.py TANOR_MPI TANOR MPIRUN FOLDER
"""

import array
import fcntl
import json
import pathlib
import shutil
import subprocess
import sys
import time

from program_scenes import (beads, beam, charges, clusters, mechanisms, melt, net, pendulums, polymer, rough_beads,
                            stiff_chains)

PROGRAM, TANOR, MPIRUN, FOLDER = sys.argv[1:5]
folder = pathlib.Path(FOLDER)
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


def run(ranks, arguments, cwd=None):
    return subprocess.run([MPIRUN, "-n", str(ranks), PROGRAM, "run", *map(str, arguments)], capture_output=True,
                          text=True, timeout=240, check=False, cwd=cwd)


def summary_of(out):
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


def difference(a, b):
    """Of nested lists of numbers, over the largest number; of null, where there is nothing to tell, it is 0."""
    flat = lambda x: [y for each in x for y in flat(each)] if isinstance(x, list) else [x]
    pairs = [(x, y) for x, y in zip(flat(a), flat(b), strict=True) if (x, y) != (None, None)]
    largest = lambda numbers: max(numbers, default=0.0)
    return largest(abs(x - y) for x, y in pairs) / max(1e-300, largest(abs(y) for _, y in pairs))


def write_scene(name, scene):
    path = folder / f"{name}.json"
    path.write_text(json.dumps({"tanor_scene": 1} | scene), encoding="utf-8")
    return path


def check_certificate(name, certificate):
    """That of one rank alone, and what all of them found held against it."""
    checks = {check["identity"]: check for check in certificate["checks"]}
    expect(len(checks) >= 5, f"{name}: checks {list(checks)}")
    beside = checks.get("w of all ranks = w of one")
    expect(beside is not None and beside["error"] <= min(beside["allowed"], 1e-11), f"{name}: {beside}")
    expect(all(check["error"] <= check["allowed"] for check in checks.values()), f"{name}: {certificate}")


def compare(name, scene, allowed):
    """Runs on one rank by tanor, on 1, 2 and 4 by tanor-mpi."""
    path = write_scene(name, scene)
    serial = folder / f"{name}.serial"
    done = subprocess.run([TANOR, "run", path, "--out", serial, "--quiet"], capture_output=True, text=True, check=False)
    expect(done.returncode == 0, f"{name}: tanor: {done.stderr}")
    wanted = summary_of(serial)
    for ranks in (1, 2, 4):
        out = folder / f"{name}.{ranks}"
        done = run(ranks, [path, "--out", out, "--quiet"])
        expect(done.returncode == 0, f"{name} on {ranks} ranks: {done.returncode} {done.stderr}")
        if done.returncode != 0:
            continue
        found = summary_of(out)
        expect(set(found) ^ set(wanted) <= {"arrays"}, f"{name}: keys differ: {set(found) ^ set(wanted)}")  # files that ranks write in any case
        for key in ("points", "supports", "equations", "islands", "steps", "rejected", "contact_changes", "method", "form", "rank",
                    "degrees_of_freedom", "t_reached", "units", "groups"):
            expect(found[key] == wanted[key], f"{name} on {ranks} ranks: {key} {found[key]}, not {wanted[key]}")
        for key in ("positions", "velocities", "multipliers", "reactions", "support_forces"):
            error = difference(found["final"][key], wanted["final"][key])
            expect(error <= allowed, f"{name} on {ranks} ranks: {key} differ by {error}")
        check_certificate(f"{name} on {ranks} ranks", found["certificate"])
        scale = max(1.0, abs(wanted["energy"]["end"]))
        for key in ["end"] + [key for key in wanted["energy"] if key.startswith("work")]:
            error = abs((found["energy"][key] or 0.0) - (wanted["energy"][key] or 0.0))
            expect(error <= allowed * scale, f"{name} on {ranks} ranks: energy {key} differs by {error}")
    return path, wanted


def check_resume(path, wanted):
    """Half of the motion on 2 ranks, the rest on 1 and on 4."""
    for ranks in (1, 4):
        out = folder / f"resumed.{ranks}"
        first = run(2, [path, "--out", out, "--quiet", "--t-end", "0.02"])
        expect(first.returncode == 0, f"first half: {first.stderr}")
        second = run(ranks, [path, "--out", out, "--quiet", "--resume"])
        expect(second.returncode == 0, f"second half on {ranks} ranks: {second.stderr}")
        found = summary_of(out)
        expect(found["steps"] == wanted["steps"], f"resumed on {ranks}: {found['steps']} steps, not {wanted['steps']}")
        error = difference(found["final"]["positions"], wanted["final"]["positions"])
        expect(error <= 1e-9, f"resumed on {ranks} ranks: positions differ by {error}")
        head = (out / "trajectory.npy").read_bytes()[:128]
        expect(f"({3}, {wanted['points']}, 3)".encode() in head, f"resumed on {ranks} ranks: frames {head}")


def check_failures():
    """One message, whatever the number of ranks; its exit code."""
    flat = net(6)
    flat["supports"] = [{"points": [0, 5]}]  # a straight row of rods between two supports
    flat["motion"]["start"] = "project"
    path = write_scene("flat", flat)
    for ranks in (2, 3, 4):  # what elimination leaves in the shared rows is rounding, wherever the cuts lie
        done = run(ranks, [path, "--out", folder / f"flat.{ranks}", "--quiet"])
        expect(done.returncode == 3, f"dependent rods on {ranks} ranks: {done.returncode}")
        lines = [line for line in done.stderr.splitlines() if "stopped at" in line]
        expect(len(lines) == 1 and "t = 0 s" in lines[0] and "depends on" in lines[0], f"dependent rods: {lines}")
    wrong = net(6)
    wrong["motion"]["step"] = -1.0
    done = run(2, [write_scene("wrong", wrong), "--out", folder / "wrong.2"])
    expect(done.returncode == 2, f"bad input: {done.returncode}")
    lines = [line for line in done.stderr.splitlines() if line.startswith("tanor: ")]
    expect(len(lines) == 1 and "/motion/step" in lines[0], f"bad input: {lines}")


def complaint(done):
    """The one line that a run ended with."""
    lines = [line for line in done.stderr.splitlines() if line.startswith("tanor: ")]
    return lines[0] if len(lines) == 1 else f"not one line: {done.stderr}"


def check_options(path):
    """What tanor-mpi does not do is refused; nothing is written."""
    out = folder / "refused"
    for words in (["--report"], ["--checkpoint-every", "5"], ["--trajectory", "npz"]):
        done = run(2, [path, "--out", out, *words])
        expect(done.returncode == 2 and words[0] in complaint(done), f"{words}: {done.returncode} {complaint(done)}")
        expect(not out.exists(), f"{words}: wrote something")
    done = run(2, [write_scene("watched", net() | {"events": [{"when": "t > 0.01", "do": "stop"}]}), "--out", out])
    expect(done.returncode == 2 and "watched.json: /events" in complaint(done), f"events: {complaint(done)}")
    expect(not out.exists(), "events: wrote something")
    for observed in ("energy()", {"name": "pull", "what": "max tension(rods)", "every_step": True}):  # one is a default
        done = run(2, [write_scene("observed", net() | {"observe": [observed]}), "--out", out])
        expect(done.returncode == 2 and "observed.json: /observe" in complaint(done), f"{observed}: {complaint(done)}")
    done = run(2, [path, "--out", folder / "as_json", "--quiet", "--json"])
    expect(done.returncode == 0 and json.loads(done.stdout) == summary_of(folder / "as_json"), f"--json: {done.stdout}")
    done = run(2, ["--help"])
    expect(done.returncode == 0 and "melt-{rank}.json" in done.stdout, f"--help: {done.stdout}")
    done = subprocess.run([MPIRUN, "-n", "2", PROGRAM, "check", path], capture_output=True, text=True, check=False)
    expect(done.returncode == 2 and "knows `run` alone" in complaint(done), f"check: {complaint(done)}")


def check_folder(path):
    """A checkpoint of another scene and a damaged one are refused by name; a new run has a clean folder of its own."""
    out, edited = folder / "shared", net()
    edited["forces"][0]["acceleration"] = [0, 0, -9.82]  # a number that no list of points and rods tells of
    expect(run(2, [path, "--out", out, "--quiet", "--t-end", "0.02"]).returncode == 0, "a run to go on with")
    kept = path.read_bytes()
    write_scene("net", edited)
    done = run(2, [path, "--out", out, "--resume"])
    expect(done.returncode == 2 and "net.json was changed" in complaint(done), f"edited: {complaint(done)}")
    path.write_bytes(kept)
    checkpoint = out / "checkpoint.mpi"
    damaged = bytearray(checkpoint.read_bytes())
    damaged[-20] ^= 1
    checkpoint.write_bytes(damaged)
    done = run(2, [path, "--out", out, "--resume"])
    expect(done.returncode == 2 and f"{checkpoint}: is damaged" in complaint(done), f"damaged: {complaint(done)}")
    with open(out / ".tanor.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = run(2, [path, "--out", out])
        expect(done.returncode == 4 and "is in use by" in complaint(done), f"two runs: {complaint(done)}")
    # The frames of a smaller scene are all that is there, not the end of a longer file.
    small = net(6)
    small["motion"]["t_end"] = 0.02
    done = run(2, [write_scene("small", small), "--out", out, "--quiet"])
    size = (out / "trajectory.npy").stat().st_size
    expect(done.returncode == 0 and size == 128 + 2 * 36 * 24, f"over the rests of another: {done.returncode}, {size}")
    (out / "trajectory.npy").write_bytes(b"x" * 100_000)
    expect(run(2, [path, "--out", out, "--quiet"]).returncode == 0, "a run over rests of no use")
    expect((out / "trajectory.npy").stat().st_size == 128 + 3 * 64 * 24, "three frames and nothing else")
    told = json.loads((out / "summary.json").read_text(encoding="utf-8"))["arrays"]
    expect(told == {"trajectory.npy": {"axes": ["frame", "point", "x, y, z"], "unit": "m"},
                    "trajectory_times.npy": {"axes": ["frame"], "unit": "s"}}, "summary.json names arrays")


def check_interrupted(path):
    """A run that was cut off is gone on with or begun anew, and neither without a word; another scene may replace it."""
    out = folder / "cut_off"
    endless = net() | {"forces": []}  # it stays where it is; a net that falls comes to a passage that ends its motion
    endless["motion"] |= {"t_end": 1e3, "output_every": 0.01}
    long_path = write_scene("endless", endless)
    with subprocess.Popen([MPIRUN, "-n", "2", PROGRAM, "run", long_path, "--out", out, "--quiet"],
                          stderr=subprocess.DEVNULL) as cut:
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and not (out / "checkpoint.mpi").exists():
            time.sleep(0.05)
        cut.terminate()
    kept = (out / "checkpoint.mpi").read_bytes()
    done = run(2, [long_path, "--out", out])
    expect(done.returncode == 2 and "--overwrite begins anew" in complaint(done), f"cut off: {complaint(done)}")
    expect((out / "checkpoint.mpi").read_bytes() == kept, "a refused run touched the checkpoint")
    expect(run(2, [path, "--out", out, "--quiet"]).returncode == 0, "another scene in the folder of a run cut off")
    expect(run(2, [path, "--out", out, "--quiet"]).returncode == 0, "a run that reached its end is begun anew")
    (out / "summary.json").unlink()
    expect(run(2, [path, "--out", out, "--quiet"]).returncode == 2, "cut off behind its last frame")
    expect(run(2, [path, "--out", out, "--quiet", "--overwrite"]).returncode == 0, "--overwrite")
    expect("net" in summary_of(out)["scene"], "a summary once more")


def run_differently(words, first, second):
    """Two ranks, of which the second is started by `words` in front of the program."""
    command = [MPIRUN, "-n", "1", PROGRAM, "run", *first, ":", "-n", "1", *words, PROGRAM, "run", *second]
    command = [str(word) for word in command]
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 124, "", "took more than two minutes")


def with_memory(kilobytes):
    return ["sh", "-c", f'ulimit -v {kilobytes}; exec "$@"', "sh"]


def check_failure_of_one_rank():
    """One rank does not see the scene's file, or runs out of memory: one message, and the other one ends as well."""
    small = write_scene("alone", net(4))
    options = ["--out", folder / "alone", "--quiet", "--overwrite"]
    done = run_differently([], [small, *options], [folder / "nowhere.json", *options])
    expect(done.returncode == 2, f"a scene that one rank does not see: {done.returncode}")
    expect(complaint(done).startswith("tanor: rank 1: ") and "nowhere.json" in complaint(done), complaint(done))

    # The small scene tells what a rank needs beside its scene, a scene of many points is more than is left.
    memory = 50_000
    while run_differently(with_memory(memory), [small, *options], [small, *options]).returncode != 0:
        memory = memory * 6 // 5
        if memory > 50_000_000:
            failures.append("no memory is enough for a small scene")
            return
    many = [[0.1 * i, 0.0, 0.0] for i in range(400_000)]
    large = write_scene("large", net(4) | {"points": {"positions": many, "masses": 0.1}})
    done = run_differently(with_memory(memory), [large, *options], [large, *options])
    expect(done.returncode == 4, f"a rank without memory: {done.returncode}")
    expect(complaint(done) == "tanor: rank 1: out of memory", complaint(done))


def check_resume_of_one_rank():
    """One rank does not see the checkpoint, or sees a damaged one: none of them waits for the others."""
    path, seen, other = write_scene("half", net(6)), folder / "half.seen", folder / "half.other"
    begun = run(2, [path, "--out", seen, "--quiet", "--t-end", "0.02"])
    expect(begun.returncode == 0, f"a run of which one rank sees no checkpoint: {begun.stderr}")
    for damage, code, words in ((None, 4, "cannot read"), (b"torn", 2, "ends too early")):
        if damage is not None:
            other.mkdir(exist_ok=True)
            (other / "checkpoint.mpi").write_bytes(damage)
        options = [[path, "--out", out, "--quiet", "--resume"] for out in (seen, other)]
        done = run_differently([], *options)
        expect(done.returncode == code, f"a checkpoint that {words}: {done.returncode} {done.stderr}")
        expect(complaint(done).startswith("tanor: rank 1: ") and words in complaint(done), complaint(done))
        expect("MPI_ABORT" not in done.stderr, f"a checkpoint that {words}: a rank waited, {done.stderr}")


def check_too_few_islands():
    """Whole islands that are fewer than ranks are refused, not cut."""
    for scene in (stiff_chains("radau5", (20, 5, 5)), stiff_chains("auto", (20, 5, 5))):
        done = run(4, [write_scene("few", scene), "--out", folder / "few"])
        expect(done.returncode == 2 and "would own no point; take fewer ranks" in complaint(done),
               f"few islands: {done.returncode} {complaint(done)}")


def write_parts(name, make, sizes):
    """A scene for each rank, "{name}-{rank}.json", and one of all together. Half of the motion is a frame."""
    start = 0
    for rank, size in enumerate(sizes):
        write_scene(f"{name}-{rank}", with_two_frames(make(size, start)) | {"name": f"part {rank}"})
        start += size
    return folder / (name + "-{rank}.json"), write_scene(f"{name}-whole", with_two_frames(make(start)))


def with_two_frames(scene):
    return scene | {"motion": scene["motion"] | {"output_every": scene["motion"]["t_end"] / 2}}


def check_end_of_parts(name, out, wanted):
    """What is counted, summed and agreed is that of the whole; points stand in the files alone."""
    found = summary_of(out)
    expect(set(found) ^ set(wanted) <= {"arrays"}, f"{name}: keys differ: {set(found) ^ set(wanted)}")  # files that ranks write in any case
    for key in ("points", "supports", "equations", "islands", "steps", "rejected", "contact_changes", "method", "rank",
                "degrees_of_freedom", "t_end", "t_reached", "source", "units"):
        expect(found[key] == wanted[key], f"{name}: {key} {found[key]}, not {wanted[key]}")
    expect(found["friction"]["contacts"] == wanted["friction"]["contacts"], f"{name}: {found['friction']}")
    expect(found["scene"] == name.split()[0], f"{name}: is called {found['scene']}")
    expect(found["certificate"]["verdict"] is None and found["certificates"] == 0, f"{name}: {found['certificate']}")
    known = [key for key, value in found["final"].items() if value is not None]
    expect(known == ["t"], f"{name}: knows {known} of the whole")
    frames = array.array("d", (out / "trajectory.npy").read_bytes()[128:])
    size = 3 * wanted["points"]
    expect(len(frames) == 3 * size, f"{name}: {len(frames) / size} frames")
    error = difference(frames[-size:].tolist(), sum(wanted["final"]["positions"], []))
    expect(error <= 1e-9, f"{name}: positions differ by {error}")
    for key in ("start", "end", "work_of_forces", "work_of_friction"):
        error = abs((found["energy"][key] or 0.0) - (wanted["energy"][key] or 0.0))
        expect(error <= 1e-9 * max(1.0, abs(wanted["energy"]["end"])), f"{name}: energy {key} differs by {error}")
    expect(found["violation"]["position_max"] < 1e-12, f"{name}: {found['violation']}")


def check_friction_of_one_part():
    """The first rank has no friction, so all that is said of it comes from the second one."""
    ice, rough = beads(5), beads(7, 5)
    ice["friction"] = []
    ice["constraints"][0]["name"] = "ice"
    floors = [plane | {"points": points} for plane, points in
              ((ice["constraints"][0], list(range(5))), (rough["constraints"][0], list(range(5, 12))))]
    write_scene("slope-0", ice)
    write_scene("slope-1", rough)
    whole = write_scene("slope", beads(12) | {"constraints": floors})
    serial, out = folder / "slope.serial", folder / "slope.out"
    done = subprocess.run([TANOR, "run", whole, "--out", serial, "--quiet"], capture_output=True, text=True, check=False)
    expect(done.returncode == 0, f"slope: tanor: {done.stderr}")
    done = run(2, [folder / "slope-{rank}.json", "--out", out, "--quiet"])
    expect(done.returncode == 0, f"slope: {done.stderr}")
    wanted, found = summary_of(serial)["friction"], summary_of(out)["friction"]
    for key in ("contacts", "solves", "iterations_mean", "iterations_max", "uniqueness", "uniqueness_reason", "several",
                "method_used"):
        expect(found[key] == wanted[key], f"slope: friction {key} {found[key]}, not {wanted[key]}")


def check_parts():
    """Each rank reads a scene of its own, and none the whole."""
    for name, make, sizes in (("clusters", clusters, (13, 17)), ("pendulums", pendulums, (2, 4)), ("beads", beads, (5, 7)),
                              ("mechanisms", mechanisms, (1, 3))):
        parts, whole = write_parts(name, make, sizes)
        serial = folder / f"{name}-whole.serial"
        done = subprocess.run([TANOR, "run", whole, "--out", serial, "--quiet"], capture_output=True, text=True, check=False)
        expect(done.returncode == 0, f"{name}: tanor: {done.stderr}")
        wanted = summary_of(serial)
        out = folder / f"{name}.out"
        done = run(2, [parts, "--quiet"], cwd=folder)  # the folder's name comes from that of the scenes
        expect(done.returncode == 0 and "no certificate" in complaint(done), f"parts: {done.returncode} {done.stderr}")
        check_end_of_parts(f"{name} in parts", out, wanted)
        if wanted["method"] == "radau5":
            continue  # goes on to its tolerance, with other steps, since stages are not saved
        half = ["--t-end", wanted["t_end"] / 2]
        expect(run(2, [parts, "--out", out, "--quiet", *half]).returncode == 0, f"{name}: half")
        expect(run(2, [parts, "--out", out, "--quiet", "--resume"]).returncode == 0, f"{name}: resumed")
        check_end_of_parts(f"{name} in parts, resumed", out, wanted)


def check_refused_parts():
    """Parts that do not fit together, and checkpoints of others, are refused with one line by all ranks."""
    parts, _ = write_parts("chains", clusters, (3, 4))
    out = folder / "chains"

    def refuse(ranks, words, *options):
        done = run(ranks, [parts, "--out", out, "--quiet", *options])
        expect(done.returncode == 2 and words in complaint(done), f"not '{words}': {done.returncode} {complaint(done)}")
        expect("MPI_ABORT" not in done.stderr, f"'{words}': some rank waited for another, {done.stderr}")

    refuse(4, "rank 2: ")  # the first one of two without a file
    refuse(4, "chains-2.json cannot be read")
    second = with_two_frames(clusters(4, 3))
    for key, value, is_wrong in (("t_end", 0.4, "is 0.4 on rank 1, but 0.2 on rank 0"),
                                 ("method", "rk4", "is rk4 on rank 1, but auto on rank 0"),
                                 ("start", "project", "is project on rank 1, but check on rank 0")):
        motion = second["motion"] | {key: value} | ({"step": 1e-3} if key == "method" else {})
        if key == "method":
            del motion["rtol"]
        write_scene("chains-1", second | {"motion": motion})
        refuse(2, f"chains-1.json: /motion/{key}: {is_wrong}")
    expect(not out.exists(), "refused parts wrote something")

    # Forces are each scene's own, and an edited scene is another run.
    first = with_two_frames(clusters(3))
    write_scene("chains-0", first | {"forces": first["forces"][:1]})
    second["forces"] = second["forces"][1:]
    write_scene("chains-1", second)
    expect(run(2, [parts, "--out", out, "--quiet", "--t-end", "0.1"]).returncode == 0, "gravity here, springs there")
    left_out = summary_of(out)["left_out"]
    expect("coordinates: none are given" in left_out and "spring forces: none" not in left_out, f"springs: {left_out}")
    refuse(1, "is of a run of 2 scenes, not of 1; run without --resume", "--resume")
    second["forces"][0]["stiffness"] = 6.0
    write_scene("chains-1", second)
    refuse(2, "is of an earlier version of the scene: chains-1.json was changed", "--resume")


def main():
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    path, wanted = compare("net", net(), 1e-9)
    check_resume(path, wanted)
    compare("clusters", clusters(), 1e-9)
    compare("beads", beads(), 1e-9)
    compare("polymer", polymer("dop853"), 1e-8)
    compare("polymer_in_series", polymer("auto"), 1e-9)
    compare("melt", melt(), 1e-9)
    compare("beam", beam(), 1e-9)
    compare("pendulums", pendulums(), 1e-7)
    compare("stiff_chains", stiff_chains("radau5"), 1e-7)
    compare("stiff_chains_by_auto", stiff_chains("auto"), 1e-7)
    compare("rough_beads", rough_beads(), 1e-9)
    compare("mechanisms", mechanisms(), 1e-9)
    compare("mechanisms_of_rods", mechanisms(has_constraints=True), 1e-9)
    compare("charges", charges(), 1e-9)
    check_too_few_islands()
    check_failures()
    check_failure_of_one_rank()
    check_resume_of_one_rank()
    check_options(path)
    check_folder(path)
    check_interrupted(path)
    check_parts()
    check_friction_of_one_part()
    check_refused_parts()
    print("\n".join(failures) if failures else "tanor-mpi: every answer is that of tanor")
    return 1 if failures else 0


sys.exit(main())
