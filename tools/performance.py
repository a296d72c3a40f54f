"""Puts measurements into docs/performance.md.

    python tools/compare_peers.py CLIP > peers.md
    vidstyle bench --film CLIP -o film.md
    vidstyle bench --size 1920x1080 -o bench.md
    python -m tools.performance peers.md film.md bench.md

The name of a file without its ending says which section it is for.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

PAGE = Path(__file__).parent.parent / "docs" / "performance.md"


def with_tables(page: str, section: str, tables: str) -> str:
    """The page with other tables in a section, their headings one level deeper.

    Raises:
        ValueError: there is no such section.
    """
    place = re.compile(rf"(?<=<!-- {re.escape(section)} -->\n).*?(?=<!-- end -->)", re.DOTALL)
    if not place.search(page):
        raise ValueError(f"{PAGE} has no section {section}")
    deeper = re.sub(r"^##", "###", tables, flags=re.MULTILINE)
    return place.sub(lambda _: f"{deeper.strip()}\n", page)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        tables = Path(name).read_text(encoding="utf-8")
        page = with_tables(PAGE.read_text(encoding="utf-8"), Path(name).stem, tables)
        PAGE.write_text(page, encoding="utf-8")
