"""The ways in which a line of C++ or GLSL is broken. Pure: a file's text goes in, mutations come out.

They work on text, line by line, and rely on clang-format: binary operators stand between spaces, template brackets do
not. What they make need not compile.
"""
import dataclasses
import re


@dataclasses.dataclass(frozen=True)
class Mutation:
    file: str      # relative to the tree's root
    line: int      # counted from 1
    operator: str
    before: str    # the whole line
    after: str


COMMENT_OR_LITERAL = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])\'', re.S)
SKIPPED = re.compile(r"\s*(#|virtual\b.* = 0;|(template|using|namespace|friend|static_assert)\b)"
                     r"|.*(\bassert\(|\blog::\w+\()")

RELATIONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "<<": ">>", ">>": "<<", "&": "|", "|": "&"}
ASSIGNMENTS = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "&=": "|=", "|=": "&="}
STEPS = {"++": "--", "--": "++"}
LOGIC = {"&&": "||", "||": "&&"}
TRUTHS = {"true": "false", "false": "true"}
EXTREMES = {"min": "max", "max": "min"}

NUMBER = re.compile(r"(?<![\w.'])(0x[0-9a-fA-F]+|\d[\d']*(?:\.\d+)?)(e[+-]?\d+)?([a-zA-Z]*)\b")
CONDITION = re.compile(r"\b(?:if|while) (?:constexpr )?(?=\()")
BLOCK = re.compile(r"(?:if|for|while) (?:constexpr )?(?=\()")
STATEMENT_HEAD = re.compile(r"(\+\+|--)?\*?[A-Za-z_][\w.:\[\]>*+-]*;?")
BEFORE_STATEMENT = re.compile(r"(.*[;{})]|\s*(case\b.*|default|public|private|protected):|\s*)$")


def code_of(text):
    """The lines of a file with comments blanked and literals emptied, every character where it was."""
    def blank(match):
        inside = re.sub(r"[^\n]", " ", match.group())
        return inside if match.group()[0] == "/" else f'"{inside[2:]}"'
    return COMMENT_OR_LITERAL.sub(blank, text).split("\n")


def closing(code, begin):
    """Where the parenthesis that opens at `begin` closes; None if another line closes it."""
    depth = 0
    for at in range(begin, len(code)):
        depth += {"(": 1, ")": -1}.get(code[at], 0)
        if depth == 0:
            return at
    return None


def swaps(code, table, pattern):
    for match in re.finditer(pattern, code):
        if match.group() in table:
            yield code[:match.start()], table[match.group()], match.end()


def other_number(match):
    """n + 1; a duration or a fraction is doubled, as a tuned one that is off by little is no fault."""
    digits, exponent, suffix = match.group(1).replace("'", ""), match.group(2) or "", match.group(3)
    if digits.startswith("0x"):
        return hex(int(digits, 16) + 1) + suffix
    if "." in digits:
        return repr(2 * float(digits) or 1.0) + exponent + suffix
    number = int(digits)
    return str(2 * number or 1 if exponent or suffix in ("s", "ms", "us") else number + 1) + exponent + suffix


def negations(code):
    for match in CONDITION.finditer(code):
        end = closing(code, match.end())
        if end is not None and not re.search(r";|\b(auto|const)\b", code[match.end():end]):
            yield code[:match.end()], f"(!{code[match.end():end + 1]})", end + 1
    for match in re.finditer(r"!(?=[\w(])", code):
        yield code[:match.start()], "", match.end()


def deletions(code, before, after):
    """The line without its statement, where it holds a whole one that declares nothing and returns no value."""
    statement = code.strip()
    block = BLOCK.match(statement)
    if block:
        end = closing(statement, block.end())
        whole = (end is not None and re.fullmatch(r"\s+\S.*;", statement[end + 1:])
                 and not after.strip().startswith("else"))
    else:
        head = re.split(r" (?:[-+*/%&|^]|<<|>>)?= |\(", statement, maxsplit=1)[0]
        whole = (statement.endswith(";") and statement.count("(") == statement.count(")")
                 and STATEMENT_HEAD.fullmatch(head))
    if whole and BEFORE_STATEMENT.match(before):
        yield code[:len(code) - len(code.lstrip())], ";", len(code)


def edits(code, before, after):
    """(operator, text before the change, what is there now, where the rest begins)"""
    binary = r"(?<= )[-+*/%&|^<>=!]{1,3}(?= |$)"
    found = {
        "relation": swaps(code, RELATIONS, binary),
        "arithmetic": [*swaps(code, ARITHMETIC, binary), *swaps(code, ASSIGNMENTS, binary),
                       *(swaps(code, STEPS, r"\+\+|--") if "for (" not in code else ())],
        "logic": swaps(code, LOGIC, r"(?<= )(&&|\|\|)(?= |$)"),
        "constant": ((code[:m.start()], other_number(m), m.end()) for m in NUMBER.finditer(code)),
        "negation": negations(code),
        "deletion": deletions(code, before, after),
        "truth": swaps(code, TRUTHS, r"\b(true|false)\b"),
        "extreme": swaps(code, EXTREMES, r"\b(min|max)(?=(_element)?[(<])"),
    }
    return [(operator, *edit) for operator, some in found.items() for edit in some]


def mutations_of(file, text):
    """All mutations of a file."""
    lines, codes, found, open_in_skipped = text.split("\n"), code_of(text), [], 0
    for i, (line, code) in enumerate(zip(lines, codes)):
        if open_in_skipped or SKIPPED.match(code):
            balance = code.count("(") - code.count(")")
            open_in_skipped = max(0, open_in_skipped + balance)
            continue
        after = next((c for c in codes[i + 1:] if c.strip()), "")
        for operator, head, inserted, rest in edits(code, codes[i - 1] if i else "", after):
            broken = line[:len(head)] + inserted + line[rest:]
            found.append(Mutation(file, i + 1, operator, line, broken))
    return found
