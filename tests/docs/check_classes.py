#!/usr/bin/python3
"""Fails where a class of include/ or src/ has more than 40 functions or 20 data members.

    check_classes.py [ROOT]        check the tree at ROOT (default: this repository)
    check_classes.py --self-test   prove that classes are counted as they should be

Counted is what a class declares in its own braces: each overload, constructor and operator is a function, and each name
in `double a, b;` is a data member. Left out are static data, friends, types and aliases, and what bases bring; types
inside a class are classes of their own. The text is read without a compiler, so that macros are not expanded and both
branches of an #if count.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_FUNCTIONS, MOST_DATA = 40, 20

NOT_CODE = re.compile(
    r"""//[^\n]*|/\*.*?\*/|R"\(.*?\)"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-zA-Z_])'(?:\\.|[^'\\\n])+'""", re.S)
PREPROCESSOR = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.M)
ATTRIBUTE = re.compile(r"\[\[.*?\]\]|\b(?:alignas|decltype|__attribute__)\s*\((?:[^()]|\([^()]*\))*\)", re.S)
HEAD = re.compile(
    r"\b(?:class|struct|union)\b((?:[^;{}()=<>]|<[^;{}()]*>|\[\[[^]]*\]\]|alignas\([^)]*\))*)\{")
TEMPLATE = r"(?:template\s*<.*?>\s*)?"
TYPE = re.compile(TEMPLATE + r"(?:typedef\s+)?(?:class|struct|union|enum)\b", re.S)
NO_MEMBER = re.compile(TEMPLATE + r"(?:using|typedef|friend|static_assert)\b", re.S)
STATIC = re.compile(r"(?:(?:inline|constexpr)\s+)*static\b")
POINTER_TO_FUNCTION = re.compile(r"\(\s*[*&]\s*\w*\s*\)\s*\([^()]*\)")
ACCESS = re.compile(r"^\s*(?:public|protected|private)\s*:(?!:)")
PAIRS = {"(": ")", "[": "]", "{": "}", "<": ">"}


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def strip(text):
    """The text with blanks in place of comments, literals and preprocessor lines; everything stays where it is."""
    return PREPROCESSOR.sub(blank, NOT_CODE.sub(blank, text))


def end_of_braces(text, begin):
    """The position behind the brace that closes the one at `begin`."""
    depth = 0
    for brace in re.finditer(r"[{}]", text[begin:]):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return begin + brace.end()
    raise ValueError("a brace is not closed")


def without(text, opening):
    """The text without what stands between these parentheses, they included."""
    depth, result = 0, ""
    for sign in text:
        depth += sign == opening
        if depth == 0:
            result += sign
        depth -= sign == PAIRS[opening] and depth > 0
    return result


def head_of(declaration):
    """A declaration up to its initial value or body, without attributes and arguments of templates."""
    if re.search(r"\boperator\b", declaration):
        return "operator()"
    return re.split(r"[={]", without(ATTRIBUTE.sub(" ", declaration), "<"))[0]


def split_declarations(body):
    """The declarations of a class. Each ends at a semicolon or behind the body of a function; braces are emptied."""
    result, declaration, position = [], "", 0
    while position < len(body):
        sign = body[position]
        ends = sign == ";"
        if sign == "{":
            position = end_of_braces(body, position)
            declaration += "{}"
            # Behind `b_{1}` in a constructor's list, another one or the body follows.
            is_function = "(" in head_of(declaration) and not TYPE.match(declaration.strip())
            ends = is_function and body[position:].lstrip()[:1] not in (";", ",", "{")
        else:
            declaration = ACCESS.sub("", declaration + (sign if not ends else ""))
            position += 1
        if ends:
            result.append(declaration.strip())
            declaration = ""
    return [each for each in result if each]


