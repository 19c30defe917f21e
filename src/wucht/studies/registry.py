"""Studies by kind: those of the entry points ``wucht.studies``, and those whose modules are imported.

A study is one module with the class of its spec and the functions ``prepare``, ``run``, ``dataset``, ``report``, ``figure``;
a long one is a package: the spec is in its module ``spec``, ``prepare`` and ``run`` are in ``computation``, ``dataset`` and
``report`` in ``dataset``, or each is in a module of its name. A template is a file ``template.toml`` of the package, one with
the module's name beside it, or a text ``template``; without any ``wucht new`` makes one from the keys.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from importlib.metadata import entry_points
from importlib.resources import files
from importlib.util import find_spec
from inspect import signature
from textwrap import wrap
from types import ModuleType
from typing import Any

from wucht.errors import InputError, WuchtError
from wucht.schema import Key, choice, keys_of, prose_of
from wucht.studies.spec import Spec

GROUP = "wucht.studies"
_FUNCTIONS = ("prepare", "run", "dataset", "figure", "report")
_MODULES = {"prepare": "computation", "run": "computation", "report": "dataset"}


def _part(name: str, doc: str) -> property:
    """Property for the function of a study with this name."""

    def part(study: Study) -> Any:
        try:
            return getattr(study._module(name), name)
        except AttributeError:
            raise WuchtError(f"the study {study.kind!r} ({study.package}) has no function {name!r}") from None

    return property(part, doc=doc)


@dataclass(frozen=True)
class Study:
    """A kind of study with its package or module. Its parts are loaded when they are used."""

    kind: str
    package: str

    def _module(self, part: str) -> ModuleType:
        try:
            whole = import_module(self.package)
        except Exception as error:
            if self.package.startswith("wucht."):
                raise
            raise WuchtError(
                f"the study {self.kind!r} ({self.package}) cannot be loaded: {error}", code="not-loaded"
            ) from error
        for name in (part, _MODULES.get(part, part)) if hasattr(whole, "__path__") else ():
            if find_spec(f"{self.package}.{name}") is not None:
                return import_module(f"{self.package}.{name}")
        return whole

    @cached_property
    def spec(self) -> type[Spec]:
        """The spec class of the study."""
        module = self._module("spec")
        for candidate in vars(module).values():
            if isinstance(candidate, type) and issubclass(candidate, Spec) and candidate.kind == self.kind:
                return candidate
        raise WuchtError(f"the study {self.kind!r} ({self.package}) has no spec of that kind")

    @property
    def line(self) -> str:
        """The study in one line, or the reason why it cannot be loaded."""
        try:
            return prose_of(self.spec).partition("\n")[0]
        except WuchtError as error:
            return str(error).partition("\n")[0]

    @property
    def has_tiles(self) -> bool:
        """True if several machines can compute the study; False if it cannot be loaded."""
        try:
            return self.spec.tiled
        except WuchtError:
            return False

    def check(self) -> None:
        """Raise ``WuchtError`` if a function of the study is missing, before anything is computed."""
        for name in _FUNCTIONS:
            if not callable(getattr(self, name)):
                raise WuchtError(f"the study {self.kind!r} ({self.package}): {name} must be a function")

    prepare = _part("prepare", "(spec, subject) -> plan.")

    def plan(self, spec: Spec, subject: Any, watch: Callable[[], None] | None) -> Any:
        """Prepare a study. watch: called often by a ``prepare`` that takes seconds, and has this argument."""
        prepare = self.prepare
        return prepare(spec, subject, watch) if "watch" in signature(prepare).parameters else prepare(spec, subject)

    run = _part("run", "(plan, work) -> iterator of findings, each more complete than that before.")
    dataset = _part("dataset", "(plan, findings) -> Dataset.")
    figure = _part("figure", "Dataset -> Figure.")
    report = _part("report", "Dataset -> lines of text.")

    def numbers(self, plan: Any) -> float:
        """Greatest number of values that a plan stores: ``numbers(plan)`` in the module of ``prepare``.

        Studies without it store little, as their points and cells are limited.
        """
        count_numbers = getattr(self._module("prepare"), "numbers", None)
        return float(count_numbers(plan)) if count_numbers is not None else 0.0

    @property
    def exports(self) -> bool:
        """True if results can be exported: a module ``export`` with (Dataset, folder) -> lines, one for each file."""
        return hasattr(self._module("export"), "export")

    export = _part("export", "(Dataset, folder) -> lines of text, one for each file it wrote.")

    @property
    def template(self) -> str:
        """The commented study file to start from: a given one, or one made from the keys of the spec."""
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
        return str(getattr(whole, "template", None) or template_from_keys(self.spec))


@cache
def _installed_studies() -> dict[str, Study]:
    by_kind: dict[str, Study] = {}
    for entry in entry_points(group=GROUP):
        _add_study(by_kind, Study(entry.name, entry.value), entry.value)
    return by_kind


def _add_study(by_kind: dict[str, Study], study: Study, source: str) -> None:
    """Add a study to the registry. Raises ``InputError`` if another one has its kind."""
    if by_kind.setdefault(study.kind, study) != study:
        requirement = f"not allowed: {by_kind[study.kind].package} has a study of this kind; choose another name"
        raise InputError(f"kind of {source}", study.kind, requirement)


def studies() -> dict[str, Study]:
    """All studies by kind. Raises ``InputError`` if two have the same kind."""
    by_kind = dict(_installed_studies())
    pending = list(Spec.__subclasses__())
    while pending:
        cls = pending.pop()
        pending += cls.__subclasses__()
        if cls.kind and "kind" in vars(cls):
            _add_study(by_kind, Study(cls.kind, cls.__module__.removesuffix(".spec")), f"{cls.__module__}.{cls.__name__}")
    return dict(sorted(by_kind.items()))


def study_of(kind: str) -> Study:
    """The study of a kind. Raises ``InputError`` with the nearest known one."""
    return requested_study({"kind": kind})


def requested_study(table: Mapping[str, Any]) -> Study:
    """The study requested by a table ``[study]``. Raises ``InputError`` with the nearest known one."""
    by_kind = studies()
    return by_kind[choice(table, "kind", "study", by_kind)]


_MACHINE = """[machine]
use = "practice/laundry-drum"    # a name from `wucht list`, a file, or the tables of a machine

"""


def template_from_keys(spec: type[Spec]) -> str:
    """A commented study file with all keys of a spec, commented out with ``#``."""
    heading = wrap(" ".join((prose_of(spec) or spec.kind).split("\n\n")[0].split()), 126)
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
