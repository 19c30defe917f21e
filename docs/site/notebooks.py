"""The notebooks of ``docs/notebooks`` as pages with their output: executed when the site is made, and stored without."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .gallery import ROOT

FOLDER = ROOT / "docs" / "notebooks"
_OPEN = (
    'Open it yourself: [{name}]({name}){{ download="{name}" }}, in Jupyter or any other program for notebooks '
    "(`pip install jupyterlab`)."
)


def write_pages(pages: Path) -> None:
    """Write a page for each notebook into the folder of the pages, beside the notebook itself.

    Raises ``nbclient.exceptions.CellExecutionError`` for a notebook that fails, with the cell and Python's message.
    """
    for file in sorted(FOLDER.glob("*.ipynb")):
        text, pictures = as_page(file)
        folder = pages / "notebooks"
        folder.mkdir(exist_ok=True)
        (folder / f"{file.stem}.md").write_text(text, encoding="utf-8")
        for name, picture in pictures.items():
            (folder / name).write_bytes(picture)


def as_page(file: Path) -> tuple[str, dict[str, bytes]]:
    """A notebook as Markdown with the output of its cells, and its pictures by their names."""
    import nbformat
    from nbclient import NotebookClient
    from nbconvert import MarkdownExporter

    notebook = nbformat.read(file, as_version=4)
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(ROOT)}}).execute()
    resources: dict[str, Any] = {"unique_key": file.stem, "output_files_dir": ""}
    text, made = MarkdownExporter().from_notebook_node(notebook, resources)
    title, _, rest = text.lstrip().partition("\n")
    named = {Path(name).name: picture for name, picture in made["outputs"].items()}
    return f"{title}\n\n{_OPEN.format(name=file.name)}\n{rest}", named
