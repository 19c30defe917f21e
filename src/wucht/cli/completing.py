"""What Typer's completion of the shell cannot know: names of studies and files, and the keys of the study on the line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from warnings import catch_warnings, simplefilter

import typer


def study_names(incomplete: str) -> list[str]:
    """Catalogue names, study files and folders that begin with a word."""
    from wucht.files.catalogue import names

    return [name for name in (*names(), *_files(incomplete)) if name.startswith(incomplete)]


def listed_names(incomplete: str) -> list[str]:
    """Groups, studies, kinds of parts and catalogue names that begin with a word."""
    from wucht.cli.list_groups import group_names, groups
    from wucht.files.catalogue import names
    from wucht.studies.registry import studies

    return [
        name
        for name in (*group_names(), *studies(), *(kind for of_kind in groups().values() for kind in of_kind), *names())
        if name.startswith(incomplete)
    ]


def template_names(incomplete: str) -> list[str]:
    """Studies and catalogue names that begin with a word."""
    from wucht.files.catalogue import names
    from wucht.studies.registry import studies

    return [name for name in (*studies(), *names()) if name.startswith(incomplete)]


def settable_keys(context: typer.Context, incomplete: str) -> list[str]:
    """``KEY=`` for each parameter and key of the studies on the line; ``KEY=WORD`` where a key takes certain words."""
    study, several = context.params.get("study"), context.params.get("of")
    studies = [*context.args, *(several or ()), *([study] if study else [])]  # args: those before an option without its value
    with catch_warnings():
        simplefilter("ignore")  # they would stand in the command line
        words = {word for study in studies for word in _keys_of_study(study, incomplete)}
    return sorted(word for word in words if word.startswith(incomplete))


def _keys_of_study(name: str, incomplete: str) -> Iterator[str]:
    """The keys of its question, though some may be missing yet, and the parameters of its machine or equations."""
    from wucht.files.catalogue import load_document
    from wucht.schema import keys_of
    from wucht.studies.registry import requested_study, studies
    from wucht.studies.study_file import DEFAULT_KIND
    from wucht.studies.subjects import subject_of

    with suppress(Exception):  # errors in it are reported when it is run
        document, path = load_document(name)
        question = requested_study({"kind": DEFAULT_KIND} | document.get("study", {})).study
        allowed_values = {key.name: key.allowed for key in keys_of(question)} | {"kind": ", ".join(studies())}
        for key, allowed in allowed_values.items():
            choices = [word for word in allowed.split(", ") if word and word[0] not in "<>"]
            is_begun = bool(choices) and incomplete.startswith(f"study.{key}=")
            yield from (f"study.{key}={word}" for word in choices) if is_begun else (f"study.{key}=",)
        subject, _ = subject_of(question).from_document(document, path, name, {})
        yield from (f"{parameter}=" for parameter in getattr(subject, "parameters", ()))


def _files(incomplete: str) -> Iterator[str]:
    """Study files and folders whose path begins with a word."""
    folder, slash, begin = incomplete.rpartition("/")
    with suppress(OSError):
        for path in Path(folder + slash or ".").iterdir():
            if path.name.startswith(begin) and (path.is_dir() or path.suffix == ".toml"):
                yield f"{folder}{slash}{path.name}{'/' * path.is_dir()}"
