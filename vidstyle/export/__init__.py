"""Export of styles to other programs: browsers, mpv, FFmpeg."""

from __future__ import annotations

import re
from pathlib import Path

_FOLDER = Path(__file__).parent
RUNNER_FOLDER = _FOLDER / "runner"
"""The JavaScript modules that run plans in a browser; import `runner.js`."""
SCRIPT_FOLDERS = (RUNNER_FOLDER, _FOLDER / "modules")
"""The JavaScript modules that every page of vidstyle may import."""
EXAMPLE_FILE = _FOLDER / "example.webp"
"""The astronaut Eileen Collins: a photograph of NASA, in the public domain, from scikit-image."""
_IMPORT = re.compile(r'^import [^;]* from "\./([\w.]+)";\n', re.MULTILINE)


def runner_module() -> str:
    """The modules of `RUNNER_FOLDER` joined into one module."""
    return join_modules(RUNNER_FOLDER / "runner.js")


def module_text(name: str) -> str:
    """Return the text of a file of the folder `modules`."""
    return (_FOLDER / "modules" / name).read_text(encoding="utf-8")


def join_modules(path: Path) -> str:
    """Return a module and all modules that it imports, directly or not, as the text of one module.

    It imports modules of its folder and of `SCRIPT_FOLDERS`, by their file names.
    """
    texts: dict[str, str] = {}

    def add(path: Path) -> None:
        text = path.read_text(encoding="utf-8")
        for name in _IMPORT.findall(text):
            if name not in texts:
                folders = (path.parent, *SCRIPT_FOLDERS)
                add(next(folder / name for folder in folders if (folder / name).exists()))
        texts[path.name] = _IMPORT.sub("", text)

    add(path)
    return "\n".join(texts.values())
