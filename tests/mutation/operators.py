"""Mutants of a source text, C++ or Python: one small change in one line each. Lines are those that scripts/format leaves."""

import ast
import re

COMMENTS_AND_STRINGS = {
    ".cpp": re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])'|^[ \t]*#[^\n]*", re.S | re.M),
    ".py": re.compile(r"#[^\n]*|\"\"\".*?\"\"\"|'''.*?'''|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.S)}

# What stands between the blanks of a binary operator (templates and pointers have none), and what replaces it.
SWAPS = {"<": ["<=", ">="], ">": [">=", "<="], "<=": ["<", ">"], ">=": [">", "<"], "==": ["!="], "!=": ["=="],
         "+": ["-"], "-": ["+"], "*": ["/"], "/": ["*"], "+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="],
         "&&": ["||"], "||": ["&&"], "and": ["or"], "or": ["and"]}
BINARY = re.compile(r"(?<= )(" + "|".join(re.escape(word) for word in sorted(SWAPS, key=len, reverse=True)) + r")(?= )")
WORDS = {"true": "false", "false": "true", "True": "False", "False": "True", "min": "max", "max": "min"}
WORD = re.compile(r"\b(true|false|True|False|(?:min|max)(?=\())")
NEGATION, SIGN = r"!(?=[\w(*])|\bnot (?!in\b)", r"(?:(?<=[(\[{])|(?<=[(\[{,?:=] )|(?<=return )|(?<=else ))-(?=[\w(])"
REMOVED = re.compile(f"{NEGATION}|{SIGN}")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:e[-+]?\d+)?(?![\w.])")

CPP_IF = re.compile(r"^\s*(?:\} )?(?:else )?if (\()")
PYTHON_IF = re.compile(r"(?:^\s*(?:el)?if (?=.*:$)|\bif (?=.* else ))(.+?)(?=:$| else )")
# An expression that is a statement: an assignment, a call or a throw, not a declaration.
CPP_STATEMENT = re.compile(r"^\s*(?:throw .*|(?!return\b|static_assert\b)[(*]*[A-Za-z_][\w:]*(?:\(|\.|->|\[| (?:[-+*/|&]|<<|>>)?= "
                           r"|\+\+|--).*);$")
PYTHON_STATEMENTS = (ast.Expr, ast.Assign, ast.AugAssign, ast.Raise, ast.Delete)


def without_words(text, suffix):
    """The text with blanks in place of comments, strings and directives."""
    return COMMENTS_AND_STRINGS[suffix].sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def closing(line, begin):
    """Where the bracket at `begin` is closed, or -1."""
    depth = 0
    for at in range(begin, len(line)):
        depth += (line[at] == "(") - (line[at] == ")")
        if depth == 0:
            return at
    return -1


def changes_in(line, suffix):
    """(begin, end, other text) of each change within a line of code."""
    for found in BINARY.finditer(line):
        yield from ((*found.span(), other) for other in SWAPS[found[0]])
    for found in WORD.finditer(line):
        yield *found.span(), WORDS[found[0]]
    for found in REMOVED.finditer(line):
        yield *found.span(), ""
    for found in NUMBER.finditer(line):
        point = "" if found[0].isdigit() else ".0"
        yield from ((*found.span(), other + point) for other in ("0", "1", "-1") if float(other) != float(found[0]))
    if suffix == ".cpp":
        found = CPP_IF.search(line)
        if found and (end := closing(line, found.start(1))) > 0:
            inside = line[found.end(1):end]
            if not re.search(r";|\w \*?&?\w+ = ", inside):  # these declare something
                yield found.end(1), end, "!({})"
    else:
        for found in PYTHON_IF.finditer(line.rstrip()):
            if closing(f"({found[1]})", 0) == len(found[1]) + 1:
                yield *found.span(1), "not ({})"


def statements(lines, code, suffix):
    """The numbers of the lines that are one whole statement, which can go."""
    if suffix == ".py":
        nodes = [node for node in ast.walk(ast.parse("\n".join(lines))) if isinstance(node, PYTHON_STATEMENTS)]
        return {node.lineno for node in nodes if node.lineno == node.end_lineno and not lines[node.lineno - 1][:node.col_offset].strip()
                and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))}
    found, before = set(), ";"
    for number, line in enumerate(code, 1):
        whole = CPP_STATEMENT.match(line.rstrip()) and all(line.count(a) == line.count(b) for a, b in ("()", "{}"))
        if whole and (before[-1] in ";{}:)" or before.endswith("else")):
            found.add(number)
        before = line.rstrip() or before
    return found


def mutants(text, suffix):
    """(line number, line that replaces it) of every mutant of a text, in order; `suffix` is ".cpp" or ".py"."""
    lines, code = text.splitlines(), without_words(text, suffix).splitlines()
    made = []
    for number, (line, bare) in enumerate(zip(lines, code), 1):
        for begin, end, other in changes_in(bare, suffix):
            made.append((number, line[:begin] + other.format(line[begin:end]) + line[end:]))
    for number in statements(lines, code, suffix):
        indent = lines[number - 1][:len(lines[number - 1]) - len(lines[number - 1].lstrip())]
        made.append((number, indent + ("pass" if suffix == ".py" else ";")))
    return sorted(set(made))
