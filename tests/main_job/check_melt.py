#!/usr/bin/python3
"""check_melt.py MAIN_JOB PROGRAM FOLDER: runs the main job and checks what it reports."""

import csv
import json
import os
import pathlib
import subprocess
import sys


def check(condition: bool, what: str) -> None:
    print(("ok    " if condition else "WRONG ") + what)
    if not condition:
        sys.exit(1)


def main() -> None:
    main_job, program, folder = sys.argv[1:]
    page = subprocess.run([main_job, program, folder], stdout=subprocess.PIPE, text=True, check=True).stdout
    folder = pathlib.Path(folder)
    summary = json.loads((folder / "summary.json").read_text())

    check(page.rstrip().endswith(("report.html", "report.txt")), "the page ends with where the report lies")
    real = summary["source"].startswith("import:") and "data.chain" in summary["source"]
    check(real or os.environ.get("CI") != "true", f"source: {summary['source']}")
    check((summary["points"], summary["equations"], summary["islands"]) == (32000, 31680, 320), "size")
    check(summary["degrees_of_freedom"] == 3 * 32000 - 31680, "degrees of freedom")
    check(summary["t_reached"] == summary["t_end"], "end reached")
    check(summary["violation"]["position_max"] <= 1e-10, f"violation {summary['violation']['position_max']:.1e}")
    # RATTLE with WCA beads: of order h^2; without them dopri5: of order h^5
    allowed = 3e-5 if real else 1e-9
    check(abs(summary["energy"]["drift_relative"]) <= allowed, f"drift {summary['energy']['drift_relative']:.1e}")
    check(("pair forces: none" in summary["left_out"]) != real, "the beads of the real melt repel each other")
    check(not real or "pair (wca, box 33.59 x 33.59 x 33.59 sigma, not along rods)" in page, "the page says so")

    with open(folder / "error_time.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    check(len(rows) == 20 and not any(row["trouble"] for row in rows), "20 rows without trouble")
    compared = [(float(row["error"]), float(row["reference_error"])) for row in rows]
    check(all(error >= 3.0 * uncertainty for error, uncertainty in compared), "references are better than the rows")
    for method, order in (("rattle", 2.0), ("rk4", 4.0)):
        last = [float(row["order"]) for row in rows if row["method"] == method][-1]
        check(abs(last - order) < 0.3, f"order of {method} {last:.2f}")
    drift = [float(row["energy_drift"]) for row in rows if row["method"] == "dopri5"][-1]
    check(abs(drift) <= 1e-9, f"without repulsion drift of dopri5 {drift:.1e}")
    errors = [float(row["error"]) for row in rows if row["method"] == "dopri5"]
    check(all(b < 0.1 * a for a, b in zip(errors, errors[1:])), "dopri5: error falls with the tolerance")


if __name__ == "__main__":
    main()
