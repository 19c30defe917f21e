"""A machine in a few words, and as a small table for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from wucht.fields import Parameter
from wucht.machines.parts.base import Drive
from wucht.machines.tree import RotatingBody, SlidingBody


def in_words(
    title: str, bodies: Sequence[RotatingBody | SlidingBody], drives: Iterable[Drive], parameters: Mapping[str, Parameter]
) -> str:
    """Title, bodies, drives and the number of parameters, in two lines."""
    driven = [f"{d.kind} on {d.on}" for d in drives]
    held = f"{'drive' if len(driven) == 1 else 'drives'} {', '.join(driven)}; " if driven else ""
    return f"<Machine {title!r}\n {', '.join(map(_body, bodies))}; {held}{len(parameters)} parameters>"


def as_table(
    title: str, bodies: Sequence[RotatingBody | SlidingBody], drives: Iterable[Drive], parameters: Mapping[str, Parameter]
) -> str:
    """HTML: bodies, drives, and every parameter with its value and unit."""
    rows = [(_body(b), "", f"on {b.about or 'the carrier'}") for b in bodies]
    rows += [(f"{d.kind} drive", "", f"on {d.on}") for d in drives]
    rows += [(path, f"{p.value:.6g} {p.unit}".rstrip(), p.what) for path, p in parameters.items()]
    cells = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><caption>{escape(title)}</caption>{cells}</table>"


def _body(body: RotatingBody | SlidingBody) -> str:
    return f"{body.kind} {body.name}" if body.kind != body.name else body.name
