"""What ``import wucht`` offers: names, docstrings that can be parsed, Datasets that can be tabulated."""

from __future__ import annotations

import doctest
import inspect
import re

import pytest

import wucht

NAMES = [n for n in wucht.__all__ if n != "__version__"]
SECTIONS = ["Parameters", "Attributes", "Returns", "Yields", "Raises", "Notes", "References", "Examples"]


def test_the_names_are_shown_and_there() -> None:
    assert dir(wucht) == sorted(wucht.__all__)
    for name in NAMES:
        assert getattr(wucht, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = wucht.nothing


def test_all_specs_are_offered() -> None:
    from wucht.studies.registry import studies

    own = [s.spec.__name__ for s in studies().values() if s.spec.__module__.startswith("wucht.")]
    assert len(own) == 24
    assert set(own) <= set(NAMES)


def test_the_docstring_of_the_package_is_true() -> None:
    """It names every name, and its example gives what it says."""
    words = set(re.findall(r"[A-Za-z_]+", wucht.__doc__ or ""))
    assert set(NAMES) - words == set()
    assert doctest.testmod(wucht).failed == 0


@pytest.mark.parametrize("name", [n for n in NAMES if n != "parts"])
def test_public_docstrings_have_numpys_form(name: str) -> None:
    """Sections in NumPy's order, underlined as long as they are named; that of a function names each of its parameters."""
    public = getattr(wucht, name)
    text = inspect.getdoc(public) or ""
    lines = text.splitlines()
    assert lines and lines[0].endswith(".")
    sections = [k for k, line in enumerate(lines[:-1]) if re.fullmatch("-{3,}", lines[k + 1]) and line]
    assert [lines[k] for k in sections] == [s for s in SECTIONS if s in [lines[k] for k in sections]]
    for k in sections:
        assert len(lines[k]) == len(lines[k + 1])
    if not inspect.isfunction(public):
        return
    given = list(inspect.signature(public).parameters)
    written = lines[lines.index("Parameters") + 2 :] if given else []
    entries = " ".join(line.split(":")[0] for line in written if line and not line.startswith(" "))
    assert {n for n in given if not re.search(rf"\b{n}\b", entries)} == set()
    assert "Returns" in lines or inspect.signature(public).return_annotation == "None"


def test_one_run_is_a_table_of_its_own_size() -> None:
    """Time, body and direction: the dimensions that something depends on, and no product with others."""
    machine = wucht.load_machine("drozdetskaya-2020/r1")
    result = wucht.run(wucht.RunUp(until=2.0, start={"p1": 0.3, "p2": -0.5}), machine)
    assert set(result.sizes) == {"time", "body", "direction"}
    assert len(result.to_dataframe()) == result.sizes["time"] * 3 * 2
