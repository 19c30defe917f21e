"""What ``import wucht`` and its packages offer: names, docstrings that can be parsed, examples, Datasets as tables."""

from __future__ import annotations

import dataclasses
import doctest
import inspect
import pkgutil
import re
import subprocess
import sys
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest

import wucht

NAMES = [n for n in wucht.__all__ if n != "__version__"]
SECTIONS = ["Parameters", "Attributes", "Returns", "Yields", "Raises", "Notes", "References", "Examples"]
# Packages whose names others import; one without __all__ has no face yet.
FACES = [
    name
    for name in (
        "wucht.numerics.continuation",
        "wucht.numerics.periodic",
        "wucht.numerics.flow",
        "wucht.fatigue",
        "wucht.mechanics",
        "wucht.measurements",
        "wucht.cams",
        "wucht.dynamics",
    )
    if hasattr(import_module(name), "__all__")
]
PUBLIC = [("wucht", n) for n in NAMES if n != "parts"] + [(face, n) for face in FACES for n in import_module(face).__all__]


def test_the_docstring_of_the_package_is_true() -> None:
    """It names every name, and its example gives what it says."""
    words = set(re.findall(r"[A-Za-z_]+", wucht.__doc__ or ""))
    assert set(NAMES) - words == set()
    assert dir(wucht) == sorted(wucht.__all__)
    assert doctest.testmod(wucht).failed == 0


@pytest.mark.parametrize("face", FACES)
def test_a_face_shows_its_names(face: str) -> None:
    """All are there, and none is that of a module of the package, which would hide it."""
    package = import_module(face)
    assert dir(package) == sorted(package.__all__)
    assert len(package.__all__) == len(set(package.__all__))
    assert {module.name for module in pkgutil.iter_modules(package.__path__)} & set(package.__all__) == set()
    with pytest.raises(AttributeError):
        _ = package.nothing


def test_importing_a_face_loads_nothing_heavy() -> None:
    """No module but those packages and their earlier names: their names are loaded when first used."""
    loaded = "sorted(m for m in sys.modules if m.split('.')[0] in ('wucht', 'numpy', 'sympy'))"
    code = f"import sys, {', '.join(FACES)}; print(*{loaded})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    packages = {".".join(face.split(".")[:k]) for face in FACES for k in range(1, 1 + len(face.split(".")))}
    assert set(done.stdout.split()) - {"wucht.earlier_names"} == packages


def test_public_docstrings_have_numpys_form() -> None:
    """Sections in NumPy's order, underlined as long as they are named; each parameter of a function, and each field, named."""
    faults = {f"{package}.{name}": _faults(package, getattr(import_module(package), name)) for package, name in PUBLIC}
    assert {name: fault for name, fault in faults.items() if fault} == {}


def _faults(package: str, public: Any) -> list[str]:
    """What a docstring lacks. package: that of the name."""
    if not callable(public):  # a number or a style
        return []
    lines = (inspect.getdoc(public) or " ").splitlines()
    underlined = [k for k, line in enumerate(lines[:-1]) if re.fullmatch("-{3,}", lines[k + 1]) and line]
    titles = [lines[k] for k in underlined]
    explained = _entries(lines, "Parameters") | (_entries(lines, "Attributes") if inspect.isclass(public) else set())
    # Classes of ``wucht`` are in a face as well, or tables of a study.
    unnamed = _inputs(public) - explained if package in FACES or not inspect.isclass(public) else set()
    is_silent = not inspect.isclass(public) and not {"Returns", "Yields"} & set(lines)
    return [
        *(["the first line ends without a full stop"] if not lines[0].endswith(".") else []),
        *(["sections in another order, or unknown"] if titles != [s for s in SECTIONS if s in titles] else []),
        *(f"underlined too long or too short: {lines[k]}" for k in underlined if len(lines[k]) != len(lines[k + 1])),
        *sorted(unnamed),
        *(["no Returns"] if is_silent and inspect.signature(public).return_annotation != "None" else []),
    ]


def _inputs(public: Any) -> set[str]:
    """The parameters of a function, or with which a dataclass is made."""
    is_other_class = inspect.isclass(public) and not dataclasses.is_dataclass(public)
    return set() if is_other_class else set(inspect.signature(public).parameters)


def _entries(lines: list[str], section: str) -> set[str]:
    """The names that a section explains."""
    if section not in lines:
        return set()
    written = lines[lines.index(section) + 2 :]
    end = next((k for k, line in enumerate(written[:-1]) if re.fullmatch("-{3,}", written[k + 1])), len(written))
    return set(re.findall(r"\w+", " ".join(line.split(":")[0] for line in written[:end] if line and not line.startswith(" "))))


@pytest.mark.slow
def test_examples_of_public_names_are_true() -> None:
    runner = doctest.DocTestRunner()
    for package, name in PUBLIC:
        public = getattr(import_module(package), name)
        if not isinstance(public, ModuleType) and callable(public):
            for example in doctest.DocTestFinder(recurse=False).find(public, name):
                assert runner.run(example).failed == 0, f"{package}.{name}"
