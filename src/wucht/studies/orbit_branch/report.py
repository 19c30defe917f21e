"""A branch of orbits in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr

_MOST = 16  # orbits, and special points, named one by one


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a branch of orbits."""
    s = result.wucht.summary
    lines, along, unit = [result.attrs["title"], f"verdict: {s['sentence']}"], s["along"], f" {s['along_unit']}".rstrip()
    for k, branch in enumerate(s["branches"]):
        (low, high), stretches = branch["range"], ", ".join(f"{a:.7g} to {b:.7g}" for a, b in branch["stable"])
        winding = ", ".join(f"{name} {turns:+d}" for name, turns in branch["winding"].items())
        how = f"turns a period: {winding}" if winding else "all angles return"
        stable = f"stable at {along} from {stretches}" if stretches else "nowhere stable"
        lines.append(
            f"  branch {k + 1}     from {branch['begun']}: {along} from {low:.7g} to {high:.7g}{unit}, {stable}; {how}"
        )
        lines += [f"    end        {end['sentence']}" for end in s["ends"] if end["branch"] == k]
    for p in s["special_points"][:_MOST]:
        where = f"{along} = {p['value']:.8g}{unit}"
        if "hidden" in p:
            where = f"{along} from {p['between'][0]:.8g} to {p['between'][1]:.8g}{unit}: a {p['hidden']} that was not located"
        lines.append(f"  {p['kind']:12} {where}: {_period(result, p)}")
    lines += [_orbit(result, o, along, unit) for o in s["orbits"][:_MOST] if not o["kind"]]
    if len(s["orbits"]) > _MOST:
        lines.append(f"  and {len(s['orbits']) - _MOST} more orbits: see the Dataset")
    if result.attrs["rotor"] and s["branches"]:
        of = "disturbances that keep the bodies together alone" if s["section"] else "all their disturbances"
        lines.append(f"  stability    in the averaged equations, of {of}; exponents: per unit of time")
    return lines


def _period(result: xr.Dataset, one: dict[str, Any]) -> str:
    time = str(result.period.attrs["units"])
    phi = "" if one["period_phi"] is None else f" ({one['period_phi']:.8g} of the rotor's angle)"
    return f"period {one['period']:.8g} {time}".rstrip() + phi


def _orbit(result: xr.Dataset, o: dict[str, Any], along: str, unit: str) -> str:
    speed = formats(result)[0] if result.attrs["rotor"] else "{:.6g}".format
    largest = o["exponents"][0] if o["exponents"] else None
    word = "" if o["stable"] is None else (", stable" if o["stable"] else ", unstable")
    growth = "" if largest is None else f", largest exponent {largest[0]:.5g}{word}"
    range_ = f"{speed(o['min_speed'])} to {speed(o['max_speed'])}"
    return f"  orbit        {along} = {o['value']:.6g}{unit}: {_period(result, o)}, {range_}{growth}"
