#!/usr/bin/python3
"""Fails where a page names a file, a test or a function that is not there, or looks for a function in a wrong file, and
where <tanor/tanor.hpp> neither includes a public header nor names it as one that stands apart, where a source asks
for a kind that the table of such places in contributing.md leaves out, where README.md lacks a kind or a method, and
where methods.md and src/core/motion/singular_thresholds.hpp differ in a threshold.

Paths (`src/…`, `tests/…`, `docs/…`), tests (`Suite.Name`, `Suite.Begin…`) and functions (`Class::function`) in backticks;
a name that a file follows (`function`, `src/…`) is in that file.
"""
import pathlib
import re
import sys
from fractions import Fraction

ROOT = pathlib.Path(__file__).resolve().parents[2]


def read(folders, endings):
    return "\n".join(
        path.read_text() for folder in folders for path in sorted((ROOT / folder).rglob("*")) if path.suffix in endings
    )


def find_headers_apart():
    """The public headers that <tanor/tanor.hpp> does not bring, directly or through others, and does not name."""
    included, new = set(), {"tanor/tanor.hpp"}
    while new:
        header = new.pop()
        included.add(header)
        if (path := ROOT / "include" / header).exists():
            new |= set(re.findall(r"#include <(tanor/[\w./]+)>", path.read_text())) - included
    words = (ROOT / "include/tanor/tanor.hpp").read_text()
    headers = {str(path.relative_to(ROOT / "include")) for path in (ROOT / "include").rglob("*.h*")}
    return sorted(header for header in headers - included if f"<{header}>" not in words)


def find_files_that_name_kinds():
    """Sources beside src/core/kinds that name a kind and that the table of contributing.md leaves out."""
    kinds = set(re.findall(r"struct KindOf<(\w+)>", read(["include/tanor/kinds"], {".hpp"})))
    kinds = {kind for kind in kinds if not kind.startswith("User") and kind != "Potential"}
    page = (ROOT / "docs/contributing.md").read_text()
    rows = re.findall(r"^\| (`src/.*?) \|", page.split("These places name a kind")[1], flags=re.M)
    listed = tuple(word for row in rows for word in re.findall(r"`(src/[^`]+)`", row))
    result = []
    for path in sorted((ROOT / "src").rglob("*.[ch]pp")):
        name = str(path.relative_to(ROOT))
        code = re.sub(r"//.*|\"[^\"\n]*\"", "", path.read_text())
        named = re.search(rf"\b(get_if|get|holds_alternative|is_same_v<\w+,)\W*({'|'.join(kinds)})\b", code)
        if named and not name.startswith(("src/core/kinds/", *listed)):
            result.append(name)
    return result


def find_kinds_missing_in_readme():
    """Names of kinds and methods that their row of README's table leaves out, as (row, name)."""
    page = (ROOT / "README.md").read_text()
    folders = {"constraints": "constraint", "coordinates": "coordinates", "forces": "force", "friction": "friction"}
    names = {
        row: re.findall(r'string_view name = "([^"]+)"', read([f"include/tanor/kinds/{folder}"], {".hpp"}))
        for row, folder in folders.items()
    }
    table = (ROOT / "src/core/motion/methods.cpp").read_text()
    names["methods"] = [name for name in re.findall(r'\{Method::\w+, "([^"]+)"', table) if name != "auto"]
    in_words = {"formula": ["formula", "your own"], "potential": ["any energy"]}  # for readers
    result = []
    for row, of_row in names.items():
        found = re.search(rf"^\| {row} \|(.*?)\|", page, flags=re.M)
        words = found[1].lower() if found else ""
        assert of_row, row
        for name in of_row:
            if not any(re.search(rf"\b{re.escape(word)}s?\b", words) for word in in_words.get(name, [name])):
                result.append((row, name))
    return result


def find_thresholds_that_differ():
    """Thresholds of singular configurations whose value in methods.md is not that of the source, as phrases."""
    source = (ROOT / "src/core/motion/singular_thresholds.hpp").read_text()
    in_source = {
        name: float(value)
        for declaration in re.findall(r"^(?:inline )?constexpr \w+ ([^;]+);", source, flags=re.M)
        for name, value in re.findall(r"(\w+) = ([^,]+)", declaration)
    }
    page = (ROOT / "docs/methods.md").read_text().split("**Thresholds.**")[1]
    table = re.search(r"^\| name \| value \|.*?\n\|[-|]+\n(.*?)\n\n", page, flags=re.M | re.S)[1]
    in_table = {}
    for row in table.splitlines():
        names, values = row.split(" | ")[:2]
        numbers = [float(Fraction(value.split()[0])) for value in values.split(", ")]  # a unit may follow
        in_table |= dict(zip(re.findall(r"`(\w+)`", names), numbers, strict=True))
    assert in_source, "no threshold was read"
    return [
        f"the threshold {name}: {in_source.get(name, 'none')} in the source, {in_table.get(name, 'none')} in the table"
        for name in sorted(in_source.keys() | in_table.keys())
        if in_source.get(name) != in_table.get(name)
    ]


def main():
    tests = {
        (suite, name)
        for suite, name in re.findall(
            r"(?:TEST|TEST_F|TEST_P|TYPED_TEST|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+),\s*(\w+)",
            read(["tests"], {".cpp", ".hpp"}),
        )
    }
    code = read(["src", "include", "bench", "tests"], {".cpp", ".hpp"})
    missing = []
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
        for word in re.findall(r"`([^`\n]+)`", text):
            if re.fullmatch(r"(src|tests|docs|include|bench|scripts|examples|cmake)/[\w./-]*\w", word):
                if not (ROOT / word).exists():
                    missing.append((page.name, word))
            elif found := re.fullmatch(r"([A-Z]\w+)\.((?:[A-Z]\w*)?)(…?)", word):
                suite, name, is_begin = found.groups()
                names = [n for s, n in tests if s == suite]
                if not any(n.startswith(name) if is_begin else n == name for n in names):
                    missing.append((page.name, word))
            elif found := re.fullmatch(r"(\w+)::(\w+)", word):
                owner, name = found.groups()
                if owner != "std" and not (re.search(rf"\b{owner}\b", code) and re.search(rf"\b{name}\b", code)):
                    missing.append((page.name, word))
        for name, path in re.findall(r"`(?:\w+(?:<\w+>)?::)*(\w+)`, `((?:src|include|tests)/[\w./-]+\.[ch]pp)`", text):
            if (ROOT / path).exists() and not re.search(rf"\b{name}\b", (ROOT / path).read_text()):
                missing.append((page.name, f"{name} in {path}"))
    missing += [("tanor.hpp", header) for header in find_headers_apart()]
    missing += [("contributing.md", f"the kind that {file} names") for file in find_files_that_name_kinds()]
    missing += [("README.md", f"{name} of the {row}") for row, name in find_kinds_missing_in_readme()]
    for page, word in missing:
        print(f"{page}: {word} is not there")
    different = find_thresholds_that_differ()
    for phrase in different:
        print(f"methods.md: {phrase}")
    return 1 if missing or different else 0


if __name__ == "__main__":
    sys.exit(main())
