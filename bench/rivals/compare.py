#!/usr/bin/python3
"""Runs tanor and its rivals in turn on the same problems and tabulates the time that each needs to reach an error.

    compare.py DRIVERS OUT [PROBLEM …]    DRIVERS: folder of rival_tanor, …; those that are not there are left out.
                                          dense_product is in the folder above (see scripts/blas_kernels)
                                          PROBLEM: P1-1000 P2 P3 A01 P1-10 P1-100 S1 S1-damped S2 S3
                                          (default: all)

Writes OUT/rivals.csv (every run), OUT/rivals.md (times to reach an error, ratios, bars) and OUT/rivals_PROBLEM.svg;
problems that are not run stay there as an earlier run left them in OUT/rivals.csv.
Processor time of one thread, without set-up; the middle one of three rounds, in each of which all programs run one
after the other (runs of more than 2 s are made once). What aborts, gives NaN or takes more than a minute is a row that
says so.
"""

import csv
import datetime
import math
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import tempfile
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROUNDS = 3
SLOW = 2.0          # s; not repeated
TIME_LIMIT = 60.0   # s a run
# Processor time is that of the whole process: threads of OpenBLAS spin after they are started, though nobody asks them.
# main() adds the kernels of OpenBLAS that are fastest here.
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
OWN_ORDER = "tanor taylor, own order"


class Run(NamedTuple):
    """One program with one setting."""
    driver: str        # tanor, sundials, simbody, mujoco, openmm, gromacs
    method: str
    tolerance: float   # of the last three, and of generalized_alpha, the step, s

    def group(self) -> str:
        """What competes as one: all orders of the series with one linear solver, …"""
        return f"{self.driver} " + re.sub(r"^taylor\d+", "taylor", self.method)


class Problem(NamedTuple):
    name: str         # of the drivers
    size: int
    title: str
    targets: list     # errors, m
    runs: list
    reference: str    # file; empty: closed form


def runs_of(driver: str, methods: str, tolerances: list) -> list:
    return [Run(driver, method, tolerance) for method in methods.split() for tolerance in tolerances]


def tanor_runs(finest: int, orders: str) -> list:
    tolerances = [10.0**-k for k in range(3, finest + 1)]
    return (runs_of("tanor", "taylor dop853", tolerances) + runs_of("tanor", orders, tolerances[::2]) +
            runs_of("tanor", "dopri5", tolerances[:7:2]))


def sundials_runs(low_orders: list, erk8: list) -> list:
    return runs_of("sundials", "erk5 adams bdf", low_orders) + runs_of("sundials", "erk8", erk8)


def stiff_runs(steps: list, sdirk: list, bdf: list, ida: list) -> list:
    """Explicit methods, for comparison, and implicit ones: bdf and ida up to order 5, and up to 2. steps: of
    generalized_alpha; the others: tolerances."""
    return (runs_of("tanor", "radau5", [10.0**-k for k in range(1, 10)]) +
            runs_of("tanor", "generalized_alpha", steps) + runs_of("tanor", "taylor dop853", [1e-4, 1e-6, 1e-8]) +
            runs_of("sundials", "erk8", [1e-6, 1e-8]) +
            runs_of("sundials", "sdirk", sdirk) + runs_of("sundials", "bdf", bdf) + runs_of("sundials", "ida", ida) +
            runs_of("sundials", "bdf2 ida2", [1e-3, 1e-4, 1e-6, 1e-8, 1e-9]))


