#!/usr/bin/python3
"""check_page.py PROGRAM FOLDER NODE: runs scenes with --report and tries each page in headless Chromium (page.mjs).

Texts that would break out of the page are tried too, and a page that follows its run (follow.mjs), where this tanor has a
server. 77, a skip, where Chromium is missing; under CI what is missing is a failure.
"""

import concurrent.futures
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOSTILE_BEGIN = 4  # s, of its page
HOSTILE = "</script><script>throw new Error('broke out')</script><!--<script>"


def hostile_scene(folder: pathlib.Path) -> pathlib.Path:
    """The pendulum under names that are HTML."""
    scene = json.loads((ROOT / "examples/pendulum.json").read_text())
    scene["name"] = HOSTILE
    path = folder / "hostile.json"
    path.write_text(json.dumps(scene))
    return path


def saddle_scene(folder: pathlib.Path) -> pathlib.Path:
    """Beads on a saddle that breathes, from t = 100 s to 101 s."""
    scene = {"tanor_scene": 1, "units": "si", "name": "saddle",
             "points": {"positions": [[5.8, 0.1, 0], [5.2, 0.9, 0], [4.3, -0.2, 0]]},
             "constraints": [{"name": "saddle", "kind": "formula", "points": [[0], [1], [2]],
                              "equation": "z1-0.4*(1+0.5*sin(t))*((x1-5)^2-y1^2)"}],
             "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
             "motion": {"start": "project", "t_start": 100, "t_end": 101, "output_every": 0.05}}
    path = folder / "saddle.json"
    path.write_text(json.dumps(scene))
    return path


def endless_scene(folder: pathlib.Path) -> pathlib.Path:
    """The pendulum in small steps, for hours."""
    scene = json.loads((ROOT / "examples/pendulum.json").read_text())
    scene["motion"] = {"method": "rk4", "step": 1e-4, "t_end": 1e5, "output_every": 0.1}
    path = folder / "endless.json"
    path.write_text(json.dumps(scene))
    return path


def guides_scene(folder: pathlib.Path) -> pathlib.Path:
    """Beads on those kinds of guides that have a picture and stand in no other scene of this test."""
    guides = [{"name": "wire", "kind": "line", "points": [0], "origin": [0, 0, 1], "direction": [1, 0.5, -0.3]},
              {"name": "ring", "kind": "circle", "points": [1], "center": [2, 0, 0], "normal": [0.2, 0.3, 1], "radius": 0.7},
              {"name": "egg", "kind": "ellipsoid", "points": [2, 4, 5], "center": [0, 2, 0], "radii": [0.9, 0.6, 0.4],
               "axes": [[1, 1, 0], [0, 1, 1]]},
              {"name": "spiral", "kind": "helix", "points": [3], "origin": [2, 2, 0], "axis": [0.3, -0.2, 1], "radius": 0.5,
               "pitch": -0.4}]
    scene = {"tanor_scene": 1, "units": "si", "name": "guides",
             "points": {"positions": [[0.1, 0, 1], [2.7, 0, 0], [0.6, 2.6, 0.1], [2.5, 2, 0.1], [-0.6, 1.4, 0.1], [0.2, 2, 0.4]]},
             "constraints": guides,
             "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
             "motion": {"start": "project", "t_end": 0.1, "output_every": 0.01}}
    path = folder / "guides.json"
    path.write_text(json.dumps(scene))
    return path


def table_scene(folder: pathlib.Path) -> pathlib.Path:
    """A bead that sticks and slips on a table that tilts: more switches than a page lists."""
    scene = {"tanor_scene": 1, "units": "si", "name": "table", "points": {"positions": [[0, 0, 0]], "masses": 0.1},
             "constraints": [{"name": "table", "kind": "plane", "points": [0], "normal": {"formula": ["0.4*sin(60*t)", "0", "1"]}}],
             "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
             "friction": [{"kind": "coulomb", "at": ["table"], "coefficient": 0.2, "static_coefficient": 0.25}],
             "motion": {"method": "dopri5", "t_end": 20, "output_every": 1}}
    path = folder / "table.json"
    path.write_text(json.dumps(scene))
    return path