def count_members(declaration):
    """The numbers of functions and of data members that a declaration brings."""
    if TYPE.match(declaration):  # it may declare members behind its braces
        behind = declaration.split("{}", 1)[1] if "{}" in declaration else ""
        declaration = "int " + behind if behind.strip() else ""
    if not declaration or NO_MEMBER.match(declaration):
        return 0, 0
    if "(" in POINTER_TO_FUNCTION.sub(" ", head_of(declaration)):
        return 1, 0
    if STATIC.match(declaration):
        return 0, 0
    for opening in PAIRS:
        declaration = without(declaration, opening)
    return 0, declaration.count(",") + 1


def count_classes(text):
    """The classes that a text defines, as (position, name, functions, data members)."""
    text = strip(text)
    for match in HEAD.finditer(text):
        if re.search(r"(\benum|[<,])\s*$", text[: match.start()]):
            continue  # an enumeration, or `template <class X>`
        head = re.sub(r"\[\[[^]]*\]\]|alignas\([^)]*\)|\b(?:TANOR_\w+|final)\b", " ", match[1])
        name = re.split(r"(?<!:):(?!:)", head)[0].strip() or "a class without a name"
        body = text[match.end() : end_of_braces(text, match.end() - 1) - 1]
        counts = [count_members(declaration) for declaration in split_declarations(body)]
        yield match.start(), name, sum(functions for functions, _ in counts), sum(data for _, data in counts)


def find_large_classes(root):
    """One line for each class that is too large."""
    result, num_classes = [], 0
    files = [file for folder in ("include", "src") for file in sorted((root / folder).rglob("*"))]
    for path in (file for file in files if file.suffix in {".h", ".hpp", ".cpp"}):
        text = path.read_text()
        for position, name, functions, data in count_classes(text):
            num_classes += 1
            if functions > MOST_FUNCTIONS or data > MOST_DATA:
                where = f"{path.relative_to(root)}:{text.count(chr(10), 0, position) + 1}"
                result.append(f"{where}: {name} has {functions} functions and {data} data members")
    return result if num_classes > 0 else [f"{root}: no class is there"]


CASES = [
    ("struct A { int a, b = f(1, 2); double c[3]; std::map<int, double> d{{1, 2.0}}; };", ["A", 0, 4]),
    ("class A final : public B<int> { public: A() : a_{1}, b_(2) {} explicit A(int); ~A() = default; int a_; };",
     ["A", 3, 1]),
    ("struct A { static constexpr int most = 3; static void f(); using B = int; friend class C; enum D { x, y }; };",
     ["A", 1, 0]),
    ("class TANOR_API A { std::function<void(int)> f; void (*g)(int, int) = nullptr; bool operator<(A) const; };",
     ["A", 1, 2]),
    ("struct [[nodiscard]] A { // int no;\n template <class T, class U> void f(T a) { int c; if (c) {} } int d; };",
     ["A", 1, 1]),
    ("struct A { enum class B { x, y } b = B::x; auto operator<=>(const A&) const = default; int f() const; };",
     ["A", 2, 1]),
    ("struct A { struct B { int a; void f(); }; B b; };", ["A", 0, 1, "B", 1, 1]),
    ("template <class T> struct A<std::vector<T>> { T a : 3; alignas(64) std::array<T, 2> b; };",
     ["A<std::vector<T>>", 0, 2]),
    ("enum class A { x, y }; class B; void f() { struct C { int a; }; }", ["C", 0, 1]),
]


def self_test():
    wrong = 0
    for text, expected in CASES:
        found = [each for _, *numbers in count_classes(text) for each in numbers]
        if found != expected:
            wrong += 1
            print(f"{text}: {found}, not {expected}")
    print(f"check_classes self-test: {len(CASES)} cases, {wrong} wrong")
    return 1 if wrong else 0


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    found = find_large_classes(pathlib.Path(arguments[0]) if arguments else ROOT)
    print("\n".join(found) if found else f"classes: at most {MOST_FUNCTIONS} functions and {MOST_DATA} data members")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
