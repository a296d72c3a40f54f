"""Insert measurements into docs/performance.md.

    python tools/compare_peers.py CLIP > peers.md
    vidstyle bench --film CLIP -o film.md
    vidstyle bench --size 1920x1080 -o bench.md
    python -m tools.performance peers.md film.md bench.md

The name of a file without its ending selects the section. The table of GPU memory traffic is computed on each
run.
"""

from __future__ import annotations

import re
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from pathlib import Path

from vidstyle.gpu.compile.explain import plan_traffic
from vidstyle.gpu.compile.plan import plan_for_video
from vidstyle.style import load_style, style_names

PAGE = Path(__file__).parent.parent / "docs" / "performance.md"

MEMORY_RATES = (320, 4800)
"""Memory bandwidths in GB/s of the GPUs in the table of traffic."""


def replace_section(page: str, section: str, tables: str) -> str:
    """Return the page with the tables of a section replaced, their headings one level deeper.

    Raises:
        ValueError: the page has no such section.
    """
    place = re.compile(rf"(?<=<!-- {re.escape(section)} -->\n).*?(?=<!-- end -->)", re.DOTALL)
    if not place.search(page):
        raise ValueError(f"{PAGE} has no section {section}")
    deeper = re.sub(r"^##", "###", tables, flags=re.MULTILINE)
    return place.sub(lambda _: f"{deeper.strip()}\n", page, count=1)


def format_traffic() -> str:
    """Return a table of passes, memory traffic per pixel at 1920x1080, and speed limits of each style."""
    plans = {name: plan_for_video(load_style(name), 1920, 1080, "compute") for name in style_names()}
    traffic = {name: plan_traffic(plan) for name, plan in plans.items()}
    moved = {name: each.read + each.written for name, each in traffic.items() if plans[name].passes}
    cards = [f"at {each} GB/s, MP/s at most" for each in MEMORY_RATES]
    lines = [f"| {' | '.join(('style', 'passes', 'bytes a pixel', *cards))} |", "|---|---:|---:|---:|---:|"]
    for name in sorted(moved, key=lambda name: moved[name]):
        bounds = (f"{1000 * each / moved[name]:,.0f}" for each in MEMORY_RATES)
        cells = (name, str(len(plans[name].passes)), f"{moved[name]:.1f}", *bounds)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="*", type=Path, help="files with tables")
    page = replace_section(PAGE.read_text(encoding="utf-8"), "traffic", format_traffic())
    for path in parser.parse_args().tables:
        page = replace_section(page, path.stem, path.read_text(encoding="utf-8"))
    PAGE.write_text(page, encoding="utf-8")
