"""One answer of one source tree, in a process of its own: all that a user gets, into the current folder.

``python answering.py CASE`` with the case as JSON; ``PYTHONPATH`` chooses the tree. For ``same_answers``; what it uses of wucht
are commands and public names alone, so that it answers for earlier and later versions alike.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

STUDY, OUT, RESUMED = "study.toml", "out", "resumed"
ANSWER, DRAWN = "answer.json", "drawn.npz"
_STOP_AT = 0.3  # share that is done when a study is interrupted


def answer(case: dict[str, Any], tree: Path) -> None:
    """Run a case, and write what it gave: exit code, text, error, and the source files it was made from."""
    if not case.get("is_fused", True):
        _separate_products_from_sums()
    opened, drawn = set[str](), dict[str, np.ndarray]()
    sys.addaudithook(_opening(tree, opened))
    with _drawing_into(drawn):
        name = case["file"]
        if case["kind"] == "template":
            _command("new", name, STUDY)
        words = ["run", STUDY if case["kind"] == "template" else name, *case["words"]]
        code, text, errors = _command(*words, "-o", OUT)
    given = {"exit code": code, "text": text.splitlines(), "errors": errors.splitlines()}
    given["error"] = _error(words) if code else None
    if case["is_interrupted"] and not code:
        _interrupt_and_resume(words)
    np.savez(DRAWN, **drawn)  # type: ignore[arg-type]  # names of arrays are keywords
    modules = {str(m.__file__) for m in sys.modules.values() if getattr(m, "__file__", None)}
    sources = sorted({path.removeprefix(f"{tree}/") for path in opened | modules if path.startswith(f"{tree}/")})
    Path(ANSWER).write_text(json.dumps({"given": given, "sources": sources}, indent=1), encoding="utf-8")


def _separate_products_from_sums() -> None:
    """Let machine code round each product before it is added: the last digits of all numbers are others."""
    from wucht.numerics.flow.compiled import kernel_translation, straight_line_code

    kernel_translation.CONTRACT = straight_line_code.CONTRACT = ()


def _opening(tree: Path, opened: set[str]) -> Callable[[str, tuple[Any, ...]], None]:
    """A hook that keeps the names of the tree's files that are opened: tables, catalogue, styles."""

    def note(event: str, args: tuple[Any, ...]) -> None:
        if event == "open" and isinstance(args[0], str) and args[0].startswith(f"{tree}/") and "__pycache__" not in args[0]:
            opened.add(args[0])

    return note


def _command(*words: str) -> tuple[int, str, str]:
    """Run a command of wucht as the command line does. Returns exit code, stdout and stderr."""
    from wucht.cli import main

    out, err, given, code = io.StringIO(), io.StringIO(), sys.argv, 0
    sys.argv = ["wucht", *words]
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        sys.argv = given
    return code, out.getvalue(), err.getvalue()


def _settings(words: list[str]) -> dict[str, Any]:
    """The settings of ``--set KEY=VALUE``, as texts: a table or list of TOML is read."""
    import tomllib

    settings: dict[str, Any] = {}
    for flag, setting in pairwise(words):
        if flag == "--set":
            key, _, value = setting.partition("=")
            try:
                settings[key] = tomllib.loads(f"x={value}")["x"]
            except tomllib.TOMLDecodeError:
                settings[key] = value
    return settings


def _error(words: list[str]) -> dict[str, str]:
    """The error that the public function raises: its class, key, code and text."""
    import wucht

    try:
        wucht.run_file(words[1], _settings(words))
    except Exception as error:
        key, code = getattr(error, "location", ""), getattr(error, "code", "")
        return {"class": type(error).__name__, "key": str(key), "code": str(code), "text": str(error)}
    return {}


def _interrupt_and_resume(words: list[str]) -> None:
    """Stop the same study where 30 % are done, and resume it."""
    import wucht

    def stop(share: float, _what: str) -> None:
        if share >= _STOP_AT:
            raise KeyboardInterrupt

    with contextlib.suppress(KeyboardInterrupt):
        wucht.run_file(words[1], _settings(words), folder=RESUMED, progress=stop)
    wucht.run_file(words[1], _settings(words), folder=RESUMED, resume=True)


@contextlib.contextmanager
def _drawing_into(drawn: dict[str, np.ndarray]) -> Iterator[None]:
    """Keep the numbers and words of each figure that is saved."""
    from matplotlib.figure import Figure

    save = Figure.savefig

    def keep(figure: Any, *args: Any, **kwargs: Any) -> Any:
        number = sum(key.endswith("/axes") for key in drawn)
        drawn[f"{number}/axes"] = np.array(len(figure.axes))
        for k, axes in enumerate(figure.axes):
            for name, values in _artists(axes):
                drawn[f"{number}/{k}/{name}"] = values
        return save(figure, *args, **kwargs)

    Figure.savefig = keep  # type: ignore[method-assign]
    try:
        yield
    finally:
        Figure.savefig = save  # type: ignore[method-assign]


def _artists(axes: Any) -> Iterator[tuple[str, np.ndarray]]:
    from matplotlib.text import Text

    yield "limits", np.array([*axes.get_xlim(), *axes.get_ylim()])
    yield "texts", np.array([text.get_text() for text in axes.findobj(Text)], dtype=str)
    for k, line in enumerate(axes.get_lines()):
        yield (
            f"line {k}",
            np.array(np.broadcast_arrays(*(np.ma.filled(np.ma.asarray(d, float), np.nan) for d in line.get_data(orig=False)))),
        )
        yield f"style of line {k}", np.array([str(line.get_color()), line.get_linestyle(), str(line.get_marker())])
    for k, collection in enumerate(axes.collections):
        yield f"points {k}", np.ma.filled(np.ma.asarray(collection.get_offsets(), float), np.nan)
        yield f"paths {k}", np.concatenate([np.zeros((0, 2)), *(path.vertices for path in collection.get_paths())])
        if (array := collection.get_array()) is not None:
            yield f"values {k}", np.ma.filled(np.ma.asarray(array, float), np.nan)
    for k, image in enumerate(axes.images):
        yield f"image {k}", np.ma.filled(np.ma.asarray(image.get_array(), float), np.nan)
    for k, patch in enumerate(axes.patches):
        yield f"patch {k}", np.asarray(patch.get_transform().transform_path(patch.get_path()).vertices)


if __name__ == "__main__":
    answer(json.loads(sys.argv[1]), Path(os.environ["PYTHONPATH"]).parent)