PROBLEMS = {
    "P1-1000": Problem("chain", 1000, "chain of 1000 rods, 1 s", [1e-4, 1e-6, 1e-9],
                       tanor_runs(11, "taylor8 taylor10 taylor12 taylor16") +
                       runs_of("tanor", "taylor/general dop853/general", [10.0**-k for k in range(3, 12)]) +
                       runs_of("tanor", "taylor8/general taylor10/general taylor12/general taylor16/general",
                               [10.0**-k for k in range(3, 12, 2)]) +
                       sundials_runs([1e-4, 1e-6, 1e-8], [1e-4, 1e-6, 1e-8, 1e-10, 1e-11]) +
                       runs_of("sundials", "ida", [1e-4, 1e-6, 1e-8]) + runs_of("simbody", "rkm", [1e-3, 1e-6]) +
                       runs_of("openmm", "ccma", [1e-3, 2e-4]) + runs_of("gromacs", "lincs", [1e-3, 1e-4]),
                       "chain1000.txt"),
    "P2": Problem("net", 30, "net of 30 x 30 beads, 0.1 s", [2e-6, 3e-9],
                  tanor_runs(11, "taylor8 taylor12 taylor16") +
                  sundials_runs([1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10], [1e-4, 1e-6, 1e-8, 1e-9, 1e-10]) +
                  runs_of("sundials", "ida", [1e-5, 1e-7, 1e-9]) + runs_of("mujoco", "tendons", [1e-2, 5e-3, 2e-3]) +
                  runs_of("openmm", "ccma", [1e-2, 1e-3]) + runs_of("gromacs", "lincs", [1e-3, 1e-4]), "net30.txt"),
    "P3": Problem("pendulum", 1, "pendulum of 0.1 m, 10 s", [1e-6, 5e-9, 1e-10],
                  tanor_runs(14, "taylor12 taylor16 taylor20 taylor24") +
                  sundials_runs([1e-6, 1e-8, 1e-10, 1e-12], [1e-6, 1e-8, 1e-10, 1e-12, 1e-13]) +
                  runs_of("sundials", "ida", [1e-6, 1e-8, 1e-10, 1e-12]) +
                  runs_of("simbody", "rkm", [1e-4, 1e-6, 1e-8]) + runs_of("mujoco", "tree", [1e-2, 5e-3, 2e-3, 1e-3]) +
                  runs_of("openmm", "ccma", [1e-3, 1e-4, 1e-5]) + runs_of("gromacs", "lincs", [1e-3, 1e-4]),
                  "pendulum.txt"),
    "A01": Problem("a01", 1, "IFToMM A01: pendulum of 1 m, 2000 s", [1e-3, 1e-6],
                   tanor_runs(14, "taylor12 taylor16 taylor20 taylor24") +
                   runs_of("sundials", "erk8", [1e-8, 1e-10, 1e-12]) + runs_of("sundials", "ida", [1e-8, 1e-10]) +
                   runs_of("mujoco", "tree", [1e-2, 5e-3, 2e-3]), ""),
    "P1-10": Problem("chain", 10, "chain of 10 rods, 1 s", [1e-4, 1e-6, 1e-9],
                     tanor_runs(12, "taylor8 taylor12 taylor16") +
                     sundials_runs([1e-4, 1e-6, 1e-8, 1e-10], [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]) +
                     runs_of("sundials", "ida", [1e-4, 1e-6, 1e-8, 1e-10]) +
                     runs_of("simbody", "rkm", [1e-3, 1e-5, 1e-7, 1e-9]) +
                     runs_of("mujoco", "tree", [1e-2, 2e-3, 1e-3, 2e-4]) + runs_of("openmm", "ccma", [1e-3, 1e-4]) +
                     runs_of("gromacs", "lincs", [1e-3, 1e-4]), "chain10.txt"),
    "P1-100": Problem("chain", 100, "chain of 100 rods, 1 s", [1e-4, 1e-6, 1e-9],
                      tanor_runs(12, "taylor8 taylor12 taylor16") +
                      sundials_runs([1e-4, 1e-6, 1e-8, 1e-10], [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]) +
                      runs_of("sundials", "ida", [1e-4, 1e-6, 1e-8, 1e-10]) +
                      runs_of("simbody", "rkm", [1e-3, 1e-5, 1e-7]) + runs_of("mujoco", "tree", [1e-2, 5e-3, 2e-3]) +
                      runs_of("openmm", "ccma", [1e-3, 1e-4]) + runs_of("gromacs", "lincs", [1e-3, 1e-4]),
                      "chain100.txt"),
    "S1": Problem("springs", 100, "chain of 50 rods and 50 springs of 1e8 N/m, 1 s", [1e-3, 1e-6, 1e-9],
                  stiff_runs([1e-2, 1e-3, 1e-4], [1e-2, 1e-3, 1e-4, 1e-6, 1e-8], [1e-3, 1e-4, 1e-6],
                             [1e-3, 1e-4, 1e-8]), "springs100.txt"),
    "S1-damped": Problem("damped", 100, "chain of 50 rods and 50 damped springs of 1e8 N/m, 1 s", [1e-3, 1e-6, 1e-9],
                         stiff_runs([1e-2, 1e-3, 1e-4], [1e-2, 1e-3, 1e-4, 1e-6, 1e-8],
                                    [1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11],
                                    [1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-11]), "damped100.txt"),
    "S2": Problem("honey", 100, "chain of 100 rods in honey, 20 s", [1e-3, 1e-6, 1e-9],
                  stiff_runs([1e-1, 1e-2, 1e-3], [1e-2, 1e-4, 1e-6, 1e-8],
                             [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-11],
                             [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-11]), "honey100.txt"),
    "S3": Problem("car_axis", 1, "car axis of the IVP test set, 3 s", [1e-3, 1e-6, 1e-9],
                  stiff_runs([1e-2, 1e-3, 1e-4], [1e-3, 1e-4, 1e-6, 1e-8, 1e-10], [1e-4, 1e-6, 1e-8, 1e-10, 1e-12],
                             [1e-4, 1e-6, 1e-8, 1e-10, 1e-11]), "car_axis.txt"),
}

