"""Export of styles to other programs: browsers, mpv, FFmpeg."""

from __future__ import annotations

import re
from pathlib import Path

RUNNER_FOLDER = Path(__file__).with_name("runner")
"""The JavaScript modules that run plans in a browser; import `runner.js`."""


def runner_module() -> str:
    """The modules of `RUNNER_FOLDER` joined into one module."""
    parts = ("measured", "context", "frame", "runner")
    texts = ((RUNNER_FOLDER / f"{part}.js").read_text(encoding="utf-8") for part in parts)
    return "\n".join(re.sub(r'^import .* from "\./.*";\n', "", text, flags=re.M) for text in texts)
