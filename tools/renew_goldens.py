"""Update the golden pictures of tests/cpu/test_goldens.py: `python tools/renew_goldens.py [--all]`.

It prints the changed pictures and their differences. Pictures within the tolerance of the tests are kept, so
that another processor changes nothing, and every changed file is worth a look; --all updates all differences.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

os.environ["XDG_CONFIG_HOME"] = os.devnull  # without the user's own styles
sys.path.append(str(Path(__file__).parent.parent / "tests" / "support"))

from goldens import FOLDER, STYLES, Difference, golden, golden_path, shipped, write_png  # noqa: E402


def main() -> None:
    """Update the pictures, and print one line for each changed, new or removed one."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--all", action="store_true", help="update all that differ, however little")
    everything: bool = parser.parse_args().all
    FOLDER.mkdir(exist_ok=True)
    changes = [line for name in STYLES if (line := renew_golden(name, everything))]
    for path in sorted(FOLDER.iterdir()):
        if path.stem not in STYLES:
            path.unlink()
            changes.append(f"{path.stem}: removed, there is no such style")
    size = sum(path.stat().st_size for path in FOLDER.iterdir())
    print(*changes, f"{len(changes)} changed; {len(STYLES)} goldens of {size // 1000} kB", sep="\n")


def renew_golden(name: str, everything: bool) -> str:
    """Update the golden picture of a style, and return a line about the change, or ""."""
    got, kept = shipped(name), golden(name)
    found = None if kept is None or kept.shape != got.shape else Difference.of(got, kept)
    if found and (found.mean == 0 or (found.small and not everything)):
        return ""
    write_png(golden_path(name), got)
    return f"{name}: {found or 'new'}"


if __name__ == "__main__":
    main()