STIFF_RIVALS = ["sundials sdirk", "sundials bdf", "sundials ida", "sundials bdf2", "sundials ida2"]


class Bar(NamedTuple):
    problem: str
    error: float
    ours: str
    rivals: list
    ratio: float


BARS = [
    Bar("P1-1000", 1e-6, "tanor taylor", ["sundials erk8"], 15.0),
    Bar("P1-1000", 1e-9, "tanor taylor", ["sundials erk8"], 25.0),
    Bar("P1-1000", 1e-6, "tanor taylor", ["simbody rkm"], 100.0),
    Bar("P1-1000", 1e-6, "tanor dop853", ["sundials erk8"], 2.0),
    Bar("P1-1000", 1e-9, "tanor dop853", ["sundials erk8"], 2.0),
    Bar("P1-1000", 1e-6, "tanor taylor/general", ["sundials erk8"], 3.0),
    Bar("P1-1000", 1e-9, "tanor taylor/general", ["sundials erk8"], 4.0),
    Bar("P1-1000", 1e-6, "tanor dop853/general", ["sundials erk8"], 2.0),
    Bar("P1-1000", 1e-9, "tanor dop853/general", ["sundials erk8"], 2.0),
    Bar("P2", 2e-6, "tanor taylor", ["sundials erk5", "sundials erk8", "sundials adams", "sundials bdf"], 3.0),
    Bar("P2", 3e-9, "tanor taylor", ["sundials erk5", "sundials erk8", "sundials adams", "sundials bdf"], 7.0),
    Bar("P3", 5e-9, "tanor taylor", ["sundials erk8"], 15.0),
    Bar("S1", 1e-6, "tanor radau5", STIFF_RIVALS, 1.0),
    Bar("S1-damped", 1e-6, "tanor radau5", STIFF_RIVALS, 1.0),
    Bar("S2", 1e-6, "tanor radau5", STIFF_RIVALS, 1.0),
]


