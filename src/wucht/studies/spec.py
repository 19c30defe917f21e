"""A study in the form of version 0.1: the class of its keys, and five functions in its module or package.

``prepare(spec, subject) -> plan``, ``run(plan, work) -> iterator of findings``, ``dataset(plan, findings) -> Dataset``,
``figure(Dataset) -> Figure``, ``report(Dataset) -> lines``. A long one is a package: ``prepare`` and ``run`` are in its module
``computation``, ``dataset`` and ``report`` in ``dataset``, or each is in a module of its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from inspect import signature
from pathlib import Path as FilePath
from types import ModuleType
from typing import TYPE_CHECKING, Any

from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.studies.key_types import *  # noqa: F403
from wucht.studies.study import AVERAGED_EQUATIONS as AVERAGED_EQUATIONS  # noqa: PLC0414
from wucht.studies.study import FULL_EQUATIONS as FULL_EQUATIONS  # noqa: PLC0414
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_FUNCTIONS = ("prepare", "run", "dataset", "figure", "report")
_MODULES = {"prepare": "computation", "run": "computation", "report": "dataset"}


@dataclass(frozen=True)
class FindingsAnswer:
    """The answer of such a study: its Dataset is built when it is needed."""

    to_dataset: Callable[[], xr.Dataset]


class Spec(Study):
    """The keys of a study whose functions stand beside the class, or in the modules of its package."""

    @classmethod
    def check_class(cls) -> None:
        """The functions stand after the class: they are checked in ``prepare``."""

    @classmethod
    def _place(cls) -> str:
        return cls.__module__.removesuffix(".spec")

    @classmethod
    def _module(cls, part: str) -> ModuleType:
        whole = import_module(cls._place())
        for name in (part, _MODULES.get(part, part)) if hasattr(whole, "__path__") else ():
            if find_spec(f"{cls._place()}.{name}") is not None:
                return import_module(f"{cls._place()}.{name}")
        return whole

    @classmethod
    def _function(cls, name: str) -> Any:
        try:
            return getattr(cls._module(name), name)
        except AttributeError:
            raise WuchtError(f"the study {cls.kind!r} ({cls._place()}) has no function {name!r}") from None

    def prepare(self, subject: Any, watch: Callable[[], None] | None = None) -> Any:
        """See ``Study``. Raises ``WuchtError`` if a function of the study is missing."""
        for name in _FUNCTIONS:
            if not callable(self._function(name)):
                raise WuchtError(f"the study {self.kind!r} ({self._place()}): {name} must be a function")
        prepare = self._function("prepare")
        return prepare(self, subject, watch) if "watch" in signature(prepare).parameters else prepare(self, subject)

    def solve(self, subject: Any, prepared: Any, work: Work) -> Iterator[Any]:
        """See ``Study``."""
        dataset = self._function("dataset")
        for findings in self._function("run")(prepared, work):
            yield FindingsAnswer(lambda findings=findings: dataset(prepared, findings))  # type: ignore[misc]

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        figure: Figure = self._function("figure")(result)
        return figure

    def report(self, result: xr.Dataset) -> list[str]:
        """See ``Study``."""
        lines: list[str] = self._function("report")(result)
        return lines

    def stored_numbers(self, prepared: Any) -> float:
        """See ``Study``: by ``numbers(plan)`` in the module of ``prepare``."""
        count_numbers = getattr(self._module("prepare"), "numbers", None)
        return float(count_numbers(prepared)) if count_numbers is not None else 0.0

    def export(self, result: xr.Dataset, folder: FilePath) -> list[str]:
        """See ``Study``: by ``export(Dataset, folder)`` in a module ``export``."""
        lines: list[str] = self._function("export")(result, folder)
        return lines

    @classmethod
    def exports(cls) -> bool:
        """True if there is such a module."""
        return hasattr(cls._module("export"), "export")
