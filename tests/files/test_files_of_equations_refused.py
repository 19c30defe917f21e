"""Files of equations that cannot be run: each is refused with one sentence that names the key, before anything is computed."""

from __future__ import annotations

from pathlib import Path

import pytest

from wucht.errors import InputError
from wucht.studies.study_file import read_study

LORENZ = 'states = { x = "s*(y - x)", y = "r*x - y - x*z", z = "x*y - b*z" }\nparameters = { s = 10.0, r = 28.0, b = 2.6 }\n'
DECAY = 'states = { x = "-x" }\n'
RUN = '[study]\nkind = "run-up"\n'
BASIN = '[study]\nkind = "basin"\naxes = { x = [-1, 1, 4], '
CASES = {
    "unknown key": (LORENZ + 'angels = ["x"]\n' + RUN, "system.angels", ("angles",)),
    "state without equation": ('states = { x = "v" }\n' + RUN, "system.states.x", ("v",)),
    "division by zero": ('states = { x = "1/0" }\n' + RUN, "system.states.x", ()),
    "name of a function": ('states = { sin = "1" }\n' + RUN, "system.states.sin", ("function",)),
    "no angle": (DECAY + 'angles = ["x"]\n' + RUN, "system.angles", ("x",)),
    "start with a unit": (DECAY + RUN + 'start = { x = "1 mm" }\n', "study.start.x", ("x",)),
    "start of no state": (DECAY + RUN + "starts = [{}, { y = 1.0 }]\n", "study.starts[1].y", ("x",)),
    "singular start": ('states = { x = "log(x)" }\n' + RUN + "start = { x = -1.0 }\n", "study.start", ("x",)),
    "singular at a value": (
        'states = { x = "1/a - x" }\nparameters = { a = 1.0 }\n' + RUN + 'along = "a"\nvalues = [1.0, 0.0]\n',
        "system.parameters", ("a = 0",),
    ),
    "value not finite": (LORENZ + RUN + 'along = "r"\nvalues = [1.0, nan]\n', "study.values[1]", ("r",)),
    "key of machines": (DECAY + RUN + "turns = 3\n", "study.turns", ("machine",)),
    "axis of no state": (LORENZ + BASIN + "w = [-1, 1, 4] }\n", "study.axes.w", ("x", "y", "z")),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_it_is_refused(name: str, tmp_path: Path) -> None:
    text, key, naming = CASES[name]
    path = tmp_path / "equations.toml"
    path.write_text(f"[system]\n{text}", encoding="utf-8")
    with pytest.raises(InputError) as raised:
        study = read_study(path)
        study.spec.prepare(study.subject)
    assert raised.value.location.endswith(key)
    sentence = str(raised.value)
    assert "\n" not in sentence and all(word in sentence for word in naming)
