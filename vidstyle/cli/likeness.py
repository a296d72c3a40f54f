"""`vidstyle styles --like`: the styles that come nearest to the look of a picture."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from vidstyle.cli.terminal.display import display
from vidstyle.cli.terminal.reporting import say
from vidstyle.errors import UsageError, printable
from vidstyle.pipeline.progress import StepProgress

MAX_SHOWN_STYLES = 5
"""Number of styles in the output."""


def print_like(picture: str, source: str | None, options: Mapping[str, Any], as_json: bool) -> None:
    """Print the nearest styles; with -o search for a nearer one, and write it.

    Args:
        picture: of the look that is wanted.
        source: what the styles are tried on, or None for a photograph of the program's own.
    """
    from vidstyle.explore.matching.like import known_styles, photograph_for, rank_styles, search_styles
    from vidstyle.gallery.preview import read_still
    from vidstyle.style import save_style

    output: Path | None = options["output"]
    if output is not None and (output.suffix != ".toml" or (output.exists() and not options["overwrite"])):
        reason = "is not a style file" if output.suffix != ".toml" else "already exists"
        raise UsageError(
            output, reason, "name a new file that ends in .toml" + ", or add -y" * output.exists()
        )
    wanted, photograph = read_still(picture), photograph_for(source)
    with display(options["progress"]) as show:
        step = StepProgress(show)
        nearest = rank_styles(wanted, photograph, known_styles(), step)
        best = search_styles(wanted, photograph, nearest, step)[0] if output is not None else None
    rows = [{"name": each.style.name, "distance": round(each.distance, 3)} for each in nearest]
    lines = [f"{each.style.name:20} {each.words}" for each in nearest[:MAX_SHOWN_STYLES]]
    if output is not None and best is not None:
        save_style(best.style, output)
        reached = "" if best.is_near else "; no style found reaches this look"
        lines.append(f"{printable(str(output)):20} {best.words}; {nearest[0].words} before tuning{reached}")
    click.echo(json.dumps(rows, indent=2) if as_json else "\n".join(lines))
    if output is None:
        say("1 is typical within one style; add -o FILE.toml to search for a closer style")
