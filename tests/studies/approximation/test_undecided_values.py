"""Values at which the runs are too short for an outcome: there the models do not disagree, nor are they known to agree."""

from __future__ import annotations

from wucht import Approximation, load_machine, report, run


def test_values_without_an_outcome_are_no_disagreement() -> None:
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier").with_values({"u": 2.0})
    result = run(Approximation(along="u", values=[1.0, 2.6], until=100.0), machine)
    s = result.wucht.summary
    assert [row["same_outcome"] for row in s["deviations"]] == [None, None] and result.same_outcome.values.tolist() == [-1] * 3
    assert s["disagreement"] == []
    assert not any("different outcomes" in line for line in report(result))
