"""The list of all sentences: texts of three words or more, but for docstrings, with the places of their values."""

from __future__ import annotations

from pathlib import Path

from docs.site.sentences import sentences

SOURCE = '''"""A docstring of a module."""
def f(name):
    """A docstring of a function."""
    few = "two words"
    raise ValueError("the motion does not settle")

def g(name, x):
    return f"speed of {name} is {x:.3g}" + " in rad/s, as given", f"{x} {'a text within values' if x else ''}"
'''


def test_texts_are_listed_with_file_and_line(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b.py").write_text(SOURCE, encoding="utf-8")
    assert list(sentences(tmp_path)) == [
        ("a/b.py", 5, "the motion does not settle"),
        ("a/b.py", 8, "speed of {...} is {...} in rad/s, as given"),
        ("a/b.py", 8, "a text within values"),
    ]


def test_all_of_the_program_are_listed() -> None:
    listed = {text for _, _, text in sentences()}
    assert len(listed) > 3000
    assert any("at most {...} values can be given by position" in text for text in listed)
