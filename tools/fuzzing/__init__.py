"""The parts of `tools/fuzz.py`: what cases are made from, how they are damaged, used and judged."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support"), str(ROOT / "tests" / "support" / "models")]
