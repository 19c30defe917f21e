"""Results and records that are damaged or edited: whatever reads them says so in one sentence, or does not mind."""

from __future__ import annotations

import json
import os
import struct
import sys
import warnings
import wave
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.robustness import children, damage

from wucht.errors import WuchtError

if TYPE_CHECKING:
    import xarray as xr

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="what crashes takes its process with it: each is a fork")
STUDIES = {
    "run-up": ("study.until=0.3",), "coast-down": (), "torque-balance": (), "sweep": (), "comparison": (), "load-spectrum": (),
}  # fmt: skip


@pytest.fixture(scope="module")
def loaded() -> None:
    children.load_everything()


def tried(folder: Path, attempts: Callable[[], Iterator[tuple[str, Callable[[], object]]]]) -> dict[str, int]:
    """How many attempts went well and how many ended in a sentence; the test fails for all others, and names them."""
    (folder / "attempts").mkdir(parents=True)

    def run() -> int:
        warnings.simplefilter("ignore")
        counts = {"well": 0, "sentence": 0, "bad": 0}
        for name, attempt in attempts():
            sys.stderr.write(f"{name}\n")
            sys.stderr.flush()
            try:
                attempt()
                counts["well"] += 1
            except WuchtError as error:
                counts["sentence"] += 1
                if "\n" in str(error) or len(str(error)) > 5000:
                    counts["bad"] += 1
                    sys.stdout.write(f"{name}: {str(error)[:300]!r}\n")
            except Exception as error:
                counts["bad"] += 1
                sys.stdout.write(f"{name}: {type(error).__name__} {str(error)[:300]!r}\n")
        sys.stdout.write(f"{json.dumps(counts)}\n")
        return counts["bad"]

    ended = children.call(run, folder / "attempts")
    assert ended.code == 0, f"{ended.code} at {ended.sentence}\n{ended.out}"
    counts: dict[str, int] = json.loads(ended.out.splitlines()[-1])
    return counts


# Results
EVERY = 307  # of the edits


@pytest.fixture(scope="module", params=[k if k == "run-up" else pytest.param(k, marks=pytest.mark.slow) for k in STUDIES])
def result(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, loaded: None) -> Path:
    """The result of a study's own template."""
    folder, kind = tmp_path_factory.mktemp(request.param), request.param
    assert children.call(children.wucht("new", kind), folder).code == 0
    settings = [word for setting in STUDIES[kind] for word in ("--set", setting)]
    ended = children.call(children.wucht("run", f"{kind}.toml", "-o", "out", *settings), folder)
    assert ended.code == 0, ended.err
    return folder / "out" / "result.nc"


@pytest.mark.slow
def test_changed_bytes_of_a_result(result: Path, tmp_path: Path) -> None:
    """What is read all the same is what was written: there are bytes that mean nothing."""
    from wucht.results.output_folder import load_result

    whole, changed = result.read_bytes(), tmp_path / "result.nc"

    def read(expected: xr.Dataset) -> None:
        assert load_result(changed).identical(expected)

    def attempts() -> Iterator[tuple[str, Callable[[], object]]]:
        expected = load_result(result)
        for seed in range(16):
            changed.write_bytes(damage.bytes_changed(whole, seed))
            yield f"seed {seed}", lambda: read(expected)

    assert tried(tmp_path, attempts)["sentence"] > 8


@pytest.mark.slow
def test_edited_results(result: Path, tmp_path: Path) -> None:
    """Each is drawn, reported, exported, written as CSV and compared."""
    from wucht.results.output_folder import load_result
    from wucht.results.spreadsheets import save_csv
    from wucht.studies import runner
    from wucht.studies.study_file import read_comparison, run_study

    changed, written = tmp_path / "result.nc", tmp_path / "written"
    written.mkdir()

    def attempts() -> Iterator[tuple[str, Callable[[], object]]]:
        original = load_result(result)
        uses: dict[str, Callable[[], Any]] = {
            "draw": lambda: runner.draw(load_result(changed)),
            "report": lambda: runner.report(load_result(changed)),
            "csv": lambda: save_csv(load_result(changed), written),
            "export": lambda: runner.export(load_result(changed), written),
            "compare": lambda: run_study(read_comparison([str(changed), str(changed)], {}, {})),
        }
        for number, (name, edit) in enumerate(damage.edits(original)):
            if number % EVERY:
                continue
            try:
                edit(original.copy(deep=True)).to_netcdf(changed, engine="h5netcdf")
            except Exception:  # what cannot be written is no result
                continue
            for use, attempt in uses.items():
                yield f"{name}: {use}", attempt

    counts = tried(tmp_path, attempts)
    assert counts["well"] > 0
    assert counts["sentence"] > 0


