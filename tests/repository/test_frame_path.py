"""docs/architecture.md lists the functions that a frame passes on the CPU: compared with a real run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tools.frame_path import PAGE, SECTION

ROOT = Path(__file__).parents[2]


def test_the_documented_path_of_a_frame_is_that_of_a_real_one() -> None:
    """Run in a separate process: threads that already run cannot be traced."""
    command = [sys.executable, "-m", "tools.frame_path"]
    measured = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout
    documented = SECTION.search(PAGE.read_text(encoding="utf-8"))
    assert documented is not None
    assert documented[0].strip() == measured.strip(), "renew the list: python -m tools.frame_path --write"


def test_every_folder_of_the_package_is_in_the_table() -> None:
    page = PAGE.read_text(encoding="utf-8")
    folders = {path.parent.name for path in (ROOT / "vidstyle").glob("*/*") if path.is_file()} - {
        "__pycache__"
    }
    assert [name for name in sorted(folders) if f"`vidstyle/{name}`" not in page] == []
