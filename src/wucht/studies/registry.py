"""Studies are found, not registered: by the entry points ``wucht.studies``, and among the specs of modules that are loaded.

A study is a package with the modules ``spec``, ``prepare``, ``run``, ``dataset``, ``figure``, ``report``, each with a function
of that name (``spec`` has the class), and ``template.toml``; or one module with all of these functions and a text ``template``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from importlib.metadata import entry_points
from importlib.resources import files
from importlib.util import find_spec
from types import ModuleType
from typing import Any

from wucht.checking import choice
from wucht.errors import WuchtError
from wucht.studies.spec import Spec

GROUP = "wucht.studies"
NOT_YET = (
    "speed-curve", "orbit-branch", "stability-map", "phase-portrait",
    "basin", "capture-probability", "optimise-balancer", "load-spectrum", "exciter-design", "cam-law", "cam-contour",
    "cam-correction", "cam-prediction",
)  # fmt: skip


@dataclass(frozen=True)
class Study:
    """A kind of study, and the package or module that it is. Its parts are loaded when they are used."""

    kind: str
    package: str

    def _module(self, part: str) -> ModuleType:
        whole = import_module(self.package)
        inside = hasattr(whole, "__path__") and find_spec(f"{self.package}.{part}") is not None
        return import_module(f"{self.package}.{part}") if inside else whole

    def _part(self, name: str) -> Any:
        try:
            return getattr(self._module(name), name)
        except AttributeError:
            raise WuchtError(f"the study {self.kind!r} ({self.package}) has no function {name!r}") from None

    @cached_property
    def spec(self) -> type[Spec]:
        """The class of its questions."""
        module = self._module("spec")
        for candidate in vars(module).values():
            if isinstance(candidate, type) and issubclass(candidate, Spec) and candidate.kind == self.kind:
                return candidate
        raise WuchtError(f"the study {self.kind!r} ({self.package}) has no spec of that kind")

    @property
    def prepare(self) -> Any:
        """(spec, subject) -> plan."""
        return self._part("prepare")

    @property
    def run(self) -> Any:
        """(plan, work) -> iterator of findings, each more complete than that before."""
        return self._part("run")

    @property
    def dataset(self) -> Any:
        """(plan, findings) -> Dataset."""
        return self._part("dataset")

    @property
    def figure(self) -> Any:
        """Dataset -> Figure."""
        return self._part("figure")

    @property
    def report(self) -> Any:
        """Dataset -> lines of text."""
        return self._part("report")

    @property
    def template(self) -> str | None:
        """The commented study file to start from, if it has one."""
        whole = import_module(self.package)
        if not hasattr(whole, "__path__"):
            return getattr(whole, "template", None)
        file = files(self.package).joinpath("template.toml")
        return file.read_text(encoding="utf-8") if file.is_file() else None


@cache
def _installed() -> dict[str, Study]:
    return {entry.name: Study(entry.name, entry.value) for entry in entry_points(group=GROUP)}


def studies() -> dict[str, Study]:
    """All studies by kind."""
    known = dict(_installed())
    pending = list(Spec.__subclasses__())
    while pending:
        cls = pending.pop()
        pending += cls.__subclasses__()
        if cls.kind:
            known.setdefault(cls.kind, Study(cls.kind, cls.__module__.removesuffix(".spec")))
    return dict(sorted(known.items()))


def study_of(kind: str) -> Study:
    """The study of a kind. Raises ``InputError`` with the nearest known one."""
    return asked_study({"kind": kind})


def asked_study(table: Mapping[str, Any]) -> Study:
    """The study that a table ``[study]`` asks for. Raises ``InputError`` with the nearest known one."""
    known = studies()
    return known[choice(table, "kind", "study", known, NOT_YET)]
