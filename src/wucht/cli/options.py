"""Options that several commands share: ``--set``, ``--import``, ``--decimal``, and those of figures."""

from __future__ import annotations

import importlib
import importlib.util
import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterable
from contextlib import suppress
from enum import StrEnum
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wucht.cli.completing import settable_keys, study_names
from wucht.errors import InputError
from wucht.file_names import safe_name
from wucht.files.documents import DEEPEST
from wucht.plots.page import JOURNAL, PAGES, PRINT

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_OUTSIDE = re.compile(r"[^,\[\]{}]+|[,\[\]{}]")  # stretches without a comma or bracket, and those one by one


def parse_settings(items: list[str]) -> dict[str, Any]:
    """Parse ``["u=1.5", "drive.slope=0.02 N m s"]`` into a dictionary. Raises ``InputError``."""
    settings: dict[str, Any] = {}
    for item in items:
        key, equals, value = item.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise InputError("--set", item, "must be KEY=VALUE, such as drive.slope=0.02")
        path = _path("--set", key)
        settings[path] = _value(f"--set {path}", value.strip())
    return settings


def parse_lists(items: list[str]) -> dict[str, list[Any]]:
    """Parse ``["u=1,1.5", "drive.slope=0.02 N m s,0.03 N m s"]`` into a dictionary of lists. Raises ``InputError``."""
    lists: dict[str, list[Any]] = {}
    for item in items:
        key, equals, values = item.partition("=")
        texts = [text.strip() for text in _split(values)]
        if not equals or not key.strip() or not all(texts):
            raise InputError("--vary", item, "must be KEY=VALUE,VALUE,..., such as drive.slope=0.02,0.03")
        if (path := _path("--vary", key)) in lists:
            raise InputError("--vary", item, f"{path} is varied already; give all of its values at once", code="given-twice")
        lists[path] = [_value(f"--vary {path}", text) for text in texts]
    return lists


def _path(option: str, key: str) -> str:
    """A key without surrounding blanks. Raises ``InputError`` for one with more parts than tables may be nested."""
    if key.count(".") >= DEEPEST:
        raise InputError(option, key, f"must be a key of at most {DEEPEST} parts, such as drive.slope")
    return key.strip()


def _split(values: str) -> list[str]:
    """Split values at the commas outside brackets."""
    parts, depth = [""], 0
    for stretch in _OUTSIDE.findall(values):
        depth += (stretch in "[{") - (stretch in "]}")
        if stretch == "," and depth <= 0:
            parts.append("")
        else:
            parts[-1] += stretch
    return parts


def _value(option: str, text: str) -> Any:
    """Parse a number, true, false, a list or a table as in TOML (or JSON); anything else is text (a quantity with its unit).

    Raises ``InputError`` for values that are nested too deeply, and for numbers of thousands of digits.
    """
    if text[:1] in '["{' or text in ("true", "false"):
        if max(text.count("["), text.count("{")) > DEEPEST and _depth(text) > DEEPEST:
            raise InputError(option, text, f"must be a value in which at most {DEEPEST} brackets are nested")
        with suppress(tomllib.TOMLDecodeError):
            return _load_value(option, text, lambda: tomllib.loads(f"value = {text}")["value"])
        with suppress(json.JSONDecodeError):
            return _load_value(option, text, lambda: json.loads(text))
        return text
    try:
        return float(text)
    except ValueError:
        return text


def _depth(text: str) -> int:
    """Greatest number of brackets that are open at once."""
    return max(accumulate((letter in "[{") - (letter in "]}") for letter in text))


def _load_value(option: str, text: str, load: Callable[[], Any]) -> Any:
    """Load a value from a text. Raises ``InputError`` for numbers of thousands of digits, which Python refuses to read."""
    try:
        return load()
    except (tomllib.TOMLDecodeError, json.JSONDecodeError):
        raise
    except ValueError:
        raise InputError(option, text, "a number of thousands of digits cannot be read") from None


