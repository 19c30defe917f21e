"""A machine -> one page of HTML in which it moves. No request leaves it, and it needs no server."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

import wucht
from wucht.dynamics.drive_switches import switch_path, switchable_drives, with_switches
from wucht.dynamics.live_machine import machine_description, machine_script
from wucht.errors import WuchtError
from wucht.file_names import replace_non_utf8
from wucht.machines.machine import Machine
from wucht.reports.markup import html_text
from wucht.web.cards import Card
from wucht.web.curve_panels import levels, matrices_code, panels
from wucht.web.page_policy import page_policy, policy_tag
from wucht.web.sliders import derived_parameters, parameter_groups
from wucht.web.start_controls import start_groups

_WEB = files("wucht").joinpath("web")


@dataclass(frozen=True)
class PageText:
    """What a page says beside the machine.

    file: the name of the study file or catalogue entry. machine, study: TOML of the file's machine, and of the question without
    its start. start: of the file, as TOML; empty where it gives none; start_of_parts: what of it no control of the page sets.
    file_keys: keys of the file's machine, as ``given_keys`` returns them; None: all numbers are given.
    verdict: label and sentence of Python's run. server: the address at which a server judges other runs; None: none does.
    is_embedded: whether the page tells the page around it what it shows. reason: why there is no study file to copy.
    """

    file: str
    machine: str = ""
    study: str = ""
    start: str = ""
    start_of_parts: str = ""
    file_keys: frozenset[str] | None = None
    verdict: tuple[str, str] | None = None
    card: Card | None = None
    server: str | None = None
    is_embedded: bool = False
    reason: str = ""


def live_page(machine: Machine, state: np.ndarray, until: float, turn: float, text: PageText) -> str:
    """Return the live machine as one page of HTML.

    Parameters
    ----------
    machine : Machine
        In its initial state: with the contacts between those bodies that are neighbours there.
    state : ndarray, (n,)
        The initial state.
    until : float
        The end of the run, in the machine's time.
    turn : float
        The time of the fastest motion expected: of a turn, or of a vibration.
    text : PageText

    Returns
    -------
    str

    Raises
    ------
    WuchtError
        For a machine that cannot be exported, or where the page was not built when this package was installed.
    """
    script, style = built_file("live.js"), built_file("live.css")
    exported_machine = with_switches(machine)
    description = machine_description(exported_machine, state)
    names = [str(p["path"]) for p in description["parameters"]]
    contents = {
        "version": wucht.__version__,
        "until": until,
        "turn": turn,
        "text": {k: v for k, v in asdict(text).items() if k != "file_keys"},
        "dimensionless": machine.dimensionless,
        "groups": parameter_groups(machine, names, text.file_keys),
        "derived": derived_parameters(machine, names, text.file_keys),
        "start": start_groups(machine, state),
        "switches": [{"name": d.on, "index": names.index(switch_path(d))} for d in switchable_drives(machine)],
        "panels": panels(machine, description["outputs"]),
        "levels": levels(machine, names),
    }
    matrices = matrices_code(machine, names)
    lines = [
        machine_script(exported_machine, state).removeprefix("export ").rstrip(),
        f"const page = {_json(contents)};",
        f"const levelCode = {{ matrices: {matrices} }};",
    ]
    data = replace_non_utf8("\n".join(lines))
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            policy_tag(page_policy([data, script], asks_server=text.server is not None)),
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta name="color-scheme" content="light dark">',
            f"<title>{html_text(machine.title, 160)}</title>",
            f"<style>{style}</style>",
            "</head>",
            "<body>",
            "<noscript>This page computes the motion of a machine; it needs JavaScript.</noscript>",
            f'<script id="machine">{data}</script>',
            f'<script id="engine">{script}</script>',
            "</body>",
            "</html>",
            "",
        ]
    )


def _json(contents: Any) -> str:
    """Plain data as JavaScript that cannot end the script in which it stands."""
    return json.dumps(contents, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def built_file(name: str) -> str:
    """Return a file of the built page. Raises ``WuchtError`` where the page was not built when this package was installed."""
    try:
        return _WEB.joinpath("built", name).read_text(encoding="utf-8")
    except OSError:
        reason = "the page of the live machine is not part of this installation, as npm had no network when it was built"
        raise WuchtError(f"{reason}; with one, this command builds it: {_build_command(_WEB)}", code="not-built") from None


def _build_command(web: Traversable) -> str:
    """Return the command that builds the page: from the sources, where wucht is installed from them in place."""
    if web.joinpath("package.json").is_file():
        return f"pip install --no-deps -e {Path(str(web)).parents[2]}"
    return "pip install --force-reinstall --no-deps --no-cache-dir wucht"
