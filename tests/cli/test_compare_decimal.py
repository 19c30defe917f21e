"""Decimal commas in the CSV files of a comparison."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest


@pytest.mark.usefixtures("no_figures")
def test_files_of_a_comparison_have_decimal_commas(wucht: Callable[..., Any], study: Callable[..., Path]) -> None:
    words = ("--vary", "drive.slope=0.03,0.05", "--set", "study.until=0.02 s", "-o", "out", "--csv", "--decimal", "comma")
    done = wucht("compare", study(), *words)
    assert done.code == 0, done.err
    read = pd.read_csv("out/comparison-variant.csv", sep=";", decimal=",")
    assert read["drive.slope [N m s]"].tolist() == [0.03, 0.05]
