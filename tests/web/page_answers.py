"""Answers of the page's modules in Node, for a machine of the catalogue. The page need not be built."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from unittest.mock import patch

from tests.node import run_in_node

import wucht
from wucht.web import live_page
from wucht.web.shared_study import shared_page

JOBS, WEB = Path(__file__).with_name("page_jobs.mjs"), Path(wucht.__file__).parent / "web"


def page_text(name: str, **options: Any) -> str:
    """A page without script and style, which are not needed in Node."""
    with patch.object(live_page, "built_file", lambda _: ""):
        return shared_page(name, verdict=False, **options)


def answer(folder: Path, page: str, job: str, **inputs: Any) -> Any:
    """What a job of page_jobs.mjs answers for a page."""
    (folder / "page.html").write_text(page, encoding="utf-8")
    (folder / "job.json").write_text(json.dumps({"name": job, **inputs}), encoding="utf-8")
    return json.loads(run_in_node(JOBS, WEB, folder / "page.html", folder / "job.json"))
