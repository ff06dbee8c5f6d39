#!/usr/bin/python3
"""check_picture.py ROOT RUN_FOLDER PICTURE: README's command for examples/net.svg makes the picture that is there.

In the first half, the frames until t = 0.2 s, coordinates may differ by the last digit that is written. Later ones the
motion itself makes of roundings, which compilers choose: there it must be as many rods. A rod whose tension changes by a
rounding may change its colour.
"""

import pathlib
import re
import shlex
import subprocess
import sys

root, run, picture = (pathlib.Path(argument) for argument in sys.argv[1:])
command = shlex.split(re.search(r"^scripts/draw_run\.py .*$", (root / "README.md").read_text(), re.MULTILINE)[0])
subprocess.run([sys.executable, root / command[0], run, picture, *command[3:]], check=True)


def numbers(path: pathlib.Path) -> list:
    return [float(number) for number in re.findall(r"[-+]?\d+\.\d+", re.sub(r"#\w+", "", path.read_text()))]


drawn, kept = numbers(picture), numbers(root / command[2])
if len(drawn) != len(kept):
    sys.exit(f"{len(drawn)} numbers are drawn, {len(kept)} are in {command[2]}")
half = len(drawn) // 2
largest = max(abs(a - b) for a, b in zip(drawn[:half], kept[:half]))
print(f"{half} coordinates differ by at most {largest:.2f} of 900")
sys.exit(0 if largest <= 0.15 else 1)
