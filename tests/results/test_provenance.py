"""A result is as wucht wrote it, or it is refused with the name of what differs; one that was edited ends in one sentence."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from wucht import InputError
from wucht.results.output_folder import load_result
from wucht.results.provenance import CHECKSUMS, verify_checksums, with_checksums
from wucht.results.store import save

Command = Callable[..., Any]
ATTRIBUTES = {
    "study": "torque-balance", "title": "A drum", "summary": "{}", "sentence": "It turns.", "warnings": "[]", "failure": "",
    "finished": 1, "dimensionless": 0, "input": '{"study": {}, "machine": {}}', "contents": "[]",
}  # fmt: skip


def raw(path: Path | str) -> xr.Dataset:
    """As another program reads it."""
    return xr.load_dataset(path, engine="h5netcdf")


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(
    values=npst.arrays(
        st.sampled_from([np.float64, np.float32, np.int64, np.int8, np.bool_, np.complex128]), npst.array_shapes(min_dims=0)
    ),
    texts=st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\0")), min_size=1),
    unit=st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1),
)
def test_what_netcdf_keeps_has_the_checksum_it_was_written_with(values: np.ndarray, texts: list[str], unit: str) -> None:
    """Whatever the type: with values that are not numbers, infinite, of either sign of zero."""
    dimensions = tuple(f"d{k}" for k in range(values.ndim))
    written = xr.Dataset({"v": (dimensions, values, {"units": unit}), "t": ("text", texts)}, attrs=ATTRIBUTES)
    read = xr.load_dataset(with_checksums(written).to_netcdf(engine="h5netcdf"), engine="h5netcdf")
    assert CHECKSUMS not in verify_checksums(read).attrs


def test_each_change_is_named(tmp_path: Path) -> None:
    result = xr.Dataset(
        {"speed": ("time", [1.0, 2.0], {"units": "rad/s"}), "name": ("rotor", ["a", "b"])}, {"time": [0.0, 1.0]}, ATTRIBUTES
    )
    file = save(result, tmp_path / "result.nc")
    whole = raw(file)
    changes: dict[str, tuple[str, Callable[[xr.Dataset], xr.Dataset]]] = {
        "a value, by one unit in the last place": (
            "speed", lambda r: r.assign(speed=r.speed.copy(data=[1.0, np.nextafter(2.0, 3.0)]))
        ),
        "a unit": ("speed", lambda r: r.assign(speed=r.speed.assign_attrs(units="rpm"))),
        "a type": ("speed", lambda r: r.assign(speed=r.speed.astype("float32"))),
        "a coordinate": ("time", lambda r: r.assign_coords(time=[0.0, 2.0])),
        "a text": ("name", lambda r: r.assign(name=("rotor", ["a", "c"]))),
        "the name of a dimension": ("name", lambda r: r.rename_dims(rotor="body")),
        "a variable less": ("name", lambda r: r.drop_vars("name")),
        "a variable more": ("mass", lambda r: r.assign(mass=1.0)),
        "an attribute": ("its attributes", lambda r: r.assign_attrs(sentence="It stands.")),
        "the checksums": ("checksums", lambda r: r.assign_attrs({CHECKSUMS: "{"})),
        "a checksum": ("speed", lambda r: r.assign_attrs({CHECKSUMS: json.dumps(json.loads(r.checksums) | {"speed": 1})})),
    }  # fmt: skip
    for what, (name, change) in changes.items():
        change(whole.copy(deep=True)).to_netcdf(file, engine="h5netcdf")
        with pytest.raises(InputError) as error:
            load_result(file)
        assert error.value.key == name, what
        assert str(file) in str(error.value), what


def test_a_changed_dataset_can_be_saved_again(tmp_path: Path) -> None:
    """Its checksums are gone when it is read, as from a file that had none."""
    result = load_result(save(xr.Dataset({"speed": ("time", [1.0, 2.0])}, attrs=ATTRIBUTES), tmp_path / "a.nc"))
    assert CHECKSUMS not in result.attrs
    (2 * result).assign_attrs(result.attrs).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    assert load_result(tmp_path / "b.nc").speed.values.tolist() == [2.0, 4.0]


@pytest.fixture
def edited(wucht: Command, study: Callable[..., Path]) -> Callable[..., None]:
    """``edited(change)``: the result of a small run, changed, in a file without checksums."""
    if not Path("out").exists():
        assert wucht("run", study('until = "0.5 s"', 'until = "0.02 s"'), "-o", "out").code == 0

    whole = load_result(Path("out/result.nc"))

    def write(change: Callable[[xr.Dataset], xr.Dataset]) -> None:
        change(whole.copy()).to_netcdf("edited.nc", engine="h5netcdf")

    return write


EDITS: dict[str, tuple[str, Callable[[xr.Dataset], xr.Dataset]]] = {
    "another study": ("basin: this is not a complete result", lambda r: r.assign_attrs(study="basin", contents="[]")),
    "no study": ("nothing", lambda r: r.assign_attrs(study="nothing")),
    "a study that is a path": ("'../../x'", lambda r: r.assign_attrs(study="../../x")),
    "a study that is a number": ("study: given 3", lambda r: r.assign_attrs(study=3)),
    **{f"no {name}": (f"{name}: this attribute of the result is missing", lambda r, name=name: _without(r, name))
       for name in ("summary", "finished", "warnings")},
    **{f"{name}: {wrong}": (f"{name}: given {wrong!r}", lambda r, name=name, wrong=wrong: r.assign_attrs({name: wrong}))
       for name, wrong in (("summary", "x"), ("summary", "[]"), ("input", "3"), ("notes", "{}"), ("contents", "x"),
                           ("quantities", "3"), ("quantities", '{"a": {"unit": 3}}'), ("parts", '[{"on": 3}]'))},
    "a number that is none": ("finished: given '1'", lambda r: r.assign_attrs(finished="1")),
    "too deep": ("summary: given '[[", lambda r: r.assign_attrs(summary="[" * 10**5)),
    "a question without a machine": ("tables of the question and the machine", lambda r: r.assign_attrs(input='{"study": {}}')),
    "warnings that are no texts": ("warnings: given '[1]'", lambda r: r.assign_attrs(warnings="[1]")),
    "no outcome": ("run-up: this is not a complete result", lambda r: r.assign_attrs(summary="{}")),
    "no time": ("run-up: this is not a complete result", lambda r: r.isel(time=slice(0, 0))),
    "a variable less": ("time is missing", lambda r: r.drop_vars("time")),
    "all without a value": ("", lambda r: r.map(lambda v: v * np.nan if v.dtype.kind == "f" else v, keep_attrs=True)),
}  # fmt: skip


def _without(result: xr.Dataset, name: str) -> xr.Dataset:
    del result.attrs[name]
    return result


@pytest.mark.slow
@pytest.mark.usefixtures("unpainted")
def test_an_edited_result_ends_in_one_sentence(edited: Callable[..., None], wucht: Command) -> None:
    for number, (what, (sentence, change)) in enumerate(EDITS.items()):
        edited(change)
        commands = (("plot", "edited.nc", "-o", "drawn"), ("compare", "edited.nc", "out", "-o", "compared"))
        for words in commands[: 1 + (number % 8 == 0)]:
            done = wucht(*words)
            if what == "all without a value" or (words[0] == "compare" and done.code == 0):
                continue  # it may be drawn empty, and be compared by what it has
            assert done.code == 2, what
            assert done.err.startswith("wucht: edited.nc"), what
            assert done.err.count("\n") == 1, what
            assert sentence in done.err, what
    assert not list(Path().glob("**/x.*"))
