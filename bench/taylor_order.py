#!/usr/bin/python3
"""taylor_order.py PROGRAM SCENE [T_END [TOLERANCE ...]]: run time and error of `taylor` by its number of terms.

Beside it dop853, and the number of terms that taylor chooses itself ("own"). Errors are against rtol 1e-13; medians of
three runs in turn, one thread, without set-up and output.
"""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import numpy

ORDERS = (None, 8, 10, 12, 14, 16, 18, 20, 22)
TURNS = 3


def final_positions(folder: pathlib.Path, summary: dict) -> numpy.ndarray:
    file = folder / "final_positions.npy"
    return numpy.load(file) if file.exists() else numpy.array(summary["final"]["positions"])


def run(program: str, scene: dict, folder: pathlib.Path) -> tuple:
    """Steps, seconds and final positions."""
    path = folder / "scene.json"
    path.write_text(json.dumps(scene))
    subprocess.run([program, "run", str(path), "--out", str(folder), "--quiet", "--threads", "1"], check=True,
                   stdout=subprocess.DEVNULL)
    summary = json.loads((folder / "summary.json").read_text())
    wall = summary["wall_s"]
    return summary["steps"], wall["total"] - wall["setup"] - wall["output"], final_positions(folder, summary)


def main() -> None:
    program, scene = sys.argv[1], json.loads(pathlib.Path(sys.argv[2]).read_text())
    motion = scene["motion"]
    t_end = float(sys.argv[3]) if len(sys.argv) > 3 else motion["t_end"]
    tolerances = [float(text) for text in sys.argv[4:]] or [1e-3, 1e-6, 1e-9]
    scene.pop("solver", None)
    kept = {key: motion[key] for key in ("start",) if key in motion}

    def with_method(method: str, rtol: float, order: int | None) -> dict:
        chosen = {**kept, "method": method, "rtol": rtol, "t_end": t_end, "output_every": t_end}
        return {**scene, "motion": {**chosen, **({"order": order} if order else {})}}

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        reference = run(program, with_method("taylor", 1e-13, None), folder)[2]
        print(f"{scene['name']}, t_end {t_end} s\n\n| rtol | method | terms | steps | s | error, m |\n|---|---|---|--:|--:|--:|")
        for rtol in tolerances:
            for method, order in [("dop853", None)] + [("taylor", order) for order in ORDERS]:
                runs = [run(program, with_method(method, rtol, order), folder) for _ in range(TURNS)]
                terms = "" if method == "dop853" else order or "own"
                error = numpy.abs(runs[0][2] - reference).max()
                print(f"| {rtol:.0e} | {method} | {terms} | {runs[0][0]} | {statistics.median(r[1] for r in runs):.4f} "
                      f"| {error:.1e} |", flush=True)


if __name__ == "__main__":
    main()