# The length of a rod, m, beside one of 1 m.
STOPPED = {"stops_at_once": "1 + 0.1*t^2", "stops_halfway": "1 + 0.1*max(0, t - 0.5)^2"}

def crane_scene(folder: pathlib.Path) -> pathlib.Path:
    """Two masses on a rope over two sheaves, a crank that moves, a rope that is a formula, and a spring."""
    scene = {"tanor_scene": 1, "units": "si", "name": "crane",
             "points": {"positions": [[0, 0, 0], [0, 0, -1], [3.4, 0, 0], [3.1, 0, -0.9], [2.2, 0, -0.4], [-1, 0, 0.5], [1.8, 0, -0.5],
                                      [-2, 0, 2], [-2.3, 0, 1.2], [0.9, 0, 2]],
                        "masses": [1, 1, 1, 1, 1, 1, 1.2, 1, 1, 1]},
             "supports": [{"name": "hook", "points": [0]}, {"points": [7, 9]},
                          {"name": "crank", "points": [2], "motion": {"formula": ["0.4*cos(3*t)-0.4", "0", "0.4*sin(3*t)"]}}],
             "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [2, 3], [3, 4], [4, 0]]},
                             {"name": "winch", "kind": "pulley", "pairs": [[5, 6]], "a": [-1, 0, 2], "b": [1.5, 0, 2]},
                             {"name": "cord", "kind": "formula", "points": [[7, 8, 9]],
                              "equation": "sqrt((x2-x1)^2+(z2-z1)^2)+sqrt((x3-x2)^2+(z3-z2)^2)-4.2"}],
             "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}, {"name": "coil", "kind": "spring", "pairs": [[4, 8]], "stiffness": 1}],
             "observe": [{"name": "torque", "what": "moment(crank, y, [3, 0, 0])"}, "max tension(links)", "load(hook)", "tension(links)", "tension(winch)"],
             "motion": {"start": "project", "t_end": 1, "output_every": 0.02}}
    path = folder / "crane.json"
    path.write_text(json.dumps(scene))
    return path


def ropes_scene(folder: pathlib.Path) -> pathlib.Path:
    """Seventy ropes over the same two sheaves."""
    positions = [place for k in range(70) for place in ([-1, 0.05 * k, -1], [1, 0.05 * k, -1.5])]
    scene = {"tanor_scene": 1, "units": "si", "name": "ropes",
             "points": {"positions": positions, "masses": [1 + 0.01 * k for k in range(len(positions))]},
             "constraints": [{"name": "ropes", "kind": "pulley", "pairs": [[k, k + 1] for k in range(0, len(positions), 2)],
                              "a": [-1, 2, 1], "b": [1, 2, 1]}],
             "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
             "motion": {"t_end": 0.2, "output_every": 0.02}}
    path = folder / "ropes.json"
    path.write_text(json.dumps(scene))
    return path


def box_scene(folder: pathlib.Path) -> pathlib.Path:
    """Dumbbells in a periodic cell, two of which reach out of it."""
    places = [[0.2 + x, 0.3 + y, 0.5] for x in (0, 1, 2, 3.5) for y in (0, 1, 2)]
    positions = [place for x, y, z in places for place in ([x, y, z], [x + 0.6, y, z])]
    scene = {"tanor_scene": 1, "units": "si", "name": "box", "points": {"positions": positions, "velocities": [[1, 0.2, 0]] * len(positions)},
             "constraints": [{"name": "dumbbells", "kind": "rod", "pairs": [[k, k + 1] for k in range(0, len(positions), 2)]}],
             "forces": [{"kind": "pair", "law": "lj", "box": [3, 3, 3], "cutoff": 1, "epsilon": 1e-6, "sigma": 0.3}],
             "motion": {"t_end": 0.2, "output_every": 0.05}}
    path = folder / "box.json"
    path.write_text(json.dumps(scene))
    return path


