"""A question asked at every combination of values of several paths: a comparison whose result is over these paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.dynamics.work import Report
from wucht.errors import InputError
from wucht.file_names import printable
from wucht.studies.comparison.study import Comparison
from wucht.studies.comparison.variant_files import uniquely_named, variants_of_study
from wucht.studies.comparison.variants import ComparedVariants, VariedKey
from wucht.studies.runner import run
from wucht.studies.study import Study
from wucht.studies.study_file import StudyFile, with_keys
from wucht.studies.subjects import is_name, named_subject, subject_of

if TYPE_CHECKING:
    import xarray as xr

_QUESTION = "study."
_OF_VARIANTS = frozenset({"variant", "name", "source", "variant_number"})


class GridComparison(Comparison):
    """A comparison that is no table to be read: of any number of paths, and of many variants."""

    most_varied: ClassVar[int] = 16
    fewest: ClassVar[int] = 1
    most: ClassVar[int] = 100_000


def grid(
    question: Study,
    subject: Any,
    vary: Mapping[str, Sequence[Any]],
    *,
    processes: int = 1,
    folder: Path | str | None = None,
    resume: bool = False,
    progress: Report | None = None,
) -> xr.Dataset:
    """Ask a question at every combination of values of several paths.

    Parameters
    ----------
    question : Study
    subject : Machine or other subject of the study
        Or the path of a file, or a catalogue name, that has it: everything that can be set there can be varied.
    vary : mapping of str to sequence
        Values of each path, numbers in SI or texts with a unit, lists or arrays; keys of the question begin with ``study.``.
    processes : int
        Processes of this computer that compute.
    folder, resume, progress : see ``run``
        The folder gets the result as a comparison: ``wucht plot FOLDER`` draws it.

    Returns
    -------
    xarray.Dataset
        Its dimensions are the paths, with their values in SI. The numbers of the summaries are variables under the names that
        they have there (``final_phases.p1`` for a number of a table), NaN where one is missing; ``outcome``, ``sentence`` and
        ``failure``, the reason why a study failed or could not be run, are texts, empty where there is none; the curves of a
        comparison are ``curve_1_x``, ``curve_1_y``, ...

    Raises
    ------
    InputError
        For a path that does not exist, and any error that holds for all combinations: key, given value and requirement.

    Examples
    --------
    >>> import wucht
    >>> machine = wucht.load_machine("drozdetskaya-2020/r1")
    >>> question = wucht.RunUp(until=6.0, start={"p1": 0.3, "p2": -0.5})
    >>> result = grid(question, machine, {"drive.slope": [0.0195, 0.039], "drum.eccentricity": ["1 mm", "1.2 mm"]})
    >>> result.outcome.sel({"drive.slope": 0.039}).values.tolist()
    ['compensated', 'compensated']
    """
    if not isinstance(question, Study) or isinstance(question, Comparison):
        raise InputError("study", str(question), 'must be a question about one subject, such as wucht.RunUp(until="20 s")')
    if not isinstance(vary, Mapping) or not vary:
        raise InputError("study.vary", vary, 'must be lists of values by path: {"drive.slope": [0.01, 0.02], ...}')
    name = str(subject) if isinstance(subject, str | Path) else printable(getattr(subject, "title", "")).strip()
    spec = GridComparison(of=(name or question.kind,), vary=vary)
    variants = uniquely_named(variants_of_study(name, partial(_study_with, question, subject, name), {}, spec))
    keys = variants[0].keys
    title = f"{name or question.kind}, varied: {'; '.join(key.description for key in keys)}"
    options: dict[str, Any] = {"folder": folder, "resume": resume, "progress": progress, "processes": processes}
    return _result_over(run(spec, ComparedVariants(title, variants), **options), keys, spec.vary)


def _study_with(question: Study, subject: Any, name: str, values: Mapping[str, Any]) -> StudyFile:
    """The question and its subject with values by path, see ``grid``."""
    of_question = {path.removeprefix(_QUESTION): v for path, v in values.items() if path.startswith(_QUESTION)}
    of_subject = {path: v for path, v in values.items() if not path.startswith(_QUESTION)}
    spec = with_keys(question, of_question) if of_question else question
    if is_name(spec, subject):
        return StudyFile(Path(name), spec, named_subject(spec, subject, of_subject), {}, False)
    subject_of(spec).describe(subject)
    if of_subject and not hasattr(subject, "with_values"):
        path, value = next(iter(of_subject.items()))
        raise InputError(path, value, "values of this subject are varied in its file: give its path or catalogue name instead")
    return StudyFile(Path(name), spec, subject.with_values(of_subject) if of_subject else subject, {}, False)


def _result_over(result: xr.Dataset, keys: Sequence[VariedKey], vary: Mapping[str, Sequence[Any]]) -> xr.Dataset:
    """The result of a comparison over its paths instead of its variants; of one that was interrupted the rest is missing."""
    import xarray as xr_

    shape, variables = tuple(map(len, vary.values())), dict[str, Any]()
    for name, variable in result.variables.items():
        if variable.dims[:1] == ("variant",) and name not in _OF_VARIANTS and name not in vary:
            missing = np.nan if variable.dtype.kind == "f" else np.zeros((), variable.dtype)
            values = np.full((int(np.prod(shape)), *variable.shape[1:]), missing, variable.dtype)
            values[: len(variable)] = variable.values
            variables[str(name)] = (*vary, *variable.dims[1:]), values.reshape(*shape, *variable.shape[1:]), variable.attrs
    coordinates = {
        key.path: (key.path, np.array(key.to_si(list(vary[key.path]))), {"long_name": key.description, "units": key.unit or ""})
        for key in keys
    }
    return xr_.Dataset(variables, coordinates, result.attrs).set_coords([name for name in variables if name in result.coords])
