"""Equal bodies: one table with a ``count`` describes several, named by numbers."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, model_validator

from wucht.errors import InputError
from wucht.files.documents import Document
from wucht.machines.parts import bodies as body_kinds
from wucht.machines.parts.track import TrackBody
from wucht.machines.tracks import angular_width
from wucht.schema import Key, TableModel, Unit, choice, keys_of, validate_table

_KEYS = ("count", "start", "seed")


def _read_start(value: Any) -> Any:
    return (
        value
        if value in ("even", "random")
        else Unit("rad", "position at the start: 'even', 'random', or an angle").parse_quantity(value)
    )


class EqualBodies(TableModel):
    """Number of equal bodies that a table describes, and their start angles about the body that they turn about."""

    count: int = Field(ge=1, le=100, description="number of equal bodies, named NAME1, NAME2 and so on")
    start: Annotated[Literal["even", "random"] | float, BeforeValidator(_read_start)] = Field(
        default="even",
        description="position at the start: even, random, or an angle in rad from the body turned about; without it, bodies "
        "hang where gravity acts and the study has no start",
    )
    seed: int | None = Field(default=None, ge=0, description="seed of the random positions")

    @model_validator(mode="after")
    def _check_seed(self) -> EqualBodies:
        if self.seed is not None and "start" not in self.model_fields_set:
            raise ValueError("seed", 'allowed only with start = "random"')
        return self

    def angles(self, width: float) -> list[float]:
        """Start angles in rad. width: the angle that each body needs on its track, 0 where they can pass each other.

        Evenly spaced; or at random, each arrangement without overlap being equally likely (the gaps between neighbours are
        those of points drawn on the free part of the track); or side by side about one angle.
        """
        count, offsets = self.count, np.arange(self.count) * width
        if self.start == "even":
            angles = np.arange(count) * 2 * math.pi / count
        elif self.start == "random":
            rng = np.random.default_rng(self.seed or 0)
            after_first = np.sort(rng.uniform(0.0, 2 * math.pi - count * width, count - 1))
            angles = np.append(0.0, after_first) + offsets + rng.uniform(0.0, 2 * math.pi)
        else:
            angles = self.start + offsets - offsets.mean()
        return [float(a) for a in angles]


def keys_in_files(cls: type[BaseModel]) -> tuple[Key, ...]:
    """The keys of a part in a file: those of its class, and of bodies that may be several also those of ``EqualBodies``."""
    if not issubclass(cls, TrackBody):
        return keys_of(cls)
    more = tuple(replace(k, needed=False) for k in keys_of(EqualBodies))
    return (*(k for k in keys_of(cls) if k.name not in {m.name for m in more}), *more)


def group_settings_first(document: Document, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings by path, first those of all bodies of a ``count``: settings of one of them take precedence."""
    several = _groups(document)
    return dict(sorted(settings.items(), key=lambda setting: setting[0].partition(".")[0] not in several))


def addresses_one_body(document: Document, path: str) -> bool:
    """True if a path addresses one of the bodies that a table describes."""
    head = path.partition(".")[0]
    return any(head.startswith(name) and head.removeprefix(name).isdigit() for name in _groups(document))


def _groups(document: Document) -> list[str]:
    """The names of the tables that describe several bodies."""
    tables = document.get("bodies")
    return [str(t["name"]) for t in tables if _is_group(t) and "name" in t] if isinstance(tables, list) else []


def count_of_bodies(document: Document) -> int:
    """Return the number of bodies that a machine's table describes, as far as it can be read: faults are reported later."""
    tables = document.get("bodies")
    counts = [t["count"] if _is_group(t) else 1 for t in tables] if isinstance(tables, list) else []
    return sum(n if isinstance(n, int) and n > 0 else 1 for n in counts)


def with_equal_bodies(document: Document) -> Document:
    """A copy of the machine's table in which each table with a ``count`` is replaced by those of its bodies.

    They are named NAME1, NAME2 and so on. Raises ``InputError`` for an invalid count, start or seed, for bodies that cannot be
    several, and for faults of the bodies themselves.
    """
    tables = document.get("bodies")
    if not isinstance(tables, list) or not any(map(_is_group, tables)):
        return document
    single_bodies: list[Any] = []
    for i, description in enumerate(tables):
        single_bodies += (
            _expand_group(description, f"machine.bodies[{i}] ({description.get('name', '')})")
            if _is_group(description)
            else [description]
        )
    return {**document, "bodies": single_bodies}


def _is_group(description: Any) -> bool:
    return isinstance(description, dict) and "count" in description


def _expand_group(description: Document, location: str) -> list[Document]:
    one = {key: value for key, value in description.items() if key not in _KEYS}
    kinds = body_kinds()
    cls = kinds[choice(description, "kind", location, kinds)]
    if not issubclass(cls, TrackBody):
        allowed_kinds = ", ".join(kind for kind, of_kind in kinds.items() if issubclass(of_kind, TrackBody))
        explanation = f"not allowed for this kind of body; allowed for: {allowed_kinds}"
        raise InputError(f"{location}.count", description["count"], explanation, code="not-allowed")
    equal = validate_table(EqualBodies, {key: description[key] for key in _KEYS if key in description}, location)
    body = validate_table(cls, {key: value for key, value in one.items() if key != "kind"}, location)
    width = 0.0 if body.track is None else angular_width(body, body)
    if equal.count * width > 2 * math.pi:
        explanation = f"must be at most {int(2 * math.pi / width)}: more do not fit on the track"
        raise InputError(f"{location}.count", equal.count, explanation, code="limits")
    if body.track is not None and "start" not in equal.model_fields_set:  # a track spaces its bodies evenly, unless they hang
        return [copy.deepcopy(one) | {"name": f"{body.name}{k}"} for k in range(1, equal.count + 1)]
    return [copy.deepcopy(one) | {"name": f"{body.name}{k}", "start": angle} for k, angle in enumerate(equal.angles(width), 1)]
