"""Panels over the speed: the natural frequencies and the speed of the drive are marked, legends stand beside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wucht.results.style import GREY, label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def finish_panels(
    axes: Sequence[Axes], result: xr.Dataset, natural: tuple[str, str], free: tuple[float, str], named: int
) -> None:
    """Mark speeds that lie in the range, set the range, and write legends and the name of the abscissa.

    natural: what the natural frequencies are called, one of them and several; they are marked for both senses. free: the speed
    that the drive reaches, and what it is called. named: the panel whose legend has these.
    """
    low, high = float(result.speed[0]), float(result.speed[-1])
    frequencies = np.round(result.natural_frequency.values, 9)
    shown = sorted(f for f in {*frequencies, *-frequencies} if low <= f <= high)
    for axis in axes:
        here = axis is axes[named]
        for k, f in enumerate(shown):
            name = natural[len(shown) > 1] if here and k == 0 else None
            axis.axvline(f, color=GREY, linestyle=":", linewidth=0.9, label=name, zorder=1)
        if low <= free[0] <= high:
            axis.axvline(free[0], color=GREY, linestyle="--", linewidth=0.9, label=free[1] if here else None, zorder=1)
        axis.set_xlim(low, high)
        if axis.get_legend_handles_labels()[0]:
            axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)
    axes[-1].set_xlabel(label(result, "speed") if result.speed.attrs["units"] else "speed $\\omega$")