def pendulum_place(t: float) -> list:
    """1 m, released horizontally at x = 1: sin(theta/2) = k sn(K - sqrt(g/l) t, k), k = sin(pi/4), theta from the low
    point; K and sn by the arithmetic-geometric mean (Abramowitz & Stegun 16.4, 17.6)."""
    k = math.sqrt(0.5)
    means, differences, other = [1.0], [k], math.sqrt(1.0 - k * k)
    for _ in range(6):
        means, other, differences = (means + [0.5 * (means[-1] + other)], math.sqrt(means[-1] * other),
                                     differences + [0.5 * (means[-1] - other)])
    quarter = math.pi / (2.0 * means[-1])
    phi = 2.0**6 * means[-1] * math.remainder(quarter - math.sqrt(9.81) * t, 4.0 * quarter)
    for mean, difference in zip(means[:0:-1], differences[:0:-1]):
        phi = 0.5 * (phi + math.asin(difference / mean * math.sin(phi)))
    theta = 2.0 * math.asin(k * math.sin(phi))
    return [math.sin(theta), 0.0, -math.cos(theta)]


def read_places(file: pathlib.Path) -> list:
    lines = [line.split() for line in file.read_text().splitlines() if not line.startswith("#")]
    return [[float(word) for word in line] for line in lines if len(line) == 3]


def largest_distance(places: list, truth: list) -> float:
    assert len(places) == len(truth)
    return max(math.dist(a, b) for a, b in zip(places, truth))


def driver_of(drivers: pathlib.Path, name: str) -> pathlib.Path:
    return drivers / f"rival_{name}"


def make_run(drivers: pathlib.Path, problem: Problem, run: Run, truth: list) -> dict:
    """{"seconds", "steps", "factorizations", "error"}, or {"trouble"}."""
    with tempfile.NamedTemporaryFile() as end:
        command = [driver_of(drivers, run.driver), problem.name, str(problem.size), run.method, f"{run.tolerance:g}",
                   end.name]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                  check=False, timeout=TIME_LIMIT, env=ENVIRONMENT)
        except subprocess.TimeoutExpired:
            return {"trouble": f"takes more than {TIME_LIMIT:g} s"}
        if done.returncode != 0 or not done.stdout.split():
            return {"trouble": "aborts, " + (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]}
        places = read_places(pathlib.Path(end.name))
        if not all(math.isfinite(coordinate) for place in places for coordinate in place):
            return {"trouble": "NaN"}
        seconds, steps, factorizations = done.stdout.split()[-3:]
        return {"seconds": float(seconds), "steps": int(steps), "factorizations": int(factorizations),
                "error": largest_distance(places, truth)}


def measure(drivers: pathlib.Path, problem: Problem) -> list:
    """One row a run: the middle of its times over the rounds."""
    truth = read_places(ROOT / "bench/rivals/reference" / problem.reference) if problem.reference else [pendulum_place(2000.0)]
    runs = [run for run in problem.runs if driver_of(drivers, run.driver).exists()]
    times, rows = {}, {}
    for _ in range(ROUNDS):
        for run in runs:
            if "trouble" in rows.get(run, {}) or times.get(run, [0.0])[0] > SLOW:
                continue
            rows[run] = make_run(drivers, problem, run, truth)
            times.setdefault(run, []).append(rows[run].get("seconds", math.nan))
    return [{"group": run.group(), "method": run.method, "tolerance": run.tolerance, **rows[run],
             "seconds": statistics.median(times[run]), "measured": describe_now()} for run in runs]


def choose_kernels(drivers: pathlib.Path) -> dict:
    """{"OPENBLAS_CORETYPE": …} where OpenBLAS does not choose its fastest kernels by itself, by the rule of scripts/bench."""
    asked = [ROOT / "scripts/blas_kernels", drivers.resolve().parent / "dense_product"]
    kernels = subprocess.run(asked, check=True, stdout=subprocess.PIPE, text=True, env=ENVIRONMENT).stdout.strip()
    return {"OPENBLAS_CORETYPE": kernels} if kernels else {}


def describe_now() -> str:
    load = pathlib.Path("/proc/loadavg").read_text().split()[0] if pathlib.Path("/proc/loadavg").exists() else "?"
    kernels = f", OpenBLAS as {ENVIRONMENT['OPENBLAS_CORETYPE']}" if "OPENBLAS_CORETYPE" in ENVIRONMENT else ""
    return f"{datetime.date.today()} on {processor()}{kernels}, load {load}"