def _import_modules(modules: list[str] | None) -> list[str]:
    """Import each module: a name, or the path of a file or of a package's folder. Raises ``InputError``."""
    for module_or_path in modules or []:
        try:
            _import_module(module_or_path)
        except InputError:
            raise
        except KeyboardInterrupt as error:
            raise typer.Abort(str(error)) from None  # without it Typer ends with the exit code alone
        except Exception as error:  # any error of the user's code
            raise InputError("--import", module_or_path, f"it cannot be imported: {type(error).__name__}: {error}") from None
    return modules or []


def _import_module(module_or_path: str) -> None:
    path = Path(module_or_path)
    if not path.exists():
        if module_or_path.endswith(".py") or "/" in module_or_path:
            raise InputError("--import", module_or_path, "there is no such file or folder")
        importlib.import_module(module_or_path)
        return
    source = path / "__init__.py" if path.is_dir() else path
    name = path.resolve().stem
    if name in sys.modules:
        return
    spec = importlib.util.spec_from_file_location(
        name, source, submodule_search_locations=[str(path.resolve())] if path.is_dir() else None
    )
    if spec is None or spec.loader is None or not source.is_file():
        raise InputError("--import", module_or_path, "must be a module: a .py file, or a folder with __init__.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    for of_class in ("study", "spec"):
        if path.is_dir() and (path / f"{of_class}.py").is_file():
            importlib.import_module(f"{name}.{of_class}")


StudyName = Annotated[str, typer.Argument(help="A study file, or a name from `wucht list`.", autocompletion=study_names)]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", autocompletion=settable_keys, help="Set a parameter; repeatable."),
]
Imports = Annotated[
    list[str] | None,
    typer.Option(
        "--import",
        metavar="MODULE",
        callback=_import_modules,
        help="Import a module with additional parts or studies; repeatable.",
    ),
]


class Decimal(StrEnum):
    """Decimal signs of CSV files."""

    POINT = "point"
    COMMA = "comma"


DecimalOption = Annotated[
    Decimal | None,
    typer.Option(
        "--decimal",
        help="Of --csv: numbers with decimal points, the default, or with decimal commas and semicolons between cells.",
    ),
]


def is_decimal_comma(csv: bool, decimal: Decimal | None) -> bool:
    """True if numbers in CSV files have decimal commas. csv: whether such files are written. Raises ``InputError``."""
    if decimal is not None and not csv:
        raise InputError("--decimal", decimal.value, "this is the decimal sign of CSV files; give --csv too")
    return decimal is Decimal.COMMA


class Style(StrEnum):
    """Page on which figures are printed."""

    PRINT = PRINT.name
    JOURNAL = JOURNAL.name


class Format(StrEnum):
    """File formats of figures."""

    PNG = "png"
    PDF = "pdf"
    SVG = "svg"


StyleOption = Annotated[
    Style,
    typer.Option(
        "--style",
        help="Page on which the figure is printed: a sheet, or a column of a journal "
        "(88 mm, 8 pt, no title; a figure taller than 230 mm is set across both columns).",
    ),
]
FormatOption = Annotated[
    list[Format] | None, typer.Option("--format", help="File format of the figure, default png; repeatable.")
]
DEFAULT_STYLE = Style.PRINT


def unique_formats(formats: Iterable[Format] | None) -> list[Format]:
    """The requested file formats without repetition; by default PNG."""
    return list(dict.fromkeys(formats or [Format.PNG]))


def figure_names(kind: str, formats: Iterable[Format] | None = None) -> list[str]:
    """Names of the files of a study's figure, one for each format."""
    return [f"{safe_name(kind)}.{ending.value}" for ending in unique_formats(formats)]


def draw_on(result: xr.Dataset, style: Style) -> Figure:
    """Draw the figure of a result on the page of a style. Raises as ``draw``."""
    from wucht.studies.runner import draw

    return draw(result, PAGES[style.value])
