#!/usr/bin/python3
"""What does the shared library show? Only functions and classes of namespace tanor that a public header marks with
TANOR_API, and the C interface tn_*. And it must show InputError's type information, or users cannot catch it.

    check_exports.py LIBTANOR_SO INCLUDE_DIR [NM]
    check_exports.py --self-test
"""

import pathlib
import re
import subprocess
import sys

NEEDED = ["typeinfo for tanor::InputError", "vtable for tanor::InputError"]


def marked_names(headers: list[str]) -> set[str]:
    """X of `class TANOR_API X`, and f of `TANOR_API type f(`, be it a function or a member that is marked by itself."""
    text = "\n".join(headers)
    classes = re.findall(r"\b(?:class|struct)\s+TANOR_API\s+(\w+)", text)
    functions = re.findall(r"^\s*TANOR_API\s[^(;]*?(\w+)\(", text, re.MULTILINE)
    return set(classes) | set(functions)


def wrong_symbol(symbol: str, marked: set[str]) -> str | None:
    """Why this demangled symbol should be hidden."""
    if re.fullmatch(r"tn_\w+", symbol):
        return None
    about, name = re.fullmatch(r"((?:typeinfo|typeinfo name|vtable|VTT) for )?(.*)", symbol).groups()
    path = re.sub(r"\[abi:\w+\]|[(<].*", "", name).split("::")  # tanor::X::f(double) const -> tanor, X, f
    if path[0] != "tanor" or len(path) < 2:
        return "outside namespace tanor"
    if not marked & {path[1], "::".join(path[2:])}:
        return "not marked TANOR_API in a public header"
    if len(path) > (2 if about else 3):
        # A nested class inherits the visibility of its outer one; the attribute at its definition hides it.
        return 'private part: define it as `struct __attribute__((visibility("hidden"))) Outer::Inner`'
    return None


def complaints(symbols: list[str], marked: set[str]) -> list[str]:
    found = [f"{symbol}: {rule}" for symbol in symbols if (rule := wrong_symbol(symbol, marked))]
    return found + [f"missing: {symbol}" for symbol in NEEDED if symbol not in symbols]


def self_test() -> int:
    marked = marked_names(["class TANOR_API InputError : public X {", "struct TANOR_API System {",
                           "TANOR_API std::size_t num_equations(const System& system);",
                           "struct [[nodiscard]] Certificate {\n  TANOR_API bool passed() const;"])
    right = NEEDED + ["tanor::num_equations(tanor::System const&)", "tanor::System::f[abi:cxx11](std::vector<a::b>)",
                      "tanor::InputError::~InputError()", "tn_system_create", "tanor::Certificate::passed() const"]
    wrong = ["std::vector<tanor::System, std::allocator<tanor::System> >::~vector()", "typeinfo for std::exception",
             "tanor::validate(tanor::System const&)", "tanor::System::Inner::f()", "vtable for tanor::System::Inner",
             "cholmod_start", "typeinfo for tanor::InternalError", "tanor::Certificate::verify() const"]
    missed = [symbol for symbol in wrong if len(complaints(right + [symbol], marked)) != 1]
    missed += complaints(right, marked)
    missed += [] if len(complaints(right[1:], marked)) == 1 else ["a missing typeinfo"]
    print(f"check_exports self-test: {len(right) + len(wrong) + 1} cases, {len(missed)} wrong", *missed, sep="\n")
    return 1 if missed else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--self-test"]:
        return self_test()
    library, include_dir, *nm = arguments
    lines = subprocess.run([*(nm or ["nm"]), "-D", "--defined-only", "--demangle", library],
                           check=True, capture_output=True, text=True).stdout.splitlines()
    symbols = sorted({re.sub(r"^[0-9a-f]* *\w ", "", line) for line in lines})
    headers = [file.read_text(encoding="utf-8") for file in pathlib.Path(include_dir, "tanor").rglob("*.h*")]
    found = complaints(symbols, marked_names(headers))
    print("\n".join(found))
    print(f"{library}: {len(symbols)} names shown, {len(found)} wrong")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
