"""vidstyle comic: comic pages from a film."""

from __future__ import annotations

from typing import Any, get_args

import click

from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import STYLE, Parsed, device_option, number
from vidstyle.cli.parsing.cue_options import cues_option
from vidstyle.cli.parsing.film_options import angle_of, rotate_option
from vidstyle.cli.parsing.path_arguments import PATH, PATH_TEXT, parents_option, path_arguments
from vidstyle.cli.terminal.display import display, progress_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.comic.layout.paper import DEFAULT_DPI, PRINT_DPI, LayoutKind
from vidstyle.cues.style_change import StyleChange
from vidstyle.cues.times import parse_seconds
from vidstyle.errors import UsageError, counted, log, printable
from vidstyle.pipeline.progress import StepProgress


def parse_panels(text: str) -> int | None:
    """Return a number of panels; None for auto."""
    if text != "auto" and (not text.isdigit() or int(text) == 0):
        raise ValueError(f"{text!r} is not a number of panels or auto")
    return None if text == "auto" else int(text)


def parse_times(text: str) -> tuple[float, ...]:
    """Comma-separated times."""
    return tuple(float(parse_seconds(part.strip())) for part in text.split(","))


def parse_spans(text: str) -> tuple[tuple[float, float], ...]:
    """Comma-separated time ranges, each FROM-TO: start and end in seconds."""
    spans = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not dash:
            raise ValueError(f"{part!r} is not a time range such as 0:10-0:25")
        spans.append((float(parse_seconds(first)), float(parse_seconds(last))))
    return tuple(spans)


def parse_change(text: str) -> StyleChange:
    """Return where the style of the panels changes."""
    change = StyleChange.parse(text)
    if change.kind == "like":
        raise ValueError("'like' is for films; panels have scene, shot:3 or 30s")
    return change


PANELS, TIMES = Parsed("N|auto", parse_panels), Parsed("T,T", parse_times)
SPANS = Parsed("T-T,T-T", parse_spans)


@command(
    "Make comic pages from a film or a folder of pictures.",
    examples=(
        "vidstyle comic in.mp4 page.pdf",
        'vidstyle comic in.mp4 page.png --panels 8 -s ink,noir --title "A holiday"',
        "vidstyle comic photographs/ strip.html --size strip",
    ),
    epilog="Styles: vidstyle styles. Guide: docs/commands.md in the source folder.",
)
@path_arguments(source="INPUT", target="OUTPUT")
@option("--panels", type=PANELS, metavar="N|auto", default="auto", group=Group.KEY_FRAMES,
        help="Number of panels.")  # fmt: skip
@option("--at", type=TIMES, default=(), group=Group.KEY_FRAMES,
        help="Times of the key frames, in seconds or as h:mm:ss.")  # fmt: skip
@option("--skip", type=SPANS, default=(), group=Group.KEY_FRAMES, help="Exclude these time ranges.")
@rotate_option
@option("--seed", type=number(0, whole=True), default=0, group=Group.PAGE_LAYOUT,
        help="Random seed for variations of layout and frames; 0 is the best.")  # fmt: skip
@option("--size", metavar="NAME|WxH", group=Group.PAGE_LAYOUT,
        help="a4, a5, a3, letter, square, screen, strip, webtoon, 1200x1800 or 210x297mm.  "
             "[default: a4; screen for .html]")  # fmt: skip
@option("--landscape", is_flag=True, group=Group.PAGE_LAYOUT, help="Landscape orientation, for named sizes.")
@option("--dpi", type=number(), group=Group.PAGE_LAYOUT,
        help=f"Pixels per inch.  [default: {DEFAULT_DPI}; {PRINT_DPI} for .pdf]")  # fmt: skip
@option("--pages", type=number(1, whole=True), group=Group.PAGE_LAYOUT,
        help="Number of pages.  [default: automatic]")  # fmt: skip
@option("--bleed", "bleeding", is_flag=True, group=Group.PAGE_LAYOUT,
        help="Full bleed: extend full-width panels to the page edge.")  # fmt: skip
@option("--layout", type=click.Choice(get_args(LayoutKind)), default="dynamic", group=Group.PAGE_LAYOUT,
        help="Gutters: straight, slanted, slanted right to left with full bleed, or a grid.")  # fmt: skip
