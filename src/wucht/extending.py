"""All names that a study or a part in another package needs, from one place.

A study is a class of ``Study`` with a ``kind``, its keys as fields, and the methods ``prepare(subject)``,
``solve(subject, prepared, work)``, which yields an ``Answer``, and ``draw(result) -> Figure`` (``examples/own_study.py``). A
part is a class of ``Body``, ``Drive``, ``Load`` or another ``Part`` with its energies (``examples/own_part.py``).
``--import`` or an entry point makes them known.

>>> from wucht.extending import RunSettings, load_machine, run_to_end
>>> motion = run_to_end(load_machine("drozdetskaya-2020/r1"), {"p1": 0.3, "p2": -0.5}, RunSettings(until=4.0))
>>> motion.verdict.outcome.value
'unidentified'
"""

from wucht.analysis.vibration import Vibration
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_to_end, run_up
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.earlier_names import provide_earlier_names
from wucht.errors import InputError, RunError, WuchtError
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Frame, Load, Part, Point
from wucht.machines.parts.support import Support
from wucht.mechanics.energies import Energies
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.plots.sheet import legend_below, legend_beside, new_figure, new_grid
from wucht.plots.style import COLOURS
from wucht.results.formatting import label
from wucht.schema import SI, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Engine, Interval, Pair, Path, Start, Tolerance, Values, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.runner import draw, export, load, report, run
from wucht.studies.study import Study

__all__ = [
    "COLOURS",
    "SI",
    "Answer",
    "Attachment",
    "Body",
    "Drive",
    "Energies",
    "Engine",
    "Frame",
    "InputError",
    "Interval",
    "Load",
    "Machine",
    "Motion",
    "NextQuestion",
    "Outcome",
    "Pair",
    "Part",
    "Path",
    "Point",
    "RunError",
    "RunSettings",
    "RunUpCase",
    "Start",
    "Study",
    "Support",
    "Tolerance",
    "Values",
    "Verdict",
    "Vibration",
    "Whole",
    "Work",
    "WuchtError",
    "compile_system",
    "draw",
    "export",
    "integrate",
    "label",
    "legend_below",
    "legend_beside",
    "load",
    "load_machine",
    "new_figure",
    "new_grid",
    "report",
    "run",
    "run_to_end",
    "run_up",
    "si",
]  # fmt: skip


provide_earlier_names(__name__)
