"""The walk of a number in docs/design.md: each stop exists, and its command calls the functions among them."""

from __future__ import annotations

import inspect
import os
import re
import shlex
import subprocess
import sys
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from page_blocks import ROOT

import wucht

PAGE = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
SECTION = PAGE.partition("\n## One number from file to figure\n")[2].partition("\n## ")[0]
WALK = SECTION.partition("**`drive.slope`**")[2]
PACKAGES = "|".join(p.stem for p in (ROOT / "src" / "wucht").iterdir() if p.is_dir() or p.suffix == ".py")
_NAME = re.compile(rf"`((?:wucht\.)?(?:{PACKAGES})(?:\.\w+)+)`")
_CALLED = """
import sys
codes = set()
sys.setprofile(lambda frame, event, _: codes.add(frame.f_code) if event == "call" else None)
from wucht.cli.app import run_app
code = run_app()
sys.setprofile(None)
print("\\n".join(f"CALLED {c.co_filename}:{c.co_firstlineno}" for c in codes))
sys.exit(code)
"""


def _stop(name: str) -> Any:
    """The object of a name, or the class whose field it is. Raises ``AttributeError`` where there is none."""
    parts = ["wucht", *name.removeprefix("wucht.").split(".")]
    count = max(k for k in range(1, len(parts) + 1) if _is_module(parts[:k]))
    stop: Any = import_module(".".join(parts[:count]))
    for part in parts[count:]:
        fields = (*getattr(stop, "model_fields", ()), *getattr(stop, "__dataclass_fields__", ()))
        stop = stop if inspect.isclass(stop) and part in fields else inspect.getattr_static(stop, part)
    return stop


def _is_module(parts: list[str]) -> bool:
    at = Path(wucht.__file__).parent.joinpath(*parts[1:])
    return at.is_dir() or at.with_suffix(".py").is_file()


def _place(stop: Any) -> str | None:
    """File and first line of a function, a property or a classmethod; None for classes, their fields and constants."""
    if isinstance(stop, cached_property):
        stop = stop.func
    if isinstance(stop, property):
        stop = stop.fget
    stop = inspect.unwrap(getattr(stop, "__func__", stop))
    return f"{stop.__code__.co_filename}:{stop.__code__.co_firstlineno}" if inspect.isfunction(stop) else None


def test_the_number_is_followed() -> None:
    stops = re.findall(r"(?m)^\d+\. .*$", WALK)
    assert 6 <= len(stops) <= 9
    assert all(_NAME.match(stop.partition(". ")[2]) for stop in stops), "a stop begins with its name"
    for name in _NAME.findall(WALK):
        _stop(name)


def test_a_stop_that_does_not_exist_is_reported() -> None:
    for name in ("files.documents.read_tomls", "machines.machines.Machine", "machines.machine.Machine.weight"):
        with pytest.raises(AttributeError):
            _stop(name)


@pytest.mark.slow
def test_each_function_is_called(here: Path) -> None:
    """In a new process with an empty cache: what is derived already would not be derived again."""
    (command,) = re.findall(r"`wucht (run [^`]+)`", WALK)
    process = subprocess.run(
        [sys.executable, "-c", _CALLED, *shlex.split(command), "--set", "study.until=3 s"], check=True, capture_output=True,
        text=True, env=os.environ | {"WUCHT_CACHE_DIR": str(here / "cache")},
    )  # fmt: skip
    called = set(re.findall(r"(?m)^CALLED (.*)$", process.stdout))
    places = {name: _place(_stop(name)) for name in _NAME.findall(WALK)}
    assert {name: place for name, place in places.items() if place and place not in called} == {}
    assert sum(place is not None for place in places.values()) >= 8
