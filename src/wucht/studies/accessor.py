"""``result.wucht``: what every result says of itself, without JSON."""

from __future__ import annotations

import json
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any

from wucht.errors import WuchtError
from wucht.results.conventions import assumed_of, summary_of

if TYPE_CHECKING:
    import xarray as xr

_FEW = 12  # numbers of a summary that a table shows


class ResultAccessor:
    """A result as an object.

    Attributes
    ----------
    study : str
        Its kind, such as ``run-up``.
    spec : dict
        What was asked: the keys of ``[study]``.
    machine : dict
        What it was asked of: title, parameters by path (SI floats), bodies (name, kind, what they turn about).
    summary : dict
        The numbers of the contract, SI floats, None where there is none.
    sentence : str
        The answer in words.
    assumed : list of str
        What the answer assumes: which equations, how fast what turns, where bodies are held.
    warnings, notes : list of str
        What is doubtful; what parameters were made of, such as the circuit of a motor of its nameplate.
    failure : str
        Why the result is not complete, empty if nothing failed.
    finished : bool
        Whether the study reached its end.

    Raises
    ------
    WuchtError
        Where the Dataset is no result of a study.
    """

    def __init__(self, result: xr.Dataset) -> None:
        missing = [name for name in ("study", "title", "input", "summary", "finished") if name not in result.attrs]
        if missing:
            raise WuchtError(f"this is no result of a study: its attribute {missing[0]!r} is missing", code="no-result")
        self._result = result
        asked = json.loads(result.attrs["input"])
        self.study: str = result.attrs["study"]
        self.spec: dict[str, Any] = asked["study"]
        self.machine: dict[str, Any] = asked["machine"]
        self.summary = summary_of(result)
        self.sentence: str = result.attrs["sentence"]
        self.assumed = assumed_of(result)
        self.warnings: list[str] = json.loads(result.attrs["warnings"])
        self.notes: list[str] = json.loads(result.attrs.get("notes", "[]"))
        self.failure: str = result.attrs["failure"]
        self.finished = bool(result.attrs["finished"])

    def __repr__(self) -> str:
        lines = [f"{self.study} of {self._result.attrs['title']}: {self.sentence}"]
        lines += [] if self.finished else [f"not finished{f': {self.failure}' if self.failure else ''}"]
        return "\n".join([*lines, *(f"note: {n}" for n in self.notes), *(f"warning: {w}" for w in self.warnings)])

    def _repr_html_(self) -> str:
        shown = [(k, v if isinstance(v, str) else f"{v:.6g}") for k, v in self.summary.items() if type(v) in (int, float, str)]
        rows = "".join(f"<tr><th>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in shown[:_FEW])
        notes = "".join(f"<li>{escape(w)}</li>" for w in (*self.notes, *self.warnings))
        heading = f"{escape(self.study)} of {escape(str(self._result.attrs['title']))}"
        return f"<b>{heading}</b><p>{escape(self.sentence)}</p><table>{rows}</table><ul>{notes}</ul>"


@cache
def register() -> None:
    """Make ``Dataset.wucht`` known to xarray."""
    import xarray as xr_

    xr_.register_dataset_accessor("wucht")(ResultAccessor)  # type: ignore[no-untyped-call]
