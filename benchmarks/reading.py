"""Measures of how this project reads.

`python -m benchmarks.reading` measures its code and its sentences.

Of the package: characters and syntax nodes a line of code, assignments to a tuple and conditional
expressions in 1 000 lines, words of first lines of docstrings. Of each page of the documentation:
words a sentence, and the share of sentences with more than 30.
"""

from __future__ import annotations

import ast
import io
import re
import statistics
import tokenize
from pathlib import Path

ROOT = Path(__file__).parents[1]
LONG = 30  # words of a sentence that is read twice
_DEFINITIONS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
_NO_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
_FENCED = re.compile(r"^(`{3,}|:{3,}).*?^\1\s*$", re.MULTILINE | re.DOTALL)
_NO_PROSE = re.compile(r"^\s*(?:\||#|!\[|\[.*\]:|<|\$\$|:$)")
_INLINE = re.compile(r"`[^`]*`|\$[^$]*\$|\]\([^)]*\)")
_END = re.compile(r"(?<=[.!?:])[)*\"']*\s+(?=[A-Z*_\"'(\[`0-9])")


def code_lines(source: str) -> list[str]:
    """The lines that hold code, without docstrings and comments."""
    tree = ast.parse(source)
    texts: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, _DEFINITIONS) and ast.get_docstring(node) is not None:
            text = node.body[0]
            texts.update(range(text.lineno, (text.end_lineno or text.lineno) + 1))
    numbers: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in _NO_CODE:
            numbers.update(range(token.start[0], token.end[0] + 1))
    lines = source.splitlines()
    return [
        lines[n - 1] for n in sorted(numbers - texts) if n <= len(lines) and lines[n - 1].strip()
    ]


def measures(folder: Path) -> dict[str, float]:
    """The measures of all Python files below a folder."""
    lines: list[str] = []
    nodes = tuples = ternaries = 0
    first_lines: list[int] = []
    for file in sorted(folder.rglob("*.py")):
        source = file.read_text(encoding="utf-8")
        lines += code_lines(source)
        for node in ast.walk(ast.parse(source)):
            nodes += 1
            ternaries += isinstance(node, ast.IfExp)
            if isinstance(node, ast.Assign):
                tuples += any(isinstance(target, ast.Tuple) for target in node.targets)
            if isinstance(node, _DEFINITIONS) and (text := ast.get_docstring(node)):
                first_lines.append(len(text.splitlines()[0].split()))
    return {
        "lines of code": len(lines),
        "characters a line": statistics.mean(len(line.rstrip()) for line in lines),
        "nodes a line": nodes / len(lines),
        "tuple assignments in 1 000 lines": 1000 * tuples / len(lines),
        "ternaries in 1 000 lines": 1000 * ternaries / len(lines),
        "words of a first line, median": statistics.median(first_lines),
        "first lines of more than 9 words": sum(words > 9 for words in first_lines),
        "first lines": len(first_lines),
    }


def sentences(markdown: str) -> list[int]:
    """Numbers of words of a page's sentences.

    Tables, code and formulae are left out.
    """
    prose: list[str] = [""]
    for line in _FENCED.sub("", markdown).splitlines():
        text = re.sub(r"^\s*(?:[-*]|\d+\.|>)\s+", "\0", line)
        if not line.strip() or _NO_PROSE.match(line) or text.startswith("\0"):
            prose.append("")
        if line.strip() and not _NO_PROSE.match(line):
            prose[-1] += " " + text.removeprefix("\0")
    counted = []
    for paragraph in prose:
        for sentence in _END.split(_INLINE.sub(" x ", paragraph)):
            words = len(re.findall(r"\w[\w.,'-]*", sentence))
            if words > 2:
                counted.append(words)
    return counted


def main() -> None:
    """Print all measures."""
    for name in ("src/dubins_study", "tests"):
        print(name)
        for what, value in measures(ROOT / name).items():
            print(f"  {what:34} {value:8.1f}")
    print("page                        sentences  median  long")
    for file in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        words = sentences(file.read_text(encoding="utf-8"))
        if words:
            share = sum(number > LONG for number in words) / len(words)
            median = statistics.median(words)
            print(f"{file.relative_to(ROOT)!s:28} {len(words):8} {median:7.0f} {share:5.0%}")


if __name__ == "__main__":
    main()
