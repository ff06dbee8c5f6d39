#!/usr/bin/python3
"""check_protein.py FETCH SCENE PROGRAM FOLDER: a protein whose bonds and angles are rigid, 173 equations too many."""

import json
import os
import pathlib
import subprocess
import sys


SKIPPED = 77  # as CMakeLists.txt says


def check(condition: bool, what: str) -> None:
    print(("ok    " if condition else "WRONG ") + what)
    if not condition:
        sys.exit(1)


def main() -> None:
    fetch, scene, program, folder = sys.argv[1:]
    fetched = subprocess.run([fetch, "protein"], stdout=subprocess.PIPE, text=True, check=False)
    if fetched.returncode != 0:
        check(os.environ.get("CI") != "true", "the protein is available, or nobody insists on it")
        sys.exit(SKIPPED)

    told = subprocess.run([program, "check", scene], stdout=subprocess.PIPE, text=True, check=True).stdout
    check("2359" in told and "depends on" in told, "check finds the rank and names what depends")

    answer = json.loads(subprocess.run([program, "solve", scene], stdout=subprocess.PIPE, check=True).stdout)
    check(answer["rank"] == 2359, f"rank {answer['rank']} of 2532, as a dense singular value decomposition says")
    check(answer["degrees_of_freedom"] == 3 * 892 - 2359, "degrees of freedom")
    check(len(answer["redundant"]) == 173, f"{len(answer['redundant'])} redundant rows by name")
    check(answer["multipliers_unique"].count(True) == 1494, "multipliers that are determined")
    certificate = answer["certificate"]
    check(certificate["verdict"].startswith("certified to"), certificate["verdict"])
    check(certificate["residual"] <= 1e-10, f"residual {certificate['residual']:.1e}")

    subprocess.run([program, "run", scene, "--out", folder, "--quiet"], check=True)
    summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
    check(summary["t_reached"] == summary["t_end"], "end reached")
    check(summary["violation"]["position_max"] <= 1e-10, f"violation {summary['violation']['position_max']:.1e}")
    check(abs(summary["energy"]["drift_relative"]) <= 1e-8, f"drift {summary['energy']['drift_relative']:.1e}")
    verdict = summary["certificate"]["verdict"]
    check(verdict.startswith("certified to"), verdict)


if __name__ == "__main__":
    main()
