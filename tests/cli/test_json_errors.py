"""``--json`` answers errors as JSON too: one object on stdout, with the exit code and the sentence that stderr has."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from wucht import InputError

Command = Callable[..., Any]
Study = Callable[..., Path]
KEYS = {"error", "file", "key", "given", "allowed", "exit_code"}


def place(document: dict[str, Any]) -> tuple[Any, ...]:
    assert document.keys() == KEYS
    return tuple(document[k] for k in ("file", "key", "given", "exit_code"))


WRONG = {
    "a key of the machine": (("run", "study.toml", "--set", "carrier.mass=-1"), ("study.toml", "machine.carrier.mass", "-1.0")),
    "a key of the study": (("run", "study.toml", "--set", "study.until=5 kg"), ("study.toml", "study.until", "'5 kg'")),
    "no such file": (("run", "none.toml"), ("none.toml", None, None)),
    "no catalogue name": (("run", "none"), (None, "FILE", "'none'")),
    "an option": (("run", "study.toml", "--set", "u"), (None, "--set", "'u'")),
}


@pytest.mark.parametrize(("words", "expected"), WRONG.values(), ids=WRONG.keys())
def test_where_the_input_is_wrong(
    wucht: Command, study: Study, words: tuple[str, ...], expected: tuple[str | None, ...]
) -> None:
    study()
    done = wucht(*words, "--json")
    assert done.code == 2
    assert place(done.document) == (*expected, 2)
    assert done.document["allowed"] in done.document["error"]
    assert done.err == f"wucht: {done.document['error']}\n"
    assert not wucht(*words).out, "without --json stdout stays empty"


def test_the_file_is_that_which_is_wrong(wucht: Command, study: Study) -> None:
    study('"1 kg"', '"1 s"', name="base.toml")
    Path("top.toml").write_text('[machine]\nuse = "base.toml"\n')
    Path("middle.toml").write_text('[machine]\nuse = "top.toml"\n[study]\nkind = "run-up"\n')
    assert place(wucht("run", "middle.toml", "--json").document)[:2] == ("base.toml", "machine.carrier.mass")
    Path("base.toml").write_text("[machine")
    assert place(wucht("run", "middle.toml", "--json").document)[:2] == ("base.toml", None)


def test_usage_and_commands_without_the_option(wucht: Command) -> None:
    for words in (("run", "--json"), ("list", "--json", "--wrong"), ("walk", "--json")):
        done = wucht(*words)
        assert done.code == 2
        assert place(done.document) == (None, None, None, 2)


@pytest.mark.usefixtures("no_figures")
def test_a_run_that_fails_is_an_object_with_what_was_computed(wucht: Command, study: Study) -> None:
    done = wucht("run", study('p1 = "0.3 rad"', "carrier = { x = 1e12 }"), "-o", "out", "--json")
    assert done.code == 1
    assert done.document["exit_code"] == 1
    assert done.document["error"] in done.err
    assert done.document["summary"]["outcome"] == "failed"


def test_an_error_keeps_its_place_in_another_process() -> None:
    error = InputError("mass", -1, "must be more than 0").with_prefix("carrier").with_file("a.toml").with_file("b.toml")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.file, again.key) == (
        "b.toml: a.toml: carrier.mass: given -1; must be more than 0",
        "a.toml",
        "carrier.mass",
    )
