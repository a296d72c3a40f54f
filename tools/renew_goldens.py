"""Renews the pictures of tests/cpu/test_goldens.py: `python tools/renew_goldens.py [--all]`.

It says which changed and by how much. What a test would let pass stays as it is, so that those that change
are those to look at, and none does because of another processor; --all renews everything that differs.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent.parent / "tests" / "support"))

from goldens import FOLDER, STYLES, Difference, golden, golden_path, shipped, write_png  # noqa: E402


def main() -> None:
    """Renew, and print one line for each golden that is another, new or removed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--all", action="store_true", help="renew all that differ, by however little")
    everything: bool = parser.parse_args().all
    FOLDER.mkdir(exist_ok=True)
    changes = [line for name in STYLES if (line := renewed(name, everything))]
    for path in sorted(FOLDER.iterdir()):
        if path.stem not in STYLES:
            path.unlink()
            changes.append(f"{path.stem}: removed, there is no such style")
    size = sum(path.stat().st_size for path in FOLDER.iterdir())
    print(*changes, f"{len(changes)} changed; {len(STYLES)} goldens of {size // 1000} kB", sep="\n")


def renewed(name: str, everything: bool) -> str:
    """What was changed about the golden of a style; empty if nothing was."""
    got, kept = shipped(name), golden(name)
    found = None if kept is None or kept.shape != got.shape else Difference.of(got, kept)
    if found and (found.mean == 0 or (found.small and not everything)):
        return ""
    write_png(golden_path(name), got)
    return f"{name}: {found or 'new'}"


if __name__ == "__main__":
    main()
