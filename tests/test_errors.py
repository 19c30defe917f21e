"""Errors: their sentence, their fields, and what is kept on the way through files and processes."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from wucht.dynamics.sweeps.moving import IntegrationError
from wucht.errors import FieldError, InputError, RunError, WuchtError, nearest
from wucht.numerics.flow.events import LegError


def fields(error: InputError) -> tuple[object, ...]:
    return error.location, error.value, error.explanation, error.file, error.key, error.code, error.value_text, str(error)


@pytest.mark.parametrize(
    ("where", "given", "sentence"),
    [
        ("study.until", "5 kg", "study.until: given '5 kg'; must be a time"),
        ("study.until", None, "study.until: must be a time"),
        ("study.until", 10**5000, "study.until: given a number of thousands of digits; must be a time"),
    ],
    ids=["text", "nothing", "huge"],
)
def test_the_sentence_states_key_what_was_given_and_what_is_allowed(where: str, given: object, sentence: str) -> None:
    error = InputError(where, given, "must be a time", code="limits")
    assert str(error) == sentence
    assert fields(error)[:6] == (where, given, "must be a time", "", where, "limits")


def test_a_file_that_is_wrong_as_a_whole_has_no_key() -> None:
    error = InputError.file_error("motor.csv", "there is no such file", code="no-file")
    assert fields(error) == ("motor.csv", None, "there is no such file", "motor.csv", "", "no-file", "",
                             "motor.csv: there is no such file")  # fmt: skip
    assert error.with_file("study.toml").file == "motor.csv"
    assert str(error.with_file("study.toml")) == "study.toml: motor.csv: there is no such file"


def test_in_a_file_the_key_stays_and_the_file_is_added() -> None:
    error = InputError("machine.mass", -1, "must be positive", code="limits")
    inner = error.with_file("base.toml")
    assert fields(inner) == ("base.toml: machine.mass", -1, "must be positive", "base.toml", "machine.mass", "limits", "-1",
                             "base.toml: machine.mass: given -1; must be positive")  # fmt: skip
    outer = inner.with_file("study.toml")
    assert (outer.file, outer.key, outer.code) == ("base.toml", "machine.mass", "limits"), "the file that is wrong is the inner"
    assert str(outer) == "study.toml: base.toml: machine.mass: given -1; must be positive"
    nowhere = InputError("", None, "give a table", code="missing").with_file("study.toml")
    assert (nowhere.location, nowhere.file, nowhere.key, nowhere.code) == ("study.toml", "study.toml", "", "missing")
    assert (error.file, error.location) == ("", "machine.mass"), "the error itself is as it was"


def test_within_a_table_its_key_is_in_front() -> None:
    error = InputError("mass", -1, "must be positive", code="limits")
    assert fields(error.with_prefix("machine"))[:6] == ("machine.mass", -1, "must be positive", "", "machine.mass", "limits")
    assert error.with_prefix("bodies[0]").with_prefix("machine").key == "machine.bodies[0].mass"
    assert error.with_prefix("r.csv", ": ").location == "r.csv: mass"
    assert InputError("", 3, "must be a table", code="type").with_prefix("machine").key == "machine"
    kept = InputError("r.csv: speed", None, "it is empty", "r.csv", "speed", "count").with_prefix("study")
    assert (kept.location, kept.file, kept.key, kept.code) == ("study.r.csv: speed", "r.csv", "study.speed", "count")


ERRORS = [
    RunError("failed", code="no-convergence"),
    InputError("study.until", None, "must be a time").with_file("study.toml"),
    FieldError("mass", "must be positive", code="limits"),
    IntegrationError("stopped", code="not-finite"),
    LegError("500000 steps were not enough", "raise the tolerance", np.zeros((2, 3)), 1e-9),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda e: type(e).__name__)
def test_errors_come_from_another_process_as_they_were(error: WuchtError | FieldError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert (str(again), again.args, repr(vars(again))) == (str(error), error.args, repr(vars(error)))
    assert again.code == error.code


@pytest.mark.parametrize(
    ("given", "known", "help_"),
    [
        ("stifness", ["mass", "stiffness", "damping"], "did you mean 'stiffness'? known: damping, mass, stiffness"),
        ("x", [], "known: none"),
        ("a" * 1000, ["mass"], "known: mass"),
        ("key7", (f"key{i}" for i in range(203)), None),
    ],
)
def test_the_nearest_name_and_those_that_are_known(given: str, known: list[str], help_: str | None) -> None:
    clause = nearest(given, known)
    if help_ is not None:
        assert clause == help_
        return
    assert clause.startswith("did you mean 'key7'? known: key0, key1, key10, ")
    assert clause.endswith(" and 3 more")
    assert clause.count(",") == 199


def test_a_very_long_location_is_shortened_in_the_sentence() -> None:
    """A heading of a table may be a whole file; up to 2,000 characters it is printed."""
    for length, shown in ((2000, 2000), (2001, 1890 + 5 + 100)):
        error = InputError("a" * length, None, "is wrong")
        assert len(str(error)) == shown + len(": is wrong") and error.location == "a" * length
