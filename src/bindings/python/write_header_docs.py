#!/usr/bin/python3
"""Writes a C++ table of what the public headers say of their structs and members, for docstrings.

    write_header_docs.py INCLUDE_FOLDER OUTPUT.cpp
"""

import pathlib
import re
import sys

STRUCT = re.compile(r"^(\s*)(?:struct|class) (?:\[\[nodiscard\]\] )?(?:TANOR_API )?(\w+)(?: \{| :|$)")
MEMBER = re.compile(r"^\s+(?:static constexpr )?[\w:<>, ]+?[\s>](\w+(?:(?: = [^,;]+|\{[^;]*?\})?, \w+)*)(?: = [^;]*|\{[^;]*\})?;\s*(?:///<\s*(.*))?$")


def plain(text: str) -> str:
    return re.sub(r"\s+", " ", text.replace("`", "")).strip()


def docs_of(lines: list[str]) -> dict[str, str]:
    """{"Rods": …, "Rods.length": …} of one header; nested structs count as members of none."""
    docs: dict[str, str] = {}
    above: list[str] = []
    struct, last = "", []
    for line in lines:
        text = line.strip()
        if text.startswith("///<"):
            for name in last:
                docs[name] += " " + text[4:].strip()
        elif text.startswith("///"):
            above.append(text[3:].strip())
            continue
        elif match := STRUCT.match(line):
            struct = match[2]
            if above:
                docs.setdefault(struct, " ".join(above))
        elif struct and "(" not in line.split("///<")[0] and (match := MEMBER.match(line)):
            names = re.findall(r"(\w+)(?: = [^,;]+|\{[^;]*?\})?(?:, |$)", match[1])
            said = " ".join([*above, match[2] or ""]).strip()
            last = [f"{struct}.{name}" for name in names]
            for name in last:
                docs[name] = said
        above = []
    return {name: plain(text) for name, text in docs.items() if plain(text)}


def main(include: str, output: str) -> None:
    docs: dict[str, str] = {}
    for header in sorted(pathlib.Path(include).rglob("*.hpp")):
        for name, text in docs_of(header.read_text(encoding="utf-8").splitlines()).items():
            docs.setdefault(name, text)
    rows = "\n".join(f'    {{"{name}", R"doc({text})doc"}},' for name, text in sorted(docs.items()))
    pathlib.Path(output).write_text(f"""// Made by write_header_docs.py.
#include "python/header_docs.hpp"

#include <map>

std::string tanor::python::header_doc(std::string_view name) {{
  static const std::map<std::string_view, const char*> docs = {{
{rows}
  }};
  const auto found = docs.find(name);
  return found == docs.end() ? "" : found->second;
}}
""", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
