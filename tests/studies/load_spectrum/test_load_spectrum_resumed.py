"""A load spectrum is taken up again where it stopped, and is that of a run that was never stopped."""

import numpy as np
from tests.refusals import refused

import wucht
from wucht import Records

SPEC = {"until": 10.0, "after": 1.0, "start": {"p1": 0.3, "p2": -0.5}}


def test_stopped_and_resumed(tmp_path):
    machine, spec = wucht.load_machine("drozdetskaya-2020/r1"), wucht.LoadSpectrum(**SPEC)
    whole = wucht.run(spec, machine)
    calls = 0

    def stop(share: float, what: str) -> None:
        nonlocal calls
        calls += 1
        if share > 0.4:
            raise KeyboardInterrupt

    part = wucht.run(spec, machine, folder=tmp_path, progress=stop)
    assert calls and not part.wucht.finished and 1.0 < part.wucht.summary["end"] < 10.0
    assert 0 < part.wucht.summary["cycles"] < whole.wucht.summary["cycles"]
    shares = list[float]()
    again = wucht.run(spec, machine, folder=tmp_path, resume=True, progress=lambda share, what: shares.append(share))
    assert again.wucht.finished and min(shares) > 0.1  # what was done before is not done again
    assert again.wucht.summary == whole.wucht.summary
    for name in whole.data_vars:
        assert np.array_equal(again[name].values, whole[name].values, equal_nan=True), name


def test_a_changed_record_is_another_question(tmp_path):
    record, results = tmp_path / "record.csv", tmp_path / "results"
    record.write_text("0,1\n1,2\n2,0\n", encoding="utf-8")
    spec = wucht.LoadSpectrum(signal={"file": "record.csv"})
    first = wucht.run(spec, Records(tmp_path), folder=results)
    assert wucht.run(spec, Records(tmp_path), folder=results, resume=True).attrs["input"] == first.attrs["input"]
    record.write_text("0,1\n1,3\n2,0\n", encoding="utf-8")
    with refused("--resume", given=None, code="other-question"):
        wucht.run(spec, Records(tmp_path), folder=results, resume=True)
