"""The attributes of every result: what was asked, of which machine, with what answer in short, by which versions."""

from __future__ import annotations

import hashlib
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from wucht.machines.machine import Machine
from wucht.results.provenance import provenance
from wucht.results.store import to_json


def attributes(
    machine: Machine,
    question: Any,
    summary: Mapping[str, Any],
    sentence: str,
    warnings: Sequence[str],
    begun: float,
    failure: str | None = None,
    interrupted: bool = False,
) -> dict[str, Any]:
    """Attributes for a Dataset. sentence: the answer in words. begun: ``perf_counter()`` at the beginning."""
    asked = {k: v for k, v in asdict(question).items() if v is not None} | {"kind": question.kind}
    described = {
        "title": machine.title,
        "structure": structure(machine),
        "parameters": machine.values,
        "bodies": [[b.name, b.kind, b.about] for b in machine.bodies],
    }
    return {
        "study": question.kind,
        "title": machine.title,
        "sentence": sentence,
        "summary": to_json(dict(summary), indent=None),
        "warnings": to_json([*machine.warnings, *warnings], indent=None),
        "dimensionless": int(not machine.units.time),
        "finished": int(not (interrupted or failure)),
        "failure": failure or "",
        **provenance(asked, described, clock.perf_counter() - begun),
    }


def structure(machine: Machine) -> str:
    """A fingerprint of the machine's equations."""
    s = machine.system
    return hashlib.sha256(repr((s.states, s.definitions, s.derivatives)).encode()).hexdigest()[:16]
