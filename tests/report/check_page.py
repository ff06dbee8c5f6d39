#!/usr/bin/python3
"""check_page.py PROGRAM FOLDER NODE: runs scenes with --report and tries each page in headless Chromium (page.mjs).

Texts that would break out of the page are tried too. 77, a skip, where Chromium is missing.
"""

import json
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOSTILE = "</script><script>throw new Error('broke out')</script><!--<script>"


def hostile_scene(folder: pathlib.Path) -> pathlib.Path:
    """The pendulum under names that are HTML."""
    scene = json.loads((ROOT / "examples/pendulum.json").read_text())
    scene["name"] = HOSTILE
    path = folder / "hostile.json"
    path.write_text(json.dumps(scene))
    return path


def main() -> int:
    program, folder, node = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not chromium:
        print("skipped: there is no chromium")
        return 77
    folder.mkdir(parents=True, exist_ok=True)
    scenes = [ROOT / "examples" / f"{name}.json" for name in ("pendulum", "net", "rough_hoop", "melt_generated")]
    for scene in [*scenes, hostile_scene(folder)]:
        out = folder / scene.stem
        subprocess.run([program, "run", str(scene), "--out", str(out), "--quiet", "--report",
                        *(["--t-end", "0.1"] if scene.stem == "melt_generated" else [])], check=True)
        print(scene.stem, flush=True)
        tried = subprocess.run([node, str(ROOT / "tests/report/page.mjs"), str(out / "report.html"),
                                str(out / "summary.json"), chromium], check=False)
        if tried.returncode:
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
