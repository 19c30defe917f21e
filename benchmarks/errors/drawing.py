"""``python -m benchmarks.errors.drawing [COUNT]``: the places in which the errors of this folder were written, drawn by length.

All lines of the sources, Python and TypeScript, in the order of their paths; every N-th from a random one on: each folder has
as many places as its share of the lines. The patches state the place in which each was written, in the sources of commit
0fdaf2df; where nothing there can be wrong, as in an import or a docstring, the error stands in the code next to it.
"""

from __future__ import annotations

import random
import sys
from pathlib import Path

_ROOT = Path(__file__).parents[2]
_SEED, _COUNT = 58, 60


def places(count: int = _COUNT, root: Path = _ROOT) -> list[str]:
    """Return places FILE:LINE, evenly over all lines of the sources."""
    files = (p for p in (root / "src" / "wucht").rglob("*") if p.suffix in (".py", ".ts") and not p.name.endswith(".d.ts"))
    lines = [
        f"{path.relative_to(root).as_posix()}:{k}"
        for path in sorted(files)
        for k in range(1, path.read_text(encoding="utf-8").count("\n") + 1)
    ]
    step = len(lines) / count
    first = random.Random(_SEED).random() * step
    return [lines[int(first + k * step)] for k in range(count)]


if __name__ == "__main__":
    print(*places(int(sys.argv[1]) if len(sys.argv) > 1 else _COUNT), sep="\n")