@pytest.mark.slow
def test_crafted_attributes(result: Path, tmp_path: Path) -> None:
    """Every command writes what it is for, or ends in one sentence: also where the checksums are those of what was crafted."""
    from wucht.results.output_folder import load_result

    original, codes = load_result(result), set[int]()
    for seed in range(8):
        name, changed = damage.crafted(original, seed)
        folder = tmp_path / str(seed)
        folder.mkdir()
        changed.to_netcdf(folder / "result.nc", engine="h5netcdf")
        commands = {"report": ("result.nc",), "plot": ("result.nc", "-o", "p"), "export": ("result.nc", "--csv", "-o", "e")}
        commands["compare"] = ("result.nc", "result.nc", "-o", "c")
        for command in ("report", [*commands][seed % 3 + 1]):
            ended = children.call(children.wucht(command, *commands[command]), folder)
            codes.add(ended.code)
            assert ended.code in (0, 1, 2), f"{name}: {command}: {ended.err}"
            assert "Traceback" not in ended.err, f"{name}: {command}"
            sentences = [line for line in ended.err.splitlines() if line.startswith("wucht: ")]
            assert len(sentences) == (ended.code != 0), f"{name}: {command}: {ended.err}"
            assert (folder / "report.html").exists() == (ended.code == 0) or command != "report", name
    assert {0, 2} <= codes


@pytest.mark.parametrize("how", ["external", "virtual", "link", "inner"])
def test_numbers_of_a_result_come_from_no_other_file(result: Path, tmp_path: Path, how: str) -> None:
    """HDF5 can name one, such as a key of the user's, whose bytes are then numbers of a report that is passed on."""
    import h5py

    secret, file = tmp_path / "secret", tmp_path / "result.nc"
    file.write_bytes(result.read_bytes())
    with h5py.File(file, "r+") as edited:
        name = next(n for n, d in edited.items() if d.dtype == float and d.shape)
        shape, attributes = edited[name].shape, {k: v for k, v in edited[name].attrs.items() if k in ("units", "long_name")}
        del edited[name], edited.attrs["checksums"]
        with h5py.File(secret, "w") as other:
            other["numbers"] = np.ones(shape)
        if how == "link":
            edited[name] = h5py.ExternalLink(str(secret), "numbers")
        elif how == "virtual":
            layout = h5py.VirtualLayout(shape, float)
            layout[...] = h5py.VirtualSource(str(secret), "numbers", shape)
            edited.create_virtual_dataset(name, layout)
        else:
            place = f"inner/{name}" if how == "inner" else name
            edited.create_dataset(place, shape, float, external=[(str(secret), 0, h5py.h5f.UNLIMITED)])
            if how == "inner":
                edited[name] = h5py.SoftLink(f"/{place}")
        if how != "link":
            edited[name].attrs.update(attributes)
    for command in ("report", "export"):
        ended = children.call(children.wucht(command, "result.nc"), tmp_path)
        assert ended.code == 2, ended.err
        assert f"{name} lie" in ended.err
        assert "in another file" in ended.err


