"""Parts of `tools/fuzz.py`: originals, damage, attempts to use the files, and checks of the outcome."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
_PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
_TEST_FOLDERS = _PROJECT["tool"]["pytest"]["ini_options"]["pythonpath"]
sys.path[:0] = [str(ROOT), *(str(ROOT / each) for each in _TEST_FOLDERS)]
