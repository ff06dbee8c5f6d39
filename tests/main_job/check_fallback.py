#!/usr/bin/python3
"""check_fallback.py MAIN_JOB PROGRAM FOLDER: the main job without the real melt goes on with a generated one."""

import json
import os
import pathlib
import shlex
import subprocess
import sys


def run(main_job: str, program: pathlib.Path, out: pathlib.Path, **variables: str) -> subprocess.CompletedProcess:
    environment = {key: value for key, value in os.environ.items() if key != "CI"}
    return subprocess.run([main_job, program, out], env=environment | {"TANOR_MELT": "generated"} | variables,
                          stderr=subprocess.PIPE, text=True)


def main() -> None:
    main_job, program, folder = sys.argv[1:]
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    short = folder / "short"  # the program, with an early end: seconds instead of a minute
    short.write_text(f'#!/bin/sh\nexec {shlex.quote(program)} "$@" --t-end 0.04\n')
    short.chmod(0o755)

    insisting = run(main_job, short, folder / "insisting", CI="true")
    assert insisting.returncode == 1 and "CI insists" in insisting.stderr, insisting

    ended = run(main_job, short, folder / "out")
    assert ended.returncode == 0, ended
    assert "NOT available" in ended.stderr, ended
    summary = json.loads((folder / "out" / "summary.json").read_text())
    assert summary["source"] == "generate: melt", summary["source"]
    assert summary["points"] == 32000, summary["points"]
    assert summary["t_reached"] == 0.04, summary["t_reached"]


if __name__ == "__main__":
    main()
