"""Puts what `vidstyle bench -o TABLE` wrote into docs/performance.md: `python -m tools.performance TABLE`."""

from __future__ import annotations

import re
import sys
from pathlib import Path

PAGE = Path(__file__).parent.parent / "docs" / "performance.md"
SECTION = re.compile(r"(?<=<!-- bench -->\n).*?(?=<!-- end -->)", re.DOTALL)


def with_tables(page: str, tables: str) -> str:
    """The page with other tables in its last section, their headings one level deeper."""
    deeper = re.sub(r"^##", "###", tables, flags=re.MULTILINE)
    return SECTION.sub(lambda _: f"{deeper.strip()}\n", page)


if __name__ == "__main__":
    tables = Path(sys.argv[1]).read_text(encoding="utf-8")
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8"), tables), encoding="utf-8")
