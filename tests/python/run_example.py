#!/usr/bin/python3
"""Runs an example and looks at its picture: run_example.py EXAMPLE.py PICTURE.png. Exit code 77: no matplotlib."""

import importlib.util
import pathlib
import subprocess
import sys


def main(example: str, picture: str) -> int:
    if importlib.util.find_spec("matplotlib") is None:
        print("skipped: matplotlib is not installed (python3-matplotlib)")
        return 77
    pathlib.Path(picture).unlink(missing_ok=True)
    subprocess.run([sys.executable, example, picture], check=True)
    import matplotlib.image

    pixels = matplotlib.image.imread(picture)
    colours = {tuple(pixel) for pixel in pixels.reshape(-1, pixels.shape[2]).tolist()}
    if min(pixels.shape[:2]) < 300 or len(colours) < 20:
        print(f"{picture} is no drawing: {pixels.shape}, {len(colours)} colours")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