@option("--reading", type=click.Choice(("ltr", "rtl")), group=Group.PAGE_LAYOUT,
        help="Reading order: left to right or right to left.  [default: ltr]")  # fmt: skip
@option("--right-to-left", is_flag=True, hidden=True, group=Group.PAGE_LAYOUT)
@option("-s", "--style", "styles", type=STYLE, metavar="A,B,C", group=Group.STYLE,
        help="Styles of the panels, in rotation.  [default: comic]")  # fmt: skip
@option("--by", type=Parsed("change", parse_change), group=Group.STYLE,
        help="Change the style by scene instead of by panel: scene, shot:3 or 30s.")  # fmt: skip
@cues_option("Cue file with the styles of the panels; instead of --style.")
@option("--subtitles", type=PATH_TEXT, metavar="FILE|none", group=Group.LETTERING,
        help="Subtitle file, .srt or .vtt.  [default: the film's]")  # fmt: skip
@option("--title", default="", show_default=False, group=Group.LETTERING,
        help="Title above the first page.")  # fmt: skip
@option("--font", type=PATH, metavar="FILE", group=Group.LETTERING,
        help="Font file, .ttf or .otf.  [default: comic capitals, or a font with all letters]")  # fmt: skip
@option("--frames", type=PATH, metavar="FOLDER", group=Group.OUTPUT,
        help="Save the key frames and a table of their times.")  # fmt: skip
@option("--save", type=PATH, metavar="FILE.toml", group=Group.OUTPUT,
        help="Save the pages as an editable file, which can be INPUT later.")  # fmt: skip
@option(
    "--storyboard", is_flag=True, group=Group.PAGE_LAYOUT, help="Make a contact sheet with times instead."
)
@option("--face-model", type=PATH, metavar="FILE", group=Group.KEY_FRAMES,
        help="Face detection model: an OpenCV cascade (.xml) or YuNet (.onnx).  "
             "[default: MTCNN]")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite existing files.")
@parents_option("target")
@device_option()
@progress_option
@reporting_options
def comic(source: str, target: str, styles: str | None, progress: str, **options: Any) -> int:
    """Make comic pages from INPUT: a film, a folder of pictures, or a file written by --save.

    OUTPUT ends in .png, .jpg or .svg (several pages become NAME-1.png and so on), .pdf, .cbz,
    .epub or .html.
    """
    from vidstyle.comic.make import ComicOptions, make_comic
    from vidstyle.comic.select.key_frames import KeyFrameOptions
    from vidstyle.cues.cue_file import read_cue_file
    from vidstyle.pipeline.render import DAMAGED_EXIT_CODE

    key_frames = KeyFrameOptions(options.pop("panels"), options.pop("at"), options.pop("skip"))
    options["rotate"] = angle_of(options["rotate"])
    options["right_to_left"] = _reads_backwards(options.pop("reading"), options)
    names = tuple(name.strip() for name in styles.split(",")) if styles else None
    if options["cues"] is not None:
        if given := [name for name, value in (("--style", styles), ("--by", options["by"])) if value]:
            raise UsageError(given[0], "cannot be used with --cues", "write it in the cue file")
        options["cues"] = read_cue_file(options["cues"])
    comic_options = ComicOptions(key_frames=key_frames, styles=names, **options)
    with display(progress) as show:
        made = make_comic(source, target, comic_options, StepProgress(show))
    panels, pages = (counted(*each) for each in ((len(made.key_frames), "panel"), (made.pages, "page")))
    text = printable(f"{', '.join(map(str, made.files))}: {panels} on {pages}")
    facts = {"files": [*map(str, made.files)], "panels": len(made.key_frames), "pages": made.pages}
    if damage := made.damage.report():
        say(f"{printable(source)}: {damage}")
    say(text, facts | {"damage": damage, "omitted": [*made.omitted]})
    return DAMAGED_EXIT_CODE if made.damage.is_significant else 0


def _reads_backwards(reading: str | None, options: dict[str, Any]) -> bool:
    """Return whether `--reading`, or an option that implies it, asks for the order from right to left."""
    implying = {"--right-to-left": options["right_to_left"], "--layout manga": options["layout"] == "manga"}
    for name, is_given in implying.items():
        if is_given and reading == "ltr":
            raise UsageError(name, "contradicts --reading ltr", "remove one of them")
    if options["right_to_left"]:
        log.warning("--right-to-left: replaced by --reading rtl")
    return reading == "rtl" or any(implying.values())
