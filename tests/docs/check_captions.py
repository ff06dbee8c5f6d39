#!/usr/bin/python3
"""Each moving picture of README.md and examples/README.md is there. In examples/README.md it has its error and its seconds
under it, to which the caption in README.md points.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def main() -> int:
    wrong, count = [], 0
    for page in ("README.md", "examples/README.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        for link, caption in re.findall(r"!\[[^]]*\]\(([^)]*\.webp)\)\n\n\*([^*]*)\*\n", text):
            count += 1
            if not (ROOT / page).parent.joinpath(link).exists():
                wrong.append(f"{page}: there is no {link}")
            if page == "README.md":
                if "(examples/README.md)" not in caption:
                    wrong.append(f"{page}: {link} does not say where its error stands: {caption}")
            elif not re.search(r"error [0-9.e+-]+ m\b", caption) or not re.search(r"\b[0-9.e+-]+ s on [0-9]+ threads", caption):
                wrong.append(f"{page}: {link} has no error or no seconds: {caption}")
    if count < 6:
        wrong.append(f"only {count} moving pictures have a caption")
    print("\n".join(wrong), file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
