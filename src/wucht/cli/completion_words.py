"""All words of completion except files and the catalogue: gathered from the commands, the studies and the parts."""

from __future__ import annotations

from typing import Any


def gather_words() -> dict[str, Any]:
    """The vocabulary that ``completing`` needs.

    commands: the options of each, and whether they take a value; values: words of an option; names: arguments of a command;
    default: kind of study; studies: the keys of each and the values they allow; parts: the quantities of each kind.
    """
    from wucht.cli.completion import Shell
    from wucht.cli.list_name import kinds
    from wucht.cli.options import Format, Style
    from wucht.schema import keys_of
    from wucht.studies.registry import studies
    from wucht.studies.study_file import DEFAULT_KIND

    parts = {
        title: {
            kind: [key.name for key in keys_of(cls) if key.unit is not None and not set(key.name) & {"[", "."}]
            for kind, cls in of_kind.items()
        }
        for title, of_kind in kinds().items()
    }
    listed_names = sorted({kind for of_kind in parts.values() for kind in of_kind} | set(studies()))
    return {
        "commands": _commands(),
        "values": {"--format": [f.value for f in Format], "--style": [s.value for s in Style]},
        "names": {"list": listed_names, "new": list(studies()), "completion": [shell.value for shell in Shell]},
        "default": DEFAULT_KIND,
        "studies": {kind: {key.name: key.allowed for key in keys_of(s.study)} for kind, s in studies().items()},
        "parts": parts,
    }


def _commands() -> dict[str, dict[str, bool]]:
    """The options of each visible command, and whether they take a value."""
    from typer.main import get_command

    from wucht.cli.app import app, register

    register()
    whole: Any = get_command(app)  # a group of the click that Typer brings
    return {
        name: {o: not p.is_flag for p in command.params if hasattr(p, "is_flag") for o in (*p.opts, *p.secondary_opts)}
        | {"--help": False}
        for name, command in whole.commands.items()
        if not command.hidden
    }
