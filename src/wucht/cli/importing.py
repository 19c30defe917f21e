"""``--import``: parts, kinds of cams and studies of a file that is not installed."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Annotated

import typer

from wucht.errors import InputError


def _imported(modules: list[str] | None) -> list[str]:
    """Import each module: a name, or the path of a file or of a package's folder. Raises ``InputError``."""
    for given in modules or []:
        try:
            _import(given)
        except InputError:
            raise
        except Exception as error:  # whatever the user's own code raises
            raise InputError("--import", given, f"it cannot be imported: {type(error).__name__}: {error}") from None
    return modules or []


def _import(given: str) -> None:
    path = Path(given)
    if not path.exists():
        if given.endswith(".py") or "/" in given:
            raise InputError("--import", given, "there is no such file or folder")
        importlib.import_module(given)
        return
    source = path / "__init__.py" if path.is_dir() else path
    name = path.resolve().stem
    if name in sys.modules:
        return
    spec = importlib.util.spec_from_file_location(
        name, source, submodule_search_locations=[str(path.resolve())] if path.is_dir() else None
    )
    if spec is None or spec.loader is None or not source.is_file():
        raise InputError("--import", given, "needed is a module: a .py file, or a folder with __init__.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    if path.is_dir() and (path / "spec.py").is_file():
        importlib.import_module(f"{name}.spec")


Imports = Annotated[
    list[str] | None,
    typer.Option(
        "--import", metavar="MODULE", callback=_imported, help="Import a module of your own with parts or studies; repeatable."
    ),
]
