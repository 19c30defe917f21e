"""A study file to start from, made of the keys of a study."""

from __future__ import annotations

import json
from textwrap import wrap
from typing import Any

from wucht.schema import Key, keys_of
from wucht.studies.spec import Spec

_MACHINE = """[machine]
use = "practice/laundry-drum"    # a name from `wucht list`, a file, or the tables of a machine of your own

"""


def template_from_keys(spec: type[Spec]) -> str:
    """A commented study file: all keys of a spec, those that may be left out behind ``#``."""
    heading = wrap(" ".join((spec.__doc__ or spec.kind).split("\n\n")[0].split()), 126)
    lines = ["A study file of wucht. Run it:   wucht run THIS-FILE -o results", *heading]
    machine = _MACHINE if spec.subject == Spec.subject else ""
    keys = "\n".join(_line(key) for key in keys_of(spec))
    return "".join(f"# {line}\n" for line in lines) + f'title = "My study"\n\n{machine}[study]\nkind = "{spec.kind}"\n{keys}\n'


def _line(key: Key) -> str:
    value = "..." if key.default is None else _toml(key.default)
    texts = (key.what.replace("`", ""), key.unit and f"in {key.unit}", key.allowed, "needed" if key.needed else "")
    return f"# {f'{key.name} = {value}':30} # {'; '.join(filter(None, texts))}"


def _toml(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
