"""Whatever stands after ``#`` in the address of a page: it is a scenario of this machine, or refused by a sentence."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from tests.web.page_answers import answer, page_text

MACHINE, STATES, PATH = "drozdetskaya-2020/r1", 10, "drum.mass"
_VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 1e308, -1e-320, 2**70, "", "x", "1", "__proto__", "NaN", [], {}, [None], [[]], [{}], [1],
    {"": 1}, {PATH: 1}, {"time": 1}, [{"time": 0}], [1.0] * STATES, {"length": 3}, {"__proto__": 1}, {"map": None},
)  # fmt: skip
_KEYS = ("until", "parameters", "start", "changes", "time", "stroboscopic", "state", "__proto__", "", PATH, "drum.angle")
_LETTERS = '[]{},:"%0123456789eE.-+# nulltruefalse\\\u00e9\ud83d'


def fragment(seed: int) -> str:
    """A link with some of its values replaced, any JSON, or any letters."""
    chance = random.Random(seed)
    how = chance.random()
    if how < 0.1:
        letters = "".join(chance.choice(_LETTERS) for _ in range(chance.randrange(40)))
        return letters.encode("utf-8", "replace").decode()
    content: Any = {
        "until": 5, "parameters": {PATH: 9.5}, "start": {"drum.angle": 0.1}, "time": 1, "stroboscopic": True,
        "changes": [{"time": 1, "parameters": {PATH: 10}, "state": [0.0] * STATES}, {"time": 2, "parameters": {PATH: 8}}],
    }  # fmt: skip
    for _ in range(chance.choice((1, 1, 2, 3))):
        content = _changed(chance, content)
    text = json.dumps(content)
    text = text[: chance.randrange(len(text) + 1)] if how > 0.95 else text
    return quote(text) if how < 0.9 else text


def _changed(chance: random.Random, value: Any) -> Any:
    """A value in which one is replaced, added or left out, at any depth."""
    if isinstance(value, dict | list) and value and chance.random() < 0.8:
        key = chance.choice([*value] if isinstance(value, dict) else [*range(len(value))])
        if chance.random() < 0.15:
            return {k: v for k, v in value.items() if k != key} if isinstance(value, dict) else value[:key] + value[key + 1 :]
        changed = value.copy()
        changed[key] = _changed(chance, value[key])
        return changed
    if isinstance(value, dict) and chance.random() < 0.3:
        return value | {chance.choice(_KEYS): chance.choice(_VALUES)}
    return chance.choice(_VALUES)


@pytest.mark.parametrize("count", [2000, pytest.param(200_000, marks=pytest.mark.slow)])
def test_any_fragment(tmp_path: Path, count: int) -> None:
    """Some are read, most are refused."""
    texts = [fragment(seed) for seed in range(count)]
    answers = answer(tmp_path, page_text(MACHINE), "links", texts=texts)
    shown = [(text, one) for text, one in zip(texts, answers, strict=True) if isinstance(one, dict)]
    assert count / 20 < len(shown) < count / 2
    for text, one in shown:
        assert "error" not in one, text
        scenario = one["scenario"]
        assert len(scenario["start"]) == STATES, text
        times = [change["time"] for change in scenario["changes"]]
        assert times == sorted(times) and all(time >= 0 for time in times), text
        assert one["stroboscopic"] in (True, False), text
        numbers = [*scenario["parameters"], *scenario["start"], scenario["until"], one["time"], *times]
        for change in scenario["changes"]:
            numbers += [number for pair in change["parameters"] for number in pair] + (change["state"] or [])
        assert all(type(number) in (int, float) and math.isfinite(number) for number in numbers), text
    assert all(one.endswith("The machine is shown with its file’s values.") for one in answers if isinstance(one, str))
