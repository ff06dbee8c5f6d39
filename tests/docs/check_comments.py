#!/usr/bin/python3
"""Fails where a comment of the sources is no sentence: it begins with a preposition or a bare value. Comments that stand
behind code, beside what they are about, may be short.

It also fails where a source has more than 500 lines."""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FRAGMENT = re.compile(r"(Of|From|Whether|That|What|Beside|Instead|Likewise)\b|(False|True|Null|None|Empty|Else|Not)[:,]")


def find_blocks(text):
    """(line, words) of each comment that has lines of its own."""
    block, kind, first = [], "", 0
    for number, line in enumerate([*text.splitlines(), ""], start=1):
        found = re.match(r"\s*(///?)(?!/)<?\s?(.*)", line)
        if found and (not block or found[1] == kind):
            kind, first = found[1], first if block else number
            block.append(found[2])
            continue
        if block:
            yield first, " ".join(block).strip()
        block = [found[2]] if found else []
        kind, first = (found[1], number) if found else ("", 0)


def list_sources():
    """Returns the paths of all sources that are under version control, or of all that are there without git."""
    folders = ["src", "include", "tests", "bench", "scripts", "examples"]
    command = ["git", "ls-files", "--", *folders]
    try:
        names = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
        paths = [ROOT / name for name in names]
    except (OSError, subprocess.CalledProcessError):
        paths = [path for folder in folders for path in (ROOT / folder).rglob("*")]
    return [path for path in paths if path.suffix in {".hpp", ".cpp", ".h", ".py", ".ts", ".mjs"} and path.exists()]


def find_long_files(most_lines=500):
    """Returns a finding for each source of more lines than these."""
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in sorted(list_sources())}
    assert len(lengths) > 500, "the sources are not where they are looked for"
    return [f"{name}: {lines} lines; split it by subject" for name, lines in lengths.items() if lines > most_lines]


def main():
    wrong = find_long_files()
    folders = ["src", "tests", "bench"]
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.[ch]pp")]
    for path in sorted([*(ROOT / "include").rglob("*.h*"), *sources]):
        for line, words in find_blocks(path.read_text()):
            text = re.sub(r"^\\\w+\s*", "", words)
            if FRAGMENT.match(text):
                wrong.append(f"{path.relative_to(ROOT)}:{line}: {words[:90]}")
    print("\n".join(wrong), end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
