"""``result.wucht``, of a run and of a result read back."""

from pathlib import Path

import xarray as xr
from tests.refusals import rejected

import wucht
from wucht.results.accessor import register_accessor


def test_a_result_says_what_it_is(tmp_path: Path) -> None:
    machine = wucht.load_machine("drozdetskaya-2020/r1")
    result = wucht.run(wucht.RunUp(until="2 s", start={"p1": 0.3, "p2": -0.5}), machine, folder=tmp_path)
    for which in (result, wucht.load(tmp_path / "result.nc")):
        says = which.wucht
        assert (says.study, says.finished, says.failure) == ("run-up", True, "")
        assert says.summary["outcome"] == "unidentified"
        assert says.spec["until"] == 2.0
        assert says.machine["parameters"] == machine.values
        assert says.sentence in repr(says)
        html = says._repr_html_()
        assert "<th>outcome</th><td>unidentified</td>" in html


def test_what_was_not_finished_says_so() -> None:
    def stop(share: float, what: str) -> None:
        if share > 0.2:
            raise KeyboardInterrupt

    asked = wucht.Sweep(along="drive.no_load_speed", range=(5.0, 6.0))
    result = wucht.run(asked, wucht.load_machine("sperling-vibration/figure-5"), progress=stop)
    assert not result.wucht.finished
    assert "not finished" in repr(result.wucht)
    assert any("resume" in w for w in result.wucht.warnings)


def test_a_dataset_that_is_no_result_is_refused() -> None:
    register_accessor()
    with rejected("no-result"):
        _ = xr.Dataset().wucht
