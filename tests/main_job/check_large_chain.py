#!/usr/bin/python3
"""check_large_chain.py PROGRAM FOLDER: `tanor solve` on a crumpled chain of a million rods: exact, and in little memory."""

import json
import pathlib
import resource
import subprocess
import sys

SCENE = {
    "tanor_scene": 1,
    "generate": {"kind": "melt", "chains": 1, "count": 1_000_000},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
}
MOST_MEMORY = 1.5e9  # bytes
WORST_RESIDUAL = 1e-9


def main() -> None:
    program, folder = sys.argv[1:]
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    scene, answer = folder / "chain.json", folder / "answer.json"
    scene.write_text(json.dumps(SCENE))

    subprocess.run([program, "solve", scene, "--out", answer], check=True)

    memory = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    residual = json.loads(answer.read_text())["certificate"]["residual"]
    print(f"memory {memory:.3g} bytes, residual {residual:.1e}")
    assert memory <= MOST_MEMORY, memory
    assert residual <= WORST_RESIDUAL, residual


if __name__ == "__main__":
    main()