def read_rows(file: pathlib.Path) -> dict:
    """Problem -> its rows, as an earlier run wrote them."""
    measured = {}
    if file.exists():
        with open(file, newline="", encoding="utf-8") as lines:
            for row in csv.DictReader(lines):
                for number in ("tolerance", "seconds", "error"):
                    row[number] = float(row[number] or math.nan)
                measured.setdefault(row.pop("problem"), []).append(row)
    return measured


def rows_of(rows: list, group: str) -> list:
    """Those that arrived."""
    if group == OWN_ORDER:
        return [row for row in rows if row["method"] == "taylor" and not row.get("trouble")]
    return [row for row in rows if row["group"] == group and not row.get("trouble")]


def time_to_reach(rows: list, group: str, error: float) -> float | None:
    """Log-log interpolation between the fastest runs of a group; None: none comes so near."""
    front = []  # from coarse to fine: nobody is finer and faster
    for row in sorted((row for row in rows_of(rows, group) if row["error"] > 0.0),
                      key=lambda row: (row["seconds"], row["error"])):
        if not front or row["error"] < front[-1]["error"]:
            front.append(row)
    for k, fine in enumerate(front):
        if fine["error"] <= error:
            if k == 0:
                return fine["seconds"]
            coarse = front[k - 1]
            part = math.log(coarse["error"] / error) / math.log(coarse["error"] / fine["error"])
            return coarse["seconds"] * (fine["seconds"] / coarse["seconds"]) ** part
    return None


def describe_time(seconds: float | None) -> str:
    return "–" if seconds is None else f"{1e3 * seconds:.3g}"


def make_table(problem: Problem, rows: list) -> str:
    groups = list(dict.fromkeys(row["group"] for row in rows))
    if any(row["group"] == "tanor taylor" and row["method"] != "taylor" for row in rows):
        groups.insert(groups.index("tanor taylor") + 1, OWN_ORDER)
    text = f"## {problem.title}\n\nMilliseconds to reach an error of ({rows[0].get('measured') or 'earlier'})\n\n"
    text += "| | " + " | ".join(f"{error:g} m" for error in problem.targets) + " | smallest error met, m |\n"
    text += "|---|" + "--:|" * (len(problem.targets) + 1) + "\n"
    for group in groups:
        errors = [row["error"] for row in rows_of(rows, group)]
        times = [describe_time(time_to_reach(rows, group, error)) for error in problem.targets]
        troubles = [row["trouble"] for row in rows if row["group"] == group and row.get("trouble")]
        best = f"{min(errors):.1e}" if errors else troubles[0] if troubles else "–"
        text += f"| {group} | " + " | ".join(times) + f" | {best} |\n"
    for row in rows:
        if row.get("trouble"):
            text += f"\n{row['group']} with {row['tolerance']:g}: {row['trouble']}\n"
    return text + "\n"


def make_bars(measured: dict) -> str:
    text = "## Bars\n\n| problem | error, m | | ahead of | ratio | wanted | |\n|---|--:|---|---|--:|--:|---|\n"
    for bar in BARS:
        if bar.problem not in measured:
            continue
        rows = measured[bar.problem]
        ours = time_to_reach(rows, bar.ours, bar.error)
        theirs = [(time, rival) for rival in bar.rivals if (time := time_to_reach(rows, rival, bar.error)) is not None]
        if ours is None or not theirs:
            ratio, rival, verdict = "–", ", ".join(bar.rivals), "not reached by " + ("us" if ours is None else "them")
        else:
            time, rival = min(theirs)
            ratio, verdict = f"{time / ours:.1f}", "held" if time >= bar.ratio * ours else "**missed**"
        text += (f"| {PROBLEMS[bar.problem].title} | {bar.error:g} | {bar.ours} | {rival} | {ratio} | {bar.ratio:g} | "
                 f"{verdict} |\n")
    return text + "\n"


