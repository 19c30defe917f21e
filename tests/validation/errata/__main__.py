"""Write docs/errata.md: ``python -m tests.validation.errata`` in the project's folder."""

from pathlib import Path

from . import CHECKS, page

if __name__ == "__main__":
    Path("docs/errata.md").write_text(page(CHECKS), encoding="utf-8")
