"""What tells two subjects apart: a hash of all that a result depends on, the same in every process.

Numbers count to their last bit, also within equations, where printing rounds them, and in the pieces of piecewise functions,
which print their name alone. Titles do not count, nor names of files, whose contents do.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import sympy as sp
from sympy.printing.str import StrPrinter

from wucht.machines.machine import Machine
from wucht.piecewise import Pieces
from wucht.system import System

_SILENT = frozenset({"title", "warnings", "notes", "parameters", "file"})  # those of parameters are stated one by one


class _Exactly(StrPrinter):  # type: ignore[misc]
    """SymPy expressions as strings from which they could be made again."""

    printmethod = "_exactly"  # not the expressions' own, which print what people read

    def _print_Float(self, number: sp.Float) -> str:
        return str(number._mpf_)

    def _print_Pieces(self, pieces: Pieces) -> str:
        return _text((pieces.breakpoints, pieces.coefficients))


def fingerprint_of_machine(machine: Machine) -> str:
    """Of a machine, but for the values of its parameters: of its parts and their energies, from which its equations follow."""
    return _hashed({f.name: getattr(machine, f.name) for f in fields(machine) if f.name not in _SILENT})


@lru_cache(maxsize=64)
def fingerprint_of_system(system: System) -> str:
    """Of equations, but for the values of their parameters."""
    return _hashed(system)


def _hashed(value: Any) -> str:
    return hashlib.sha256(_text(value).encode()).hexdigest()[:16]


def _text(value: Any) -> str:
    """A value as a string that is the same for equal values alone; whole numbers are those of floating point."""
    match value:
        case None | bool() | str():
            return repr(value)
        case int() | float():
            return float(value).hex()
        case sp.Basic() | sp.MatrixBase():
            return str(_Exactly().doprint(value))
        case Mapping():
            text = ",".join(f"{_text(key)}:{_text(each)}" for key, each in value.items())
        case set() | frozenset():
            text = ",".join(sorted(map(_text, value)))
        case _ if is_dataclass(value):
            text = _text({f.name: getattr(value, f.name) for f in fields(value) if f.name not in _SILENT})
        case Iterable():
            text = ",".join(map(_text, value))
        case _:
            raise TypeError(f"no fingerprint is known of a {type(value).__qualname__}")
    return f"{type(value).__qualname__}({text})"
