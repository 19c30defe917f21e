"""The cam drive as the subject of studies: the tables [law], [follower], [linkage], [speed] and [shaft] of a study file."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wucht.cams.drive import TABLES, CamDrive, cam_drive_from
from wucht.errors import InputError, nearest
from wucht.file_names import printable
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, changed_title, refuse_bare_frequencies
from wucht.schema import refuse_unknown
from wucht.studies.subjects import Description


class CamDriveSubject:
    """The cam drive of a study file."""

    def from_document(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[CamDrive, Document]:
        """See ``Subject``."""
        refuse_unknown(document, (*ABOUT, *TABLES), "")
        tables = {key: copy.deepcopy(document[key]) for key in TABLES if key in document}
        differing = Document()
        for key, value in settings.items():
            before = copy.deepcopy(tables)
            _set_key(tables, key, value)
            differing |= {key: value} if tables != before else {}
        refuse_bare_frequencies(tables)
        title = changed_title(str(document.get("title", printable(path.stem))), differing)
        return cam_drive_from(tables, title, path.parent), tables

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if not isinstance(subject, CamDrive):
            raise InputError("cam drive", subject, "the subject of this study must be a cam drive: wucht.CamDrive")
        return Description(subject.title, False, subject.facts)


def _set_key(tables: Document, path: str, value: Any) -> None:
    """Set a key by its path. Items of lists are counted from 1, ``law.restrictions.1.equals``, or written as in messages,
    ``law.restrictions[0].equals``. Raises ``InputError``."""
    keys = re.sub(r"\[(\d+)\]", lambda match: f".{int(match[1]) + 1}", path).split(".")
    if keys[0] not in TABLES:
        raise InputError(path, value, f"unknown table; {nearest(keys[0], TABLES)}, each followed by '.key'")
    if len(keys) == 1:
        raise InputError(path, value, f"this is a table; set one of its keys as {path}.KEY")
    target: Any = tables.setdefault(keys[0], {})
    for k, key in enumerate(keys[1:-1], 1):
        if isinstance(target, dict):
            target = target.setdefault(key, {})
        elif isinstance(target, list) and key.isdigit() and 1 <= int(key) <= len(target):
            target = target[int(key) - 1]
        else:
            raise InputError(path, value, f"{'.'.join(keys[:k])} has no {key!r}")
    last = keys[-1]
    if isinstance(target, list) and last.isdigit() and 1 <= int(last) <= len(target):
        target[int(last) - 1] = value
    elif isinstance(target, dict):
        target[last] = value
    else:
        raise InputError(path, value, f"{'.'.join(keys[:-1])} is not a table")


CAM_DRIVE = CamDriveSubject()