def hanging_scene(folder: pathlib.Path, name: str) -> pathlib.Path:
    """Two beads of 1 kg below a support, at rest."""
    path = folder / f"{name}.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "name": name, "points": {"positions": [[0, 0, 0], [0, 0, -1], [0, 0, -2]]}, "supports": [{"points": [0]}],
        "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [1, 2]]}],
        "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1}}))
    return path


def stressed_scene(folder: pathlib.Path) -> pathlib.Path:
    """A bead between two supports, whose loads nothing decides."""
    path = folder / "stressed.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "points": {"positions": [[0, 0, 0], [1, 0, 0], [2, 0, 0]]}, "supports": [{"points": [0, 2]}],
        "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [1, 2]]}],
        "equilibrium": {"accept": "any"}}))
    return path


STATICS = {"equilibrium": "equilibrium", "modes": "modes", "stressed": "equilibrium"}

# What each page must offer to switch off.
EXAMPLES = {"pendulum": "points,rods,normal", "four_bar_motor": "points,rods,normal", "net": "points,rods,normal", "rough_hoop": "points,guides,normal,tangent",
            "melt_generated": "points,rods"}


def contradictory_scene(folder: pathlib.Path, name: str, length: str) -> pathlib.Path:
    """Two rods between the same points, one of which grows."""
    path = folder / f"{name}.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "name": name, "points": {"positions": [[0, 0, 0], [1, 0, 0]], "masses": 1}, "supports": [{"points": [0]}],
        "constraints": [{"name": "a", "kind": "rod", "pairs": [[0, 1]], "length": 1},
                        {"name": "b", "kind": "rod", "pairs": [[0, 1]], "length": {"formula": length}}],
        "motion": {"t_end": 1, "output_every": 0.1}}))
    return path


def resting_scene(folder: pathlib.Path) -> pathlib.Path:
    """A bead that hangs at rest."""
    path = folder / "resting.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "points": {"positions": [[0, 0, 0], [0, 0, -1]]}, "supports": [{"points": [0]}],
        "constraints": [{"name": "a", "kind": "rod", "pairs": [[0, 1]]}],
        "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1, "output_every": 0.1}}))
    return path


def torn_scene(folder: pathlib.Path) -> pathlib.Path:
    """A crank that turns about (-0.5, 0, 0) and is let go, above two rods, the lower one of which breaks before. A table, a bowl
    and a ring let go, a rope, a spring and a bond break."""
    path = folder / "torn.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "units": "real", "points": {"positions": [[0, 0, 0], [0, 0, -1], [0, 0, -2], [1, 0, 0], [2, 0, -1], [3, 0, -1],
                                                                 [4, 0, -1], [5, 0, -1], [6, 0, -1], [7, 0, 0], [8.5, 0, 0]]},
        "supports": [{"name": "crank", "points": [0], "motion": {"formula": ["0.5*cos(t)-0.5", "0", "0.5*sin(t)"]}}],
        "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [1, 2]]},
                        {"name": "table", "kind": "plane", "points": [3], "normal": [0, 0, 1]},
                        {"name": "bowl", "kind": "formula", "points": [[9]], "equation": "z1-0.2*((x1-7)^2+y1^2)"},
                        {"name": "ball", "kind": "sphere", "points": [10], "center": [8, 0, 0]},
                        {"name": "floor", "kind": "plane", "points": [10], "normal": [0, 0, 1]},
                        {"name": "winch", "kind": "pulley", "pairs": [[4, 5]], "a": [2, 0, 0.5], "b": [3, 0, 0.5]}],
        "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
                   {"name": "coil", "kind": "spring", "pairs": [[6, 7]], "stiffness": 5},
                   {"name": "glue", "kind": "bond", "pairs": [[7, 8]], "law": "harmonic", "stiffness": 5, "rest_length": 1}],
        "events": [{"when": "t > 0.3", "do": "break", "of": "winch"}, {"when": "t > 0.35", "do": "break", "of": "coil"},
                   {"when": "t > 0.4", "do": "break", "of": "glue"}, {"when": "t > 0.45", "do": "release", "of": "bowl"},
                   {"when": "t > 0.5", "do": "release", "of": "floor"},
                   {"when": "t > 0.5237", "do": "break", "of": "links[1]"}, {"when": "t > 0.81", "do": "release", "of": "table"},
                   {"when": "t > 1.13", "do": "release", "of": "crank"}],
        "motion": {"start": "project", "method": "rk4", "step": 0.001, "t_end": 1.5, "output_every": 0.1}}))
    return path


