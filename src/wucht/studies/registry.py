"""Studies by kind: those of the entry points ``wucht.studies``, and those whose modules are imported.

An entry point names a class, ``module:Class``. A module that has a class of this kind, also a package with it in its module
``study`` or ``spec``, is accepted, with a warning where it stands in another package. A template is a file ``template.toml`` of
a package, one with the name of a module beside it, or a text ``template`` of the module; without any ``wucht new`` makes one
from the keys.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib import import_module
from importlib.metadata import entry_points
from importlib.resources import files
from importlib.util import find_spec
from textwrap import wrap
from typing import Any
from warnings import warn

from wucht.errors import InputError, WuchtError
from wucht.schema import Key, choice, keys_of, prose_of
from wucht.studies.study import Study

GROUP = "wucht.studies"
_CLASS_MODULES = ("study", "spec")  # of a package, with its class


@dataclass(frozen=True)
class StudyEntry:
    """A kind of study and its place, ``module:Class`` or a module. Its class is loaded when it is used, unless it is given."""

    kind: str
    place: str
    loaded_class: type[Study] | None = field(default=None, compare=False)

    @property
    def package(self) -> str:
        """The module, or of a package the package itself."""
        module = self.place.partition(":")[0]
        package, _, last = module.rpartition(".")
        return package if last in _CLASS_MODULES else module

    @cached_property
    def study(self) -> type[Study]:
        """The class. Raises ``WuchtError`` if it cannot be loaded."""
        if self.loaded_class is not None:
            return self.loaded_class
        module, _, name = self.place.partition(":")
        try:
            candidates = [vars(import_module(module)).get(name)] if name else self._classes(module)
        except Exception as error:
            if module.startswith("wucht."):
                raise
            raise WuchtError(f"the study {self.kind!r} ({self.place}) cannot be loaded: {error}", code="not-loaded") from error
        for candidate in candidates:
            if isinstance(candidate, type) and issubclass(candidate, Study) and candidate.kind == self.kind:
                if not name and not module.startswith("wucht."):
                    successor = f"{candidate.__module__}:{candidate.__name__}"
                    advice = f"the entry point {self.kind!r} of {GROUP} names a module; name its class, {successor}"
                    warn(advice, FutureWarning, stacklevel=2)
                return candidate
        raise WuchtError(f"the study {self.kind!r} ({self.place}) has no class of that kind", code="not-loaded")

    def _classes(self, module: str) -> list[Any]:
        whole = import_module(module)
        within = [f"{module}.{name}" for name in _CLASS_MODULES if hasattr(whole, "__path__") and find_spec(f"{module}.{name}")]
        return [candidate for one in (whole, *map(import_module, within)) for candidate in vars(one).values()]

    @property
    def line(self) -> str:
        """The study in one line, or the reason why it cannot be loaded."""
        try:
            return prose_of(self.study).partition("\n")[0]
        except WuchtError as error:
            return str(error).partition("\n")[0]

    @property
    def has_tiles(self) -> bool:
        """True if several machines can compute the study; False if it cannot be loaded."""
        try:
            return self.study.tiled
        except WuchtError:
            return False

    @property
    def drawer(self) -> Study:
        """A study without keys, for the figure, the report and the files of a result: they follow from the Dataset alone."""
        return self.study.__new__(self.study)

    @property
    def template(self) -> str:
        """The commented study file to start from: a given one, or one made from the keys of the study."""
        whole = import_module(self.package)
        package, _, module = self.package.rpartition(".")
        if hasattr(whole, "__path__"):
            file = files(self.package).joinpath("template.toml")
        elif package:
            file = files(package).joinpath(f"{module}.toml")
        else:
            file = None
        if file is not None and file.is_file():
            return file.read_text(encoding="utf-8")
        return str(getattr(whole, "template", None) or template_from_keys(self.study))


@cache
def _installed_studies() -> dict[str, StudyEntry]:
    by_kind: dict[str, StudyEntry] = {}
    for entry in entry_points(group=GROUP):
        _add_study(by_kind, StudyEntry(entry.name, entry.value), entry.value)
    return by_kind


def _add_study(by_kind: dict[str, StudyEntry], entry: StudyEntry, source: str) -> None:
    """Add a study to the registry. Raises ``InputError`` if another one has its kind."""
    present, loaded_class = by_kind.setdefault(entry.kind, entry), entry.loaded_class
    is_same = present.place == entry.place if ":" in present.place else present.package == entry.package
    if not is_same and (loaded_class is None or present.study is not loaded_class):
        requirement = f"not allowed: {present.place} has a study of this kind; choose another name"
        raise InputError(f"kind of {source}", entry.kind, requirement)


def studies() -> dict[str, StudyEntry]:
    """All studies by kind. Raises ``InputError`` if two have the same kind."""
    by_kind = dict(_installed_studies())
    pending = list(Study.__subclasses__())
    while pending:
        cls = pending.pop()
        pending += cls.__subclasses__()
        if cls.kind and "kind" in vars(cls):
            place = f"{cls.__module__}:{cls.__name__}"
            _add_study(by_kind, StudyEntry(cls.kind, place, cls), place)
    return dict(sorted(by_kind.items()))


def study_of(kind: str) -> StudyEntry:
    """The study of a kind. Raises ``InputError`` with the nearest known one."""
    return requested_study({"kind": kind})


def requested_study(table: Mapping[str, Any]) -> StudyEntry:
    """The study requested by a table ``[study]``. Raises ``InputError`` with the nearest known one."""
    by_kind = studies()
    return by_kind[choice(table, "kind", "study", by_kind)]


_MACHINE = """[machine]
use = "practice/laundry-drum"    # a name from `wucht list`, a file, or the tables of a machine

"""


def template_from_keys(study: type[Study]) -> str:
    """A commented study file with all keys of a study, commented out with ``#``."""
    heading = wrap(" ".join((prose_of(study) or study.kind).split("\n\n")[0].split()), 126)
    lines = ["A study file of wucht. Run it:   wucht run THIS-FILE -o results", *heading]
    machine = _MACHINE if study.subject == Study.subject else ""
    keys = "\n".join(_line(key) for key in keys_of(study))
    return "".join(f"# {line}\n" for line in lines) + f'title = "My study"\n\n{machine}[study]\nkind = "{study.kind}"\n{keys}\n'


def _line(key: Key) -> str:
    value = "..." if key.default is None else _toml(key.default)
    texts = (key.what.replace("`", ""), key.unit and f"in {key.unit}", key.allowed, "needed" if key.needed else "")
    return f"# {f'{key.name} = {value}':30} # {'; '.join(filter(None, texts))}"


def _toml(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
