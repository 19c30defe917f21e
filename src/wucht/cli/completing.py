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
from warnings import catch_warnings, simplefilter

_PACKAGE = Path(__file__).parent.parent
_CATALOGUE = _PACKAGE / "machines" / "catalogue"
_ENTRY = "completion"  # of the cache
_LONGEST_CHAIN = 20  # of files, each of which uses the next
_STUDY_COMMANDS = ("run", "equations", "compare")
_CATALOGUE_COMMANDS = (*_STUDY_COMMANDS, "new", "list")


def words(line: str) -> list[str]:
    """Possible completions of the last, perhaps empty, word of a command line."""
    line_words = _split(line)[1:] or [""]
    vocabulary = _vocabulary()
    candidates = _next_words(line_words[:-1], line_words[-1], vocabulary)
    return sorted({word for word in candidates if word.startswith(line_words[-1])})


def _split(line: str) -> list[str]:
    """Split a line as the shell does; its last quotation mark may not be closed yet."""
    for end in ("", '"', "'"):
        with suppress(ValueError):
            split = shlex.split(line + end)
            return [*split, ""] if not end and line[-1:].isspace() else split
    return line.split(" ")


def _next_words(before: list[str], current: str, vocabulary: dict[str, Any]) -> list[str]:
    command = next((word for word in before if word in vocabulary["commands"]), None)
    if command is None:
        return [*vocabulary["commands"], "--help", "--version"]
    last, options = before[-1], vocabulary["commands"][command]
    option, equals, prefix = current.partition("=")
    if equals and options.get(option):  # --set=KEY=VALUE in one word
        return [f"{option}={word}" for word in _next_words([*before, option], prefix, vocabulary)]
    if options.get(last):  # the value of this option
        settings = last in ("--set", "--vary")
        return (
            _settings(_studies(before[before.index(command) + 1 :], options), current, vocabulary)
            if settings
            else vocabulary["values"].get(last, [])
        )
    if current.startswith("-"):
        return [*options]
    names = vocabulary["names"].get(command, [])
    return [
        *names,
        *(_catalogue() if command in _CATALOGUE_COMMANDS else []),
        *(_files(current) if command in _STUDY_COMMANDS else []),
    ]


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


def _studies(after: list[str], options: dict[str, bool]) -> list[str]:
    """The studies that a command names. options: those of the command, and whether they take a value."""
    return [word for k, word in enumerate(after) if not word.startswith("-") and (k == 0 or not options.get(after[k - 1]))]


def _settings(studies: list[str], current: str, vocabulary: dict[str, Any]) -> list[str]:
    """``KEY=`` for each key of the machines and questions; ``KEY=WORD`` where a key of the question takes certain words."""
    candidates: list[str] = []
    for study in studies:
        document = _document(study)
        kind = document.get("study", {}).get("kind", vocabulary["default"])
        keys: dict[str, str] = vocabulary["studies"].get(kind, {}) | {"kind": ", ".join(vocabulary["studies"])}
        for key, allowed_words in keys.items():
            choices = [word for word in allowed_words.split(", ") if word and word[0] not in "<>"]
            inside = current.startswith(f"study.{key}=")
            candidates += [f"study.{key}={word}" for word in choices] if inside and choices else [f"study.{key}="]
        candidates += [f"{path}=" for path in _paths(document.get("machine", {}), vocabulary["parts"])]
    return candidates


def _document(name: str) -> dict[str, Any]:
    """A study file with the machine that it uses; empty if it cannot be read."""
    document: dict[str, Any] = {}
    path = Path(name) if Path(name).is_file() else _CATALOGUE / f"{name}.toml"
    with suppress(Exception):  # errors in it are reported when it is run
        for _ in range(_LONGEST_CHAIN):
            content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
            document.setdefault("study", content.get("study", {}))
            document["machine"] = content.get("machine", {})
            machine_name = document["machine"].get("use")
            if not machine_name:
                break
            path = path.parent / machine_name if (path.parent / machine_name).is_file() else _CATALOGUE / f"{machine_name}.toml"
    return document


def _paths(machine: dict[str, Any], parts: dict[str, dict[str, list[str]]]) -> list[str]:
    """The paths of a machine's parameters, from the kinds of its parts."""
    if "model" in machine:
        return parts["dimensionless machines"].get(machine["model"], [])
    carrier = machine.get("carrier", {})
    paths = [f"carrier.{key}" for key in parts["carriers"].get(carrier.get("directions", "xy"), [])]
    for body in machine.get("bodies", []):
        paths += [f"{body.get('name')}.{key}" for key in parts["bodies"].get(body.get("kind"), [])]
    for attachment in machine.get("attachments", []):
        paths += [f"{attachment.get('name')}.{key}" for key in parts["attachments"].get(attachment.get("kind"), [])]
    for group in ("drive", "load"):
        shafts = machine.get(f"{group}s") or ([machine[group]] if group in machine else [])
        on = [shaft.get("on", "") for shaft in shafts]
        for shaft in shafts:
            kind, body = shaft.get("kind"), shaft.get("on", "")
            label = body if on.count(body) == 1 else f"{body}.{kind}"
            place = group if len(shafts) == 1 else f"{group}s.{label}"
            paths += [f"{place}.{key}" for key in parts[f"{group}s"].get(kind, [])]
    return paths


def _vocabulary() -> dict[str, Any]:
    """Read the vocabulary from the cache, or gather and store it; without warnings, which would stand in the command line."""
    with catch_warnings():
        simplefilter("ignore")
        return _cached_vocabulary()


def _cached_vocabulary() -> dict[str, Any]:
    from wucht.disk_cache import program_state, read_entry, store_entry

    state = sha256(repr((program_state(), _installed_packages())).encode()).hexdigest()
    with suppress(OSError, ValueError, KeyError):
        cache_entry = json.loads(read_entry(_ENTRY))
        if cache_entry["state"] == state:
            vocabulary: dict[str, Any] = cache_entry["known"]
            return vocabulary
    from wucht.cli.completion_words import gather_words

    fresh = gather_words()
    with suppress(OSError):  # no space, or no permission to write there: it is gathered again next time
        store_entry(_ENTRY, json.dumps({"state": state, "known": fresh}).encode())
    return fresh


def _installed_packages() -> list[tuple[str, bytes]]:
    """Entry points of the installed packages, by their names and versions."""
    places = [Path(folder) for folder in sys.path if os.path.isdir(folder)]  # noqa: PTH112
    return sorted(
        (file.parent.name, file.read_bytes()) for place in places for file in place.glob("*.dist-info/entry_points.txt")
    )