def part_scene(folder: pathlib.Path) -> pathlib.Path:
    """A chain that hangs from its last point, of which the lower end is not shown."""
    path = folder / "part.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "points": {"positions": [[0, 0, -3], [0, 0, -2], [0, 0, -1], [0, 0, 0]]}, "supports": [{"points": [3]}],
        "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [3, 2], [2, 1]]}],
        "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
        "motion": {"t_end": 0.1, "output_every": 0.05, "output_points": [3, 2, 1]}}))
    return path


def shared_scene(folder: pathlib.Path) -> pathlib.Path:
    """Two rods hold one weight together, in any share, and a third another one alone."""
    path = folder / "shared.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "points": {"positions": [[0, 0, 0], [0, 0, -1], [1, 0, 0], [1, 0, -1]], "masses": 2},
        "supports": [{"name": "hooks", "points": [0, 2]}],
        "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0, 1], [0, 1], [2, 3]]}],
        "forces": [{"kind": "gravity", "acceleration": [0, 0, -10]}],
        "observe": ["each tension(rods)", "tension(rods[1])", "sum tension(rods)"],
        "motion": {"t_end": 0.1, "output_every": 0.05}}))
    return path


def slack_scene(folder: pathlib.Path) -> pathlib.Path:
    """A ball falls on a slack string, which is taut in the end."""
    path = folder / "slack.json"
    path.write_text(json.dumps({
        "tanor_scene": 1, "points": {"positions": [[0, 0, 0], [0.3, 0, -0.2]], "masses": 1}, "supports": [{"points": [0]}],
        "constraints": [{"name": "string", "kind": "rope", "paths": [[0, 1]], "length": 1}],
        "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 0.5, "output_every": 0.05}}))
    return path


def fixed_scene(folder: pathlib.Path) -> pathlib.Path:
    path = folder / "fixed.json"
    path.write_text(json.dumps({"tanor_scene": 1, "units": "si", "points": {"positions": [[0, 0, 0]]}, "supports": [{"points": [0]}],
                                "motion": {"t_end": 1}}))
    return path


def has_module(program: str, name: str) -> bool:
    return (pathlib.Path(program).parent / f"tanor_{name}.so").exists()


def picture(program: str, out: pathlib.Path) -> None:
    if has_module(program, "picture"):
        told = subprocess.run([program, "picture", str(out), "--json", "--size", "320x200"], check=True, stdout=subprocess.PIPE)
        (out / "picture.json").write_bytes(told.stdout)


def simulate(program: str, scene: pathlib.Path, out: pathlib.Path) -> None:
    """The saddle in two parts, the hostile scene in one without a page and one with it; of the pendulum errors were measured
    before, in its folder and in that of the net."""
    shutil.rmtree(out, ignore_errors=True)
    if scene.stem in STATICS:
        subprocess.run([program, STATICS[scene.stem], str(scene), "--out", str(out)], check=True, stdout=subprocess.DEVNULL)
        return picture(program, out)
    command = [program, "run", str(scene), "--out", str(out), "--quiet", "--report"]
    if scene.stem in ("pendulum", "net"):
        subprocess.run([program, "error-time", str(ROOT / "examples/pendulum.json"), "--out", str(out), "--quiet", "--methods", "rk4,dopri5", "--t-end", "0.5"],
                       check=True, stdout=subprocess.DEVNULL)
    if scene.stem == "saddle":
        subprocess.run([*command, "--t-end", "100.4"], check=True)
        command.append("--resume")
    if scene.stem == "hostile":
        subprocess.run([*command[:-1], "--t-end", str(HOSTILE_BEGIN)], check=True)
        command.append("--resume")
    if scene.stem == "melt_generated":
        command += ["--t-end", "0.05"]
    done = subprocess.run(command, check=False, stderr=subprocess.DEVNULL if scene.stem in STOPPED else None)
    if done.returncode != (3 if scene.stem in STOPPED else 0):
        raise subprocess.CalledProcessError(done.returncode, command)
    if scene.stem in EXAMPLES:
        picture(program, out)


def try_pages(program: str, folder: pathlib.Path, node: str, chromium: str) -> bool:
    """All of them in one browser, which takes seconds to start."""
    switches = {ROOT / "examples" / f"{name}.json": each for name, each in EXAMPLES.items()}
    switches |= {saddle_scene(folder): "points,guides,normal", guides_scene(folder): "points,guides,normal",
                 table_scene(folder): "points,guides,normal,tangent",
                 hostile_scene(folder): "points,rods,normal", fixed_scene(folder): "=nothing moves",
                 resting_scene(folder): "=certified", crane_scene(folder): "points,rods,guides,normal", box_scene(folder): "points,rods,cell",
                 ropes_scene(folder): "points,guides,normal",
                 hanging_scene(folder, "equilibrium"): f"~{2 * 9.81}", hanging_scene(folder, "modes"): f"~{2 * 9.81}",
                 stressed_scene(folder): "~unknown", torn_scene(folder): "!", shared_scene(folder): "?20", slack_scene(folder): "_", part_scene(folder): "+tension of links[2] (2–1),load of support0 (point 3)"}
    switches |= {contradictory_scene(folder, name, length): "=not made" for name, length in STOPPED.items()}
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda scene: simulate(program, scene, folder / scene.stem), switches))
    begins = {"hostile": HOSTILE_BEGIN}
    trials = [f"{folder / scene.stem}:{each}:{scene}:{begins.get(scene.stem, '')}" for scene, each in switches.items()]
    return subprocess.run([node, str(ROOT / "tests/report/page.mjs"), chromium, *trials], check=False).returncode == 0


def try_following(program: str, folder: pathlib.Path, node: str, chromium: str) -> bool:
    """Watches a run that is interrupted when the page has shown that it goes on."""
    out = folder / "endless"
    shutil.rmtree(out, ignore_errors=True)
    print("a run that goes on", flush=True)
    run = subprocess.Popen([program, "run", str(endless_scene(folder)), "--out", str(out), "--quiet", "--report"])
    view = None
    try:
        while not (out / "report.html").exists() and run.poll() is None:
            time.sleep(0.05)
        view = subprocess.Popen([program, "view", str(out), "--no-open", "--quiet"], stdout=subprocess.PIPE, text=True)
        url = view.stdout.readline().split(" ")[0]
        tried = subprocess.Popen([node, str(ROOT / "tests/report/follow.mjs"), url, chromium], stdout=subprocess.PIPE, text=True)
        if tried.stdout.readline().strip() == "running":
            run.send_signal(signal.SIGINT)
        return tried.wait() == 0 and run.wait() == 130
    finally:
        for process in (run, view):
            if process and process.poll() is None:
                process.kill()
                process.wait()


def main() -> int:
    program, folder, node = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not chromium:
        print("there is no chromium")
        return 1 if os.environ.get("CI") else 77
    folder.mkdir(parents=True, exist_ok=True)
    # A browser on a crowded machine may lose a click or a frame; what is wrong is wrong twice.
    if not try_pages(program, folder, node, chromium) and not try_pages(program, folder, node, chromium):
        return 1
    if not has_module(program, "view"):
        print("following a run is left out: this tanor has no server")
        return 1 if os.environ.get("CI") else 0
    return 0 if try_following(program, folder, node, chromium) else 1


if __name__ == "__main__":
    sys.exit(main())
