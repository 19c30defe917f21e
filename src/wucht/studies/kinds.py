"""The kinds of studies. Each is a module with a frozen question and a function from a machine and it to a Dataset."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from wucht.machines.machine import Machine

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float, float], None]
Checkpoint = Callable[["xr.Dataset"], None]


class Question(Protocol):
    """A frozen dataclass: what is asked."""

    kind: ClassVar[str]
    keys: ClassVar[tuple[str, ...]]

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> Question:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        ...

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the question does not fit the machine."""
        ...


class Answer(Protocol):
    """The function that answers a question."""

    def __call__(
        self,
        machine: Machine,
        question: Any,
        progress: Progress | None = None,
        checkpoint: Checkpoint | None = None,
        resume: xr.Dataset | None = None,
    ) -> xr.Dataset:
        """The result, with the attributes of ``studies.attributes``."""
        ...


@dataclass(frozen=True)
class Kind:
    """A kind of study: the module, its question and its function, loaded when used."""

    module: str
    question_name: str
    answer_name: str

    @property
    def question(self) -> type[Question]:
        """The class of the question."""
        found: type[Question] = getattr(import_module(self.module), self.question_name)
        return found

    @property
    def answer(self) -> Answer:
        """The function that answers it."""
        found: Answer = getattr(import_module(self.module), self.answer_name)
        return found


STUDIES = {
    "run-up": Kind("wucht.studies.run_up", "RunUp", "run_up"),
    "coast-down": Kind("wucht.studies.coast_down", "CoastDown", "coast_down"),
    "sweep": Kind("wucht.studies.sweep", "Sweep", "sweep"),
    "response": Kind("wucht.studies.response", "Response", "response"),
    "torque-balance": Kind("wucht.studies.torque_balance", "TorqueBalance", "torque_balance"),
    "approximation": Kind("wucht.studies.approximation", "Approximation", "approximation"),
    "entrainment": Kind("wucht.studies.entrainment", "Entrainment", "entrainment"),
    "synchronous-states": Kind("wucht.studies.synchronous_states", "SynchronousStates", "synchronous_states"),
}
NOT_YET = (
    "speed-curve", "orbit-branch", "stability-map", "phase-portrait",
    "basin", "capture-probability", "optimise-balancer", "load-spectrum", "exciter-design", "cam-law", "cam-contour",
    "cam-correction", "cam-prediction",
)  # fmt: skip
