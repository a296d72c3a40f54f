"""vidstyle comic: comic pages from a film."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import click

from vidstyle.cli.display import display, progress_option
from vidstyle.cli.options import (
    STYLE,
    Parsed,
    device_option,
    number,
    parents_option,
    parse_seconds,
    path_arguments,
)
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.comic.layout.paper import DEFAULT_DPI, LayoutKind
from vidstyle.errors import printable
from vidstyle.pipeline.progress import StepProgress


def parse_panels(text: str) -> int | None:
    """A number of panels; None for auto."""
    if text != "auto" and (not text.isdigit() or int(text) == 0):
        raise ValueError(f"{text!r} is neither a number of panels nor auto")
    return None if text == "auto" else int(text)


def parse_times(text: str) -> tuple[float, ...]:
    """Comma-separated times."""
    return tuple(float(parse_seconds(part.strip())) for part in text.split(","))


def parse_spans(text: str) -> tuple[tuple[float, float], ...]:
    """Comma-separated parts of a film, each FROM-TO: start and end in seconds."""
    spans = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not dash:
            raise ValueError(f"{part!r} is not a part of a film such as 0:10-0:25")
        spans.append((float(parse_seconds(first)), float(parse_seconds(last))))
    return tuple(spans)


PANELS, TIMES = Parsed("N|auto", parse_panels), Parsed("T,T", parse_times)
SPANS = Parsed("T-T,T-T", parse_spans)


@click.command(short_help="Make comic pages from a film or a folder of pictures.")
@path_arguments(source="INPUT", target="OUTPUT")
@click.option("--panels", type=PANELS, default="auto", help="Number of panels.")
@click.option("--at", type=TIMES, default=(), help="Times of the key frames, in seconds or as h:mm:ss.")
@click.option("--skip", type=SPANS, default=(), help="Exclude these time ranges.")
@click.option("--seed", type=number(0, whole=True), default=0, help="Select another good layout.")
@click.option("--size", metavar="NAME|WxH", help="a4, a5, a3, letter, square, strip, webtoon, 1200x1800 or "
              "210x297mm.  [default: a4; for .html strip]")  # fmt: skip
@click.option("--landscape", is_flag=True, help="Landscape orientation, for named sizes.")
@click.option("--dpi", type=number(), default=DEFAULT_DPI, help="Pixels per inch.")
@click.option("--pages", type=number(1, whole=True),
              help="Number of pages.  [default: automatic]")  # fmt: skip
@click.option("--bleed", "bleeding", is_flag=True,
              help="Full bleed: extend full-width panels to the page edge.")  # fmt: skip
@click.option("--layout", type=click.Choice(get_args(LayoutKind)), default="dynamic",
              help="Gutters: straight, slanted, or slanted from right to left; or a grid.")  # fmt: skip
@click.option("--reading", type=click.Choice(("ltr", "rtl")), default="ltr",
              help="Reading order: from left to right or from right to left.")  # fmt: skip
@click.option("--right-to-left", "reading", flag_value="rtl", help="The same as --reading rtl.")
@click.option("-s", "--style", "styles", type=STYLE, metavar="A,B,C",
              help="Styles of the panels, in rotation.  [default: comic]")  # fmt: skip
@click.option("--subtitles", type=click.Path(), metavar="FILE|none",
              help="Subtitles, .srt or .vtt.  [default: the film's]")  # fmt: skip
@click.option("--title", default="", show_default=False, help="Title above the first page.")
@click.option("--font", type=click.Path(path_type=Path), metavar="FILE",
              help="Font, .ttf or .otf.  [default: comic capitals, or one that has all letters]")  # fmt: skip
@click.option("--frames", type=click.Path(path_type=Path), metavar="FOLDER",
              help="Save the key frames, with a table of their times.")  # fmt: skip
@click.option("--save", type=click.Path(path_type=Path), metavar="FILE.toml",
              help="Write the pages as a file to edit, which can be INPUT.")  # fmt: skip
@click.option("--storyboard", is_flag=True, help="Make a contact sheet with times instead.")
@click.option("--face-model", type=click.Path(path_type=Path), metavar="FILE",
              help="Face detection model: an OpenCV cascade (.xml) or YuNet (.onnx).  "
                   "[default: MTCNN]")  # fmt: skip
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite existing files.")
@parents_option("target")
@device_option()
@progress_option
@reporting_options
def comic(source: str, target: str, styles: str | None, progress: str, **options: Any) -> int:
    """Make comic pages of INPUT, a film, a folder of pictures or what --save has written.

    OUTPUT ends in .png, .jpg or .svg (several pages become NAME-1.png and so on), .pdf, .cbz or .html.
    """
    from vidstyle.comic.make import ComicOptions, make_comic
    from vidstyle.comic.select.key_frames import KeyFrameOptions
    from vidstyle.pipeline.render import DAMAGED_EXIT_CODE

    key_frames = KeyFrameOptions(options.pop("panels"), options.pop("at"), options.pop("skip"))
    options["right_to_left"] = options.pop("reading") == "rtl"
    names = tuple(name.strip() for name in styles.split(",")) if styles else None
    comic_options = ComicOptions(key_frames=key_frames, styles=names, **options)
    with display(progress) as show:
        made = make_comic(source, target, comic_options, StepProgress(show))
    panels, pages = (_counted(*each) for each in ((len(made.key_frames), "panel"), (made.pages, "page")))
    text = printable(f"{', '.join(map(str, made.files))}: {panels} on {pages}")
    facts = {"files": [*map(str, made.files)], "panels": len(made.key_frames), "pages": made.pages}
    if damage := made.damage.report():
        say(f"{printable(source)}: {damage}")
    say(text, facts | {"damage": damage})
    return DAMAGED_EXIT_CODE if made.damage.is_significant else 0


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
