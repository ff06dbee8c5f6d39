#!/usr/bin/python3
"""Contact problems by Siconos (Debian's python3-siconos) and by tanor, in turn: processor seconds of each that is solved.

    siconos_contacts.py CONTACTS FILE... [--seconds 10] [--rounds 3]

CONTACTS is the program build/bench/contacts. Tolerances are 1e-4, 1e-8 and 1e-12, each from r = 0 on. Siconos is judged
by its own error, |r - P(r - u)| over the larger one of |q| and |r|; tanor by the stricter one over |q|. Prints how many
are solved, and the sum of the median seconds over the problems that all of them solve.
"""

import argparse
import contextlib
import os
import pathlib
import resource
import signal
import statistics
import subprocess
import tempfile

import numpy
import siconos.numerics as sn

SOLVERS = {"NSGS": sn.SICONOS_FRICTION_3D_NSGS, "NSN_AC": sn.SICONOS_FRICTION_3D_NSN_AC,
           "ADMM": sn.SICONOS_FRICTION_3D_ADMM, "PROX": sn.SICONOS_FRICTION_3D_PROX}
TOLERANCES = (1e-4, 1e-8, 1e-12)


def by_siconos(file: pathlib.Path, solver: int, tolerance: float, limit: float) -> float | None:
    """Processor seconds in a process of its own, or None if it does not come there within the limit."""
    reader, writer = os.pipe()
    if (child := os.fork()) == 0:
        signal.alarm(int(3 * limit) + 1)
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 3, int(limit) + 3))
        with open(os.devnull, "w") as nothing:
            os.dup2(nothing.fileno(), 1)
            os.dup2(nothing.fileno(), 2)
        problem = sn.frictionContact_new_from_filename(str(file))
        size = 3 * problem.numberOfContacts
        r, u = numpy.zeros(size), numpy.zeros(size)
        options = sn.SolverOptions(solver)
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = 10**7
        options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        failed = sn.fc3d_driver(problem, r, u, options)
        spent = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
        is_solved = failed == 0 and options.dparam[sn.SICONOS_DPARAM_RESIDU] <= tolerance and spent <= limit
        os.write(writer, f"{spent if is_solved else -1}".encode())
        os._exit(0)
    os.close(writer)
    os.waitpid(child, 0)
    with contextlib.closing(os.fdopen(reader)) as answer:
        text = answer.read()
    return float(text) if text and float(text) >= 0.0 else None


def by_tanor(contacts: str, file: pathlib.Path, limit: float) -> list:
    line = subprocess.run([contacts, file, "--seconds", str(limit)], check=True, capture_output=True,
                          text=True).stdout.splitlines()[0]
    parts = line.split("|")[1:]
    return [float(part.split()[-1]) if part[1] != "x" else None for part in parts]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("contacts")
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    seconds = {}  # [tolerance, name] -> {problem: median or None}
    with tempfile.TemporaryDirectory() as folder:
        for file in options.files:
            subprocess.run([options.contacts, file, "--write", folder], check=True, capture_output=True)
            text = pathlib.Path(folder) / file.with_suffix(".txt").name
            rounds = {}
            for _ in range(options.rounds):
                for tolerance, spent in zip(TOLERANCES, by_tanor(options.contacts, file, options.seconds)):
                    rounds.setdefault((tolerance, "tanor"), []).append(spent)
                for name, solver in SOLVERS.items():
                    for tolerance in TOLERANCES:
                        if None not in (all_rounds := rounds.setdefault((tolerance, name), [])):
                            all_rounds.append(by_siconos(text, solver, tolerance, options.seconds))
            for key, spent in rounds.items():
                seconds.setdefault(key, {})[file.stem] = None if None in spent else statistics.median(spent)
    for tolerance in TOLERANCES:
        names = ["tanor", *SOLVERS]
        solved_by_all = [file.stem for file in options.files
                         if all(seconds[tolerance, name][file.stem] is not None for name in names)]
        print(f"{tolerance:g}: {len(solved_by_all)} of {len(options.files)} are solved by all")
        for name in names:
            spent = seconds[tolerance, name]
            print(f"    {name:8} solves {sum(each is not None for each in spent.values()):3}, "
                  f"{sum(spent[stem] for stem in solved_by_all):9.5f} s for those", flush=True)


main()