def test_a_changed_result_is_refused_by_every_command(result: Path, tmp_path: Path) -> None:
    """Exit code 2, and nothing is drawn: the byte is one of a number."""
    import h5py

    from wucht.results.output_folder import load_result

    name = next(str(name) for name, variable in load_result(result).variables.items() if variable.dtype.kind == "f")
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "result.nc").write_bytes(result.read_bytes())
    with h5py.File(folder / "result.nc", "r+") as file:
        numbers = file[name]
        numbers[(0,) * numbers.ndim] = 1e-3
    for words in (("plot", "out"), ("export", "out"), ("compare", "out", "out", "-o", "both")):
        ended = children.call(children.wucht(*words), tmp_path)
        assert ended.code == 2, words
        assert "changed or damaged since it was written" in ended.sentence


# Records


def csv_record() -> str:
    t = np.arange(40) * 0.01
    return "time [s],speed [rpm],force [N]\n" + "\n".join(f"{a:.2f},{600 + 30 * a:.3f},{np.sin(50 * a):.5f}" for a in t) + "\n"


def sound_record(path: Path) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(1000)
        file.writeframes(b"".join(struct.pack("<hh", k, -k) for k in range(200)))


def universal_record(path: Path) -> None:
    pyuff = pytest.importorskip("pyuff")
    given = {
        "binary": 0, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "id1": "force", "id2": "NONE",
        "id3": "NONE", "id4": "NONE", "id5": "NONE", "ord_data_type": 4, "abscissa_spacing": 1, "abscissa_min": 0.0,
        "abscissa_inc": 0.25, "abscissa_spec_data_type": 17, "abscissa_axis_units_lab": "s", "ordinate_spec_data_type": 0,
        "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "ordinate_axis_units_lab": "N", "num_pts": 5,
        "x": np.arange(5) * 0.25, "data": np.arange(5.0),
    }  # fmt: skip
    pyuff.UFF(str(path)).write_sets(pyuff.prepare_58(**given), "add")


def waveform_record(path: Path) -> None:
    nptdms = pytest.importorskip("nptdms")
    channel = nptdms.ChannelObject("g", "speed", np.arange(30.0), properties={"wf_increment": 0.1, "unit_string": "rpm"})
    with nptdms.TdmsWriter(str(path)) as writer:
        writer.write_segment([channel])


def measurement_record(path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    t = np.arange(20) / 20
    with asammdf.MDF() as file:
        file.append([asammdf.Signal(np.sin(t), timestamps=t, name="force", unit="N", encoding="utf-8")])
        file.save(path, overwrite=True)


RECORDS: dict[str, Callable[[Path], None]] = {
    "wav": sound_record, "uff": universal_record, "tdms": waveform_record, "mf4": measurement_record,
}  # fmt: skip


def finite(path: Path) -> None:
    """All numbers of a record that is read are finite."""
    from wucht.measurements.reading import read_recording

    record = read_recording(path)
    for name in record.names:
        try:
            channel = record.channel(name)
        except WuchtError:
            continue
        assert np.isfinite(channel.values).all()
        assert np.isfinite(channel.time).all()


@pytest.mark.usefixtures("loaded")
@pytest.mark.parametrize("count", [100, pytest.param(3000, marks=pytest.mark.slow)])
def test_changed_tables(tmp_path: Path, count: int) -> None:
    def attempts() -> Iterator[tuple[str, Callable[[], object]]]:
        for seed in range(count):
            (tmp_path / "r.csv").write_bytes(damage.text_changed(csv_record(), seed))
            yield f"seed {seed}", lambda: finite(tmp_path / "r.csv")

    assert tried(tmp_path, attempts)["sentence"] > count / 5


@pytest.mark.usefixtures("loaded")
@pytest.mark.parametrize("ending", [e if e == "wav" else pytest.param(e, marks=pytest.mark.slow) for e in RECORDS])
def test_changed_bytes_of_a_record(tmp_path: Path, ending: str) -> None:
    whole, changed = tmp_path / f"whole.{ending}", tmp_path / f"r.{ending}"
    RECORDS[ending](whole)

    def attempts() -> Iterator[tuple[str, Callable[[], object]]]:
        for seed in range(100):
            changed.write_bytes(damage.bytes_changed(whole.read_bytes(), seed))
            yield f"seed {seed}", lambda: finite(changed)

    assert tried(tmp_path, attempts)["sentence"] > 0
