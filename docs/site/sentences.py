"""All sentences that the program can print, in one list: ``python -m docs.site.sentences``.

Texts of three words or more in the source that are no docstrings, with the places of their values as ``{...}``; one line each,
with file and line. Errors, warnings, verdicts, reports, labels of figures, help texts: to be read as a whole, and compared with
the list of an earlier commit.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "wucht"
_FEWEST_WORDS = 3


def _text(node: ast.AST) -> str | None:
    """The text of a string, of an f-string, or of several that are added; None for anything else."""
    match node:
        case ast.Constant(value=str(value)):
            return value
        case ast.JoinedStr(values=values):
            return "".join(_text(v) or "{...}" if isinstance(v, ast.Constant) else "{...}" for v in values)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            texts = _text(left), _text(right)
            return None if texts == (None, None) else "".join(t if t is not None else "{...}" for t in texts)
    return None


def _texts_in(node: ast.AST) -> Iterator[tuple[int, str]]:
    """The texts within a node and their lines, but for docstrings."""
    if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node, clean=False) is not None:
        children = [child for child in ast.iter_child_nodes(node) if child is not node.body[0]]
    else:
        children = list(ast.iter_child_nodes(node))
    for child in children:
        text = _text(child)
        if text is None:
            yield from _texts_in(child)
        else:
            yield child.lineno, " ".join(text.split())  # type: ignore[attr-defined]
            if isinstance(child, ast.JoinedStr):
                for value in child.values:
                    yield from _texts_in(value) if isinstance(value, ast.FormattedValue) else ()


def sentences(source: Path = SOURCE) -> Iterator[tuple[str, int, str]]:
    """File, line and text of each sentence in the source."""
    for file in sorted(source.rglob("*.py")):
        for line, text in _texts_in(ast.parse(file.read_text(encoding="utf-8"))):
            if len(text.split()) >= _FEWEST_WORDS:
                yield file.relative_to(source).as_posix(), line, text


def main() -> None:
    """Print the list, of this source or of one at the path that is given."""
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else SOURCE
    for file, line, text in sentences(source):
        print(f"{file}:{line}: {text}")


if __name__ == "__main__":
    main()
