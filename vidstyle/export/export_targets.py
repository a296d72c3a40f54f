"""The targets of `vidstyle export`: one table, which the command, the pages and the documents read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vidstyle.errors import InputError, text_of_name

if TYPE_CHECKING:
    from vidstyle.style import Style

DEFAULT_ASPECT = 16 / 9
"""Aspect ratio for hooks without a film or a size."""


@dataclass(frozen=True)
class ExportRequest:
    """What to export, and where to.

    Attributes:
        style: the style.
        path: the file to write.
        like: the original file of the style, or None.
        film: the film to take measurements and size from, or None; for targets that use a film.
        size: width and height of the pictures, or None; for the same targets.
    """

    style: Style
    path: Path
    like: Path | None = None
    film: Path | None = None
    size: tuple[int, int] | None = None

    @property
    def named_style(self) -> Style:
        """The style under the name of the file."""
        return replace(self.style, name=text_of_name(self.path.stem))


@dataclass(frozen=True)
class ExportTarget:
    """A format for other programs.

    Attributes:
        title: its name on buttons.
        use: what one does with the file, in plain words.
        help: what the file is, as a noun phrase.
        example: arguments of the command after the style, as an example.
        write: returns the text of the file.
        uses_film: whether it takes `film` and `size`.
        has_focus: whether faces get finer detail where the file is used.
        fixes_masks: whether its masks are the same in every frame.
    """

    title: str
    use: str
    help: str
    example: str
    write: Callable[[ExportRequest], str]
    uses_film: bool = False
    has_focus: bool = False
    fixes_masks: bool = True


def _page(request: ExportRequest) -> str:
    from vidstyle.export.page import page_of_style

    return page_of_style(request.style if request.style.name else request.named_style)


def _hook(request: ExportRequest) -> str:
    from vidstyle.export.frozen import frames_of, freeze_colors, frozen_percentiles, usual_picture
    from vidstyle.export.hook import height_powers, hook_of
    from vidstyle.gpu.compile.es import EsPlan

    style, film, size = request.named_style, request.film, request.size
    frames = list(frames_of(film)) if film else []
    if film and not frames:
        raise InputError(film, "has no frames", "name another film")
    if size is None and frames:
        height, width = frames[0].shape[:2]
    else:
        height = round(style.height or 720)
        width, height = size or (round(height * DEFAULT_ASPECT), height)
    start = EsPlan.of(style, width, height, depth=0)
    powers = height_powers(start, lambda other: EsPlan.of(other, width, height, depth=0), style)
    plan = start.data
    shown = frames or [usual_picture(width // 4, height // 4)]
    freeze_colors(plan, shown)
    frozen = frozen_percentiles(style, shown) if plan["measures"] else {}
    return hook_of(style, plan, powers, frozen, film.name if film else "a picture of all tones")


def _style_file(request: ExportRequest) -> str:
    from vidstyle.style import style_from_table, style_text, table_from_style

    style = request.named_style
    style_from_table(table_from_style(style), style.name, folder=request.path.absolute().parent)
    return style_text(style, request.like)


EXPORT_TARGETS: Mapping[str, ExportTarget] = {
    "html": ExportTarget(
        "Web page", "To use this look in any browser, or to send it to somebody",
        "a page for the browser that restyles a camera, films and photographs", "ink.html", _page,
    ),
    "hook": ExportTarget(
        "Video player", "To watch films in this look in a player such as mpv",
        "a shader for mpv, FFmpeg and other libplacebo players", "ink.hook --size 1280x720",
        _hook, uses_film=True,
    ),
    "toml": ExportTarget(
        "Style file", "To keep this look with all changes, and open it here again",
        "a style file with all changes, to edit and use with `--style`", "my-ink.toml --steady 0.8",
        _style_file, has_focus=True, fixes_masks=False,
    ),
}  # fmt: skip
"""The targets by the extension of their files."""


def describe_targets() -> list[dict[str, str]]:
    """Return what a page shows of each target."""
    return [
        {"kind": kind, "title": target.title, "use": target.use, "help": target.help.replace("`", "")}
        for kind, target in EXPORT_TARGETS.items()
    ]


def film_targets() -> str:
    """Return the targets that take a film or a size: "OUT.hook"."""
    return ", ".join(f"OUT.{kind}" for kind, target in EXPORT_TARGETS.items() if target.uses_film)
