"""The title in the head of each page as a link to the first page, as the logo is: by name, so that it works offline, too."""

from __future__ import annotations

import re
from typing import Any

_TITLE = re.compile(r'(<span class="md-ellipsis">)\s*([^<]*?)\s*(</span>)')


def on_post_page(output: str, /, page: Any, config: Any, **_: Any) -> str:
    """Called by MkDocs with the whole HTML of each page; the first of these texts is the name of the site."""
    up = "../" * page.url.count("/")
    return _TITLE.sub(rf'\1<a class="site-title" href="{up}{config["extra"]["homepage"]}">\2</a>\3', output, count=1)
