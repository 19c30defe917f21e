"""Results that were edited, and files of which bytes were changed: each from its seed."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

_CELLS = (
    "", "x", "nan", "inf", "1e308", "-1e308", "1e-320", "\u0661\u0662", '"1"', '"', "1;2", "NaN", "0x10", "1_000", "--", "1,5",
)  # fmt: skip
Edit = Callable[["xr.Dataset"], "xr.Dataset"]
_KINDS = ("run-up", "sweep", "basin", "speed-curve", "comparison", "cam-contour", "torque-balance", "load-spectrum", "nothing")


def bytes_changed(whole: bytes, seed: int) -> bytes:
    """One bit, some bytes, a part left out or twice, cut off, or something behind it."""
    chance, data = random.Random(seed), bytearray(whole)
    how, at = chance.randrange(7), chance.randrange(len(data))
    length = chance.choice((1, 2, 7, 100, 4000))
    if how <= 2:
        data[at] ^= 1 << chance.randrange(8)
    elif how == 3:
        data[at : at + length] = bytes(chance.randrange(256) for _ in data[at : at + length])
    elif how == 4:
        del data[at : at + length]
    elif how == 5:
        data[at:at] = data[at : at + length]
    else:
        del data[at:]
    return bytes(data)


def text_changed(whole: str, seed: int) -> bytes:
    """A table as text, with what programs and people do to it."""
    chance, lines = random.Random(seed), whole.splitlines()
    for _ in range(chance.choice((1, 1, 2, 4))):
        line = chance.randrange(len(lines))
        how = chance.randrange(7)
        if how == 0:
            parts = lines[line].split(",")
            parts[chance.randrange(len(parts))] = chance.choice(_CELLS)
            lines[line] = ",".join(parts)
        elif how == 1:
            del lines[line:]
        elif how == 2:
            lines.insert(line, lines[chance.randrange(len(lines))] if lines else "")
        elif how == 3:
            lines[line] = lines[line].replace(",", chance.choice((";", "\t", " ", ",,", "|")))
        elif how == 4:
            lines[0] = chance.choice(
                ("time [s],force [N^9^9^9^9]", "time [s],time [s]", "=1+1,@x", "\x00,\x1b", "a" * 3000, "time,\u8f6c")
            )
        elif how == 5:
            lines = [*lines, *[chance.choice(_CELLS)] * chance.choice((1, 50))]
        else:
            lines[line] = " " * 5000 + lines[line]
        lines = lines or [""]
    text = chance.choice(("\n", "\n", "\r\n", "\r")).join(lines)
    return text.encode(chance.choice(("utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1", "utf-8")), errors="replace")


def edits(result: xr.Dataset) -> Iterator[tuple[str, Edit]]:
    """What can be done to a result with any program that reads its format, by name."""
    for name in result.attrs:
        yield f"without {name}", lambda d, name=name: d.assign_attrs({k: v for k, v in d.attrs.items() if k != name})  # type: ignore[misc]
        for value in ("x", 3, "[]", "{}", [1.0, 2.0], ""):
            yield f"{name} = {value!r}", lambda d, name=name, value=value: d.assign_attrs({name: value})  # type: ignore[misc]
    for kind in _KINDS:
        yield f"of {kind}", lambda d, kind=kind: d.assign_attrs(study=kind)  # type: ignore[misc]
        yield f"of {kind}, alone", lambda d, kind=kind: d.assign_attrs(study=kind, contents="[]")  # type: ignore[misc]
    for size in result.sizes:
        for count in (0, 1):
            yield f"{count} of {size}", lambda d, size=size, count=count: d.isel({size: slice(0, count)})  # type: ignore[misc]
    for name, variable in result.variables.items():
        yield f"no variable {name}", lambda d, name=name: d.drop_vars(name)  # type: ignore[misc]
        yield f"{name} without attributes", lambda d, name=name: d.assign({name: (d[name].dims, d[name].values)})  # type: ignore[misc]
        for number in (np.nan, np.inf, 1e308) if variable.dtype.kind == "f" else ():
            yield f"{name} all {number}", lambda d, name=name, number=number: _filled(d, str(name), number)  # type: ignore[misc]
    summary = result.wucht.summary
    for key in summary:
        yield f"summary without {key}", lambda d, key=key: _summarised(d, {k: v for k, v in summary.items() if k != key})  # type: ignore[misc]
        for value in (None, "x", [], {}):
            yield f"summary, {key} = {value!r}", lambda d, key=key, value=value: _summarised(d, summary | {key: value})  # type: ignore[misc]


_WRONG: tuple[Any, ...] = (
    "x", "", 3, -1.5, float("nan"), [1.0, 2.0], ["a", "b"], "[]", "{}", "null", "[null]", "3", '"a"', '{"a": 1}', "[" * 9999,
)  # fmt: skip
_WRONG_INSIDE: tuple[Any, ...] = (
    None, True, "", "x", 3, -1.5, 1e308, [], {}, [None], ["a"], [1], [[1]], {"a": 1}, {"a": {"b": 1}}, [{"a": [1]}],
)  # fmt: skip


def crafted(result: xr.Dataset, seed: int) -> tuple[str, xr.Dataset]:
    """A result with another attribute, or with another value within its JSON; for half of the seeds its checksums are right."""
    from wucht.results.provenance import with_checksums

    chance = random.Random(seed)
    name = str(chance.choice([*result.attrs]))
    value = chance.choice(_WRONG)
    if isinstance(before := result.attrs[name], str) and before[:1] in "[{" and chance.random() < 0.6:
        value = json.dumps(_changed_inside(chance, json.loads(before)))
    changed = result.assign_attrs({name: value})
    return f"seed {seed}, {name} = {value!r}"[:200], with_checksums(changed) if chance.random() < 0.5 else changed


def _changed_inside(chance: random.Random, content: Any) -> Any:
    """Content of JSON in which one value is replaced, at any depth."""
    if not isinstance(content, dict | list) or not content or chance.random() < 0.2:
        return chance.choice(_WRONG_INSIDE)
    key = chance.choice([*content] if isinstance(content, dict) else [*range(len(content))])
    changed = content.copy()
    changed[key] = _changed_inside(chance, content[key])
    return changed


def _filled(result: xr.Dataset, name: str, number: float) -> xr.Dataset:
    filled = np.full(result[name].shape, number)
    return (
        result.assign_coords({name: (result[name].dims, filled)}) if name in result.coords else _assigned(result, name, filled)
    )


def _assigned(result: xr.Dataset, name: str, values: np.ndarray) -> xr.Dataset:
    return result.assign({name: (result[name].dims, values, result[name].attrs)})


def _summarised(result: xr.Dataset, summary: dict[str, Any]) -> xr.Dataset:
    return result.assign_attrs(summary=json.dumps(summary))
