#!/usr/bin/python3
"""check_digits.py PROGRAM EXAMPLES FOLDER: runs give the digits of the table in README.md of the examples."""

import json
import pathlib
import re
import subprocess
import sys

program, examples, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
ROW = re.compile(r"^\| `(\w+)` \| (?:`([^`]*)`)? ?\| ([^|:]+)[^|]* \| (\S+) \| (\S+) \|$", re.MULTILINE)


def run(scene: str, options: str) -> dict:
    out = folder / scene
    subprocess.run([program, "run", examples / f"{scene}.json", "--out", out, "--quiet", *options.split()], check=True)
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


summaries: dict = {}
rows = ROW.findall((examples / "README.md").read_text(encoding="utf-8"))
wrong = 0
for scene, options, path, digits, allowed in rows:
    if (scene, options) not in summaries:
        summaries[scene, options] = run(scene, options)
    value = summaries[scene, options]
    for key in path.split():
        value = value[int(key) if isinstance(value, list) else key]
    error = abs(value - float(digits))
    is_right = error <= float(allowed)
    wrong += not is_right
    print(f"{'ok   ' if is_right else 'WRONG'} {scene}: {path} is {value}, {error:.1e} from {digits}")
sys.exit(1 if wrong or len(rows) < 9 else 0)
