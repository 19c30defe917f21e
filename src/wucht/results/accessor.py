"""``result.wucht``: what every result says of itself, without JSON."""

from __future__ import annotations

import json
import re
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any

from wucht.errors import WuchtError

if TYPE_CHECKING:
    import xarray as xr

_FEW = 12  # numbers of a summary that a table shows


class ResultAccessor:
    """A result as an object. It alone reads the attributes that are JSON in the Dataset, each once.

    Attributes
    ----------
    study : str
        Its kind, such as ``run-up``.
    title : str
        Of the machine, or whatever the question was about.
    question : dict
        ``spec`` and ``machine``, under the keys ``study`` and ``machine``.
    spec : dict
        What was asked: the keys of ``[study]``.
    machine : dict
        What it was asked of: title, parameters by path (SI floats), bodies (name, kind, what they turn about).
    summary : dict
        The numbers of the contract, SI floats, None where there is none.
    quantities : dict
        Of each key of the summary: ``what`` it is, its ``unit``, and of a table its ``parts``. Empty of results of earlier
        versions.
    sentence : str
        The answer in words.
    assumed : list of str
        What the answer assumes: which equations, how fast what turns, where bodies are held.
    warnings, notes : list of str
        What is doubtful; what parameters were made of, such as the circuit of a motor of its nameplate.
    contents : list of str
        The variables that the result had when it was written.
    failure : str
        Why the result is not complete, empty if nothing failed.
    finished : bool
        Whether the study reached its end.
    dimensionless : bool
        Whether its numbers have no units.

    Raises
    ------
    WuchtError
        Where the Dataset is no result of a study.
    """

    def __init__(self, result: xr.Dataset) -> None:
        attributes = result.attrs
        missing = [name for name in ("summary", "sentence", "warnings", "failure") if name not in attributes]
        if missing:
            raise WuchtError(f"this Dataset is no result of a study: it has no attribute {missing[0]}", code="no-result")
        # What the runner adds is not there yet while a study puts its answer together.
        self.question: dict[str, dict[str, Any]] = json.loads(attributes.get("input", '{"study": {}, "machine": {}}'))
        self.study: str = attributes.get("study", "")
        self.title: str = attributes.get("title", "")
        self.spec, self.machine = self.question["study"], self.question["machine"]
        self.summary: dict[str, Any] = json.loads(attributes["summary"])
        self.quantities: dict[str, dict[str, Any]] = json.loads(attributes.get("quantities", "{}"))
        self.sentence: str = attributes["sentence"]
        self.assumed, self.warnings, self.notes, self.contents = (
            list[str](json.loads(attributes.get(name, "[]"))) for name in ("assumed", "warnings", "notes", "contents")
        )
        self.failure: str = attributes["failure"]
        self.finished = bool(attributes.get("finished", 0))
        self.dimensionless = bool(attributes.get("dimensionless", 0))

    def unit_at(self, path: str) -> str:
        """The unit of a number of the summary by its path, such as ``working_points[0].speed``.

        That of the last step that is a key or one of its parts; empty of a ratio, and of what has no unit.
        """
        first, _, rest = re.sub(r"\[\d+\]", "", path).partition(".")
        stated = self.quantities.get(first, {})
        # Names of parts may have dots, as paths of parameters have.
        parts = [(f".{rest}.".rfind(f".{name}."), facts) for name, facts in stated.get("parts", {}).items()]
        _, last = max([(-1, stated), *((at, facts) for at, facts in parts if at >= 0)], key=lambda one: one[0])
        return str(last.get("unit", ""))

    @property
    def headlines(self) -> list[str]:
        """The numbers of the summary that are looked at first, by their paths."""
        paths = list[str]()
        for name, facts in self.quantities.items():
            parts = facts.get("headline", False)
            paths += [name] if parts is True else [f"{name}.{part}" for part in parts or ()]
        return paths

    def __repr__(self) -> str:
        lines = [f"{self.study} of {self.title}: {self.sentence}"]
        lines += [] if self.finished else [f"not finished{f': {self.failure}' if self.failure else ''}"]
        return "\n".join([*lines, *(f"note: {n}" for n in self.notes), *(f"warning: {w}" for w in self.warnings)])

    def _repr_html_(self) -> str:
        shown = [(k, v if isinstance(v, str) else f"{v:.6g}") for k, v in self.summary.items() if type(v) in (int, float, str)]
        rows = "".join(f"<tr><th>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in shown[:_FEW])
        notes = "".join(f"<li>{escape(w)}</li>" for w in (*self.notes, *self.warnings))
        heading = f"{escape(self.study)} of {escape(str(self.title))}"
        return f"<b>{heading}</b><p>{escape(self.sentence)}</p><table>{rows}</table><ul>{notes}</ul>"


@cache
def register() -> None:
    """Make ``Dataset.wucht`` known to xarray."""
    import xarray as xr_

    xr_.register_dataset_accessor("wucht")(ResultAccessor)  # type: ignore[no-untyped-call]
