"""Words that can complete a line beginning with ``wucht``: called by the shell at each press of Tab, so loading nothing heavy.

The vocabulary (commands, studies, parts, their keys) is gathered once, by ``completion_words``, and stored in the user's cache
folder until the program or another installed package changes.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
import tomllib
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

_PACKAGE = Path(__file__).parent.parent
_CATALOGUE = _PACKAGE / "machines" / "catalogue"
_LONGEST_CHAIN = 20  # of files, each of which uses the next
_OF_STUDIES = ("run", "equations", "compare")
_OF_CATALOGUE = (*_OF_STUDIES, "new")


def words(line: str) -> list[str]:
    """Possible completions of the last, perhaps empty, word of a command line."""
    given = _split(line)[1:] or [""]
    known = _known()
    found = _following(given[:-1], given[-1], known)
    return sorted({word for word in found if word.startswith(given[-1])})


def _split(line: str) -> list[str]:
    """Split a line as the shell does; its last quotation mark may not be closed yet."""
    for end in ("", '"', "'"):
        with suppress(ValueError):
            split = shlex.split(line + end)
            return [*split, ""] if not end and line[-1:].isspace() else split
    return line.split(" ")


def _following(before: list[str], current: str, known: dict[str, Any]) -> list[str]:
    command = next((word for word in before if word in known["commands"]), None)
    if command is None:
        return [*known["commands"], "--help", "--version"]
    last, options = before[-1], known["commands"][command]
    option, equals, begun = current.partition("=")
    if equals and options.get(option):  # --set=KEY=VALUE in one word
        return [f"{option}={word}" for word in _following([*before, option], begun, known)]
    if options.get(last):  # the value of this option
        settings = last in ("--set", "--vary")
        return (
            _settings(_studies(before[before.index(command) + 1 :]), current, known)
            if settings
            else known["values"].get(last, [])
        )
    if current.startswith("-"):
        return [*options]
    names = known["names"].get(command, [])
    return [*names, *(_catalogue() if command in _OF_CATALOGUE else []), *(_files(current) if command in _OF_STUDIES else [])]


def _catalogue() -> list[str]:
    return [path.relative_to(_CATALOGUE).with_suffix("").as_posix() for path in _CATALOGUE.rglob("*.toml")]


def _files(current: str) -> list[str]:
    """Study files and folders whose path begins with the current word."""
    folder, _, begin = current.rpartition("/")
    with suppress(OSError):
        there = [p for p in Path(folder or ("/" if current[:1] == "/" else ".")).iterdir() if p.name.startswith(begin or "")]
        before = f"{folder}/" if "/" in current else ""
        return [f"{before}{p.name}{'/' * p.is_dir()}" for p in there if p.is_dir() or p.suffix == ".toml"]
    return []


def _studies(after: list[str]) -> list[str]:
    """The studies that a command names."""
    return [word for k, word in enumerate(after) if not word.startswith("-") and (k == 0 or not after[k - 1].startswith("-"))]


def _settings(studies: list[str], current: str, known: dict[str, Any]) -> list[str]:
    """``KEY=`` for each key of the machines and questions; ``KEY=WORD`` where a key of the question takes certain words."""
    found: list[str] = []
    for study in studies:
        document = _document(study)
        kind = document.get("study", {}).get("kind", known["default"])
        keys: dict[str, str] = known["studies"].get(kind, {}) | {"kind": ", ".join(known["studies"])}
        for key, allowed in keys.items():
            choices = [word for word in allowed.split(", ") if word and word[0] not in "<>"]
            inside = current.startswith(f"study.{key}=")
            found += [f"study.{key}={word}" for word in choices] if inside and choices else [f"study.{key}="]
        found += [f"{path}=" for path in _paths(document.get("machine", {}), known["parts"])]
    return found


def _document(name: str) -> dict[str, Any]:
    """A study file with the machine that it uses; empty if it cannot be read."""
    document: dict[str, Any] = {}
    path = Path(name) if Path(name).is_file() else _CATALOGUE / f"{name}.toml"
    with suppress(Exception):  # errors in it are reported when it is run
        for _ in range(_LONGEST_CHAIN):
            read = tomllib.loads(path.read_text(encoding="utf-8-sig"))
            document.setdefault("study", read.get("study", {}))
            document["machine"] = read.get("machine", {})
            used = document["machine"].get("use")
            if not used:
                break
            path = path.parent / used if (path.parent / used).is_file() else _CATALOGUE / f"{used}.toml"
    return document


def _paths(machine: dict[str, Any], parts: dict[str, dict[str, list[str]]]) -> list[str]:
    """The paths of a machine's parameters, from the kinds of its parts."""
    if "model" in machine:
        return parts["dimensionless machines"].get(machine["model"], [])
    carrier = machine.get("carrier", {})
    found = [f"carrier.{key}" for key in parts["carriers"].get(carrier.get("directions", "xy"), [])]
    for body in machine.get("bodies", []):
        found += [f"{body.get('name')}.{key}" for key in parts["bodies"].get(body.get("kind"), [])]
    for attached in machine.get("attachments", []):
        found += [f"{attached.get('name')}.{key}" for key in parts["attachments"].get(attached.get("kind"), [])]
    for group in ("drive", "load"):
        shafts = machine.get(f"{group}s") or ([machine[group]] if group in machine else [])
        on = [shaft.get("on", "") for shaft in shafts]
        for shaft in shafts:
            kind, body = shaft.get("kind"), shaft.get("on", "")
            label = body if on.count(body) == 1 else f"{body}.{kind}"
            place = group if len(shafts) == 1 else f"{group}s.{label}"
            found += [f"{place}.{key}" for key in parts[f"{group}s"].get(kind, [])]
    return found


def _known() -> dict[str, Any]:
    """Read the vocabulary from the cache, or gather and store it."""
    from wucht.disk_cache import cache_folder, keep, make_folder, program_state, read_kept

    file = cache_folder() / "completion"
    state = sha256(repr((program_state(), _installed())).encode()).hexdigest()
    with suppress(OSError, ValueError, KeyError):
        kept = json.loads(read_kept(file))
        if kept["state"] == state:
            known: dict[str, Any] = kept["known"]
            return known
    from wucht.cli.completion_words import gathered

    fresh = gathered()
    with suppress(OSError):  # no space, or no permission to write there: it is gathered again next time
        make_folder(file.parent)
        keep(file, json.dumps({"state": state, "known": fresh}).encode())
    return fresh


def _installed() -> list[tuple[str, bytes]]:
    """Entry points of the installed packages, by their names and versions."""
    places = [Path(folder) for folder in sys.path if os.path.isdir(folder)]  # noqa: PTH112
    return sorted(
        (file.parent.name, file.read_bytes()) for place in places for file in place.glob("*.dist-info/entry_points.txt")
    )