def processor() -> str:
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines() if pathlib.Path("/proc/cpuinfo").exists() else []
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def write_results(out: pathlib.Path, measured: dict) -> None:
    with open(out / "rivals.csv", "w", newline="", encoding="utf-8") as file:
        fields = ["problem", "group", "method", "tolerance", "seconds", "steps", "factorizations", "error", "trouble",
                  "measured"]
        writer = csv.DictWriter(file, fields)
        writer.writeheader()
        for name, rows in measured.items():
            writer.writerows({"problem": name, **row} for row in rows)
    text = f"""# tanor beside its rivals: time to reach an error

Repeat with `scripts/error-time --rivals`. Processor time of one thread, steps alone without set-up, the middle one of
{ROUNDS} rounds in which all programs run in turn (runs of more than {SLOW:g} s: once): trust ratios more than times.
Error: largest distance of a bead at the end from digits that others than tanor made (`bench/rivals/reference`; the
net's are erk8's with 1e-13, dop853 and taylor agree to 2e-14; those of springs and honey erk8's, which taylor meets to
2e-11 and 4e-14; the car axis: published; A01: closed form).
Each program with the best of the settings in `rivals.csv`, log-log interpolation between them.

- taylor, dop853, dopri5: tanor. taylor is the best of the orders that were tried; "own order": what it takes by itself;
  "/general": with the solver of S lambda = b that serves everything, sparse factors, in place of that along paths.
- radau5, generalized_alpha: tanor's implicit methods, the latter with fixed steps.
- erk5, erk8: SUNDIALS' ARKODE, projected after each step; adams: CVODE, which has no projection with it; bdf: CVODE with
  projection. S and its projections are written by hand (`bench/rivals/normal_form.hpp`, Eigen's SimplicialLDLT).
- ida: SUNDIALS' IDA on the stabilised form of index 2 (`bench/rivals/stabilised_form.hpp`), Newton's matrix by hand,
  KLU; the forces of springs as unknowns.
- sdirk: ARKODE's Kvaerno 5(4), projected; it and, where the problem is stiff, bdf take Newton's iteration: with springs
  a band matrix by differences, in honey GMRES, for the car axis a dense matrix (as IDA there). bdf2, ida2: up to order
  2, which is stable on undamped swings, too.
- simbody rkm: a tree of universal joints, Runge-Kutta-Merson.
- mujoco: Runge-Kutta 4 with a fixed step; tree: ball joints (1000 of them take seconds a step: not run), tendons: rods
  as equalities of tendons, which are strong springs.
- openmm ccma: leapfrog with constraints and a fixed step, the reference platform in double precision.
- gromacs lincs: velocity Verlet with a fixed step, LINCS of order 8 with 4 iterations, in double precision; its time is
  what it says itself, wall time in milliseconds.

"""
    text += make_bars(measured) + "".join(make_table(PROBLEMS[name], rows) for name, rows in measured.items())
    if "A01" in measured:
        text += "OpenSim's published time for A01 is 637 ms, on another machine.\n"
    subprocess.run([ROOT / "scripts/draw_results.py", out], check=True)
    for name in measured:
        picture = f"![{PROBLEMS[name].title}](rivals_{name}.svg)\n\n"
        text = text.replace(f"## {PROBLEMS[name].title}\n\n", f"## {PROBLEMS[name].title}\n\n{picture}")
    (out / "rivals.md").write_text(text, encoding="utf-8")


def main() -> None:
    drivers, out, names = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:] or list(PROBLEMS)
    out.mkdir(parents=True, exist_ok=True)
    ENVIRONMENT.update(choose_kernels(drivers))
    for driver in dict.fromkeys(run.driver for name in names for run in PROBLEMS[name].runs):
        if not driver_of(drivers, driver).exists():
            print(f"compare: {driver} is not built and left out", flush=True)
    measured = {name: rows for name, rows in read_rows(out / "rivals.csv").items() if name in PROBLEMS}
    for name in names:
        measured[name] = measure(drivers, PROBLEMS[name])
        measured = {known: measured[known] for known in PROBLEMS if known in measured}
        print(make_table(PROBLEMS[name], measured[name]), flush=True)
        write_results(out, measured)
    print(make_bars(measured))


if __name__ == "__main__":
    main()
