"""Writes a style in the form that the name of a file asks for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vidstyle.errors import InputError, UsageError
from vidstyle.media.write.atomic import atomic_file
from vidstyle.style import Style, style_from_table, style_text, table_from_style

EXPORT_SUFFIXES = (".html", ".hook", ".toml")
DEFAULT_ASPECT = 16 / 9
"""Of the pictures that a hook is made for, unless a film or a size says otherwise."""


def export_style(
    style: Style,
    target: Path,
    like: Path | None = None,
    overwrite: bool = False,
    film: Path | None = None,
    size: tuple[int, int] | None = None,
) -> int:
    """Write a style to a file: a page (.html), a hook for mpv and FFmpeg (.hook), or a style file (.toml).

    Args:
        like: the style's own file, whose comments a style file keeps.
        overwrite: whether the target may exist.
        film: for a hook: of which the measured steps take their percentiles, and the size.
        size: width and height of the pictures that a hook is made for.

    Returns:
        Its size in bytes.

    Raises:
        UsageError: the target has another ending, exists, or is the style's own file; or it is no hook and
            there is a film or a size.
        InputError: the film cannot be read.
        StyleError: the style cannot be used.
        OutputError: the target cannot be written.
    """
    ending = target.suffix.lower()
    if ending not in EXPORT_SUFFIXES:
        raise UsageError(target, "is no kind of export", f"end its name in {', '.join(EXPORT_SUFFIXES)}")
    if ending != ".hook" and (film or size):
        raise UsageError("--from and --size", "belong to OUT.hook", "leave them out")
    if ending != ".html" or not style.name:
        style = replace(style, name=target.stem)
    with atomic_file(target, like, overwrite) as write:
        content = _text(style, target, like, film, size).encode("utf-8")
        write(content)
    return len(content)


def _text(
    style: Style, target: Path, like: Path | None, film: Path | None, size: tuple[int, int] | None
) -> str:
    if target.suffix.lower() == ".toml":
        style_from_table(table_from_style(style), style.name, folder=target.absolute().parent)
        return style_text(style, like)
    if target.suffix.lower() == ".html":
        from vidstyle.export.page import page_of_style

        return page_of_style(style)
    return _hook(style, film, size)


def _hook(style: Style, film: Path | None, size: tuple[int, int] | None) -> str:
    from vidstyle.export.frozen import frames_of, freeze_colors, frozen_percentiles, usual_picture
    from vidstyle.export.hook import growing, hook_of
    from vidstyle.gpu.compile.es import es_plan

    frames = list(frames_of(film)) if film else []
    if film and not frames:
        raise InputError(film, "has no frames", "name another film")
    if size is None and frames:
        height, width = frames[0].shape[:2]
    else:
        height = round(style.height or 720)
        width, height = size or (round(height * DEFAULT_ASPECT), height)
    plan = es_plan(style, width, height, depth=0)
    powers = growing(plan, lambda other: es_plan(other, width, height, depth=0), style)
    shown = frames or [usual_picture(width // 4, height // 4)]
    freeze_colors(plan, shown)
    frozen = frozen_percentiles(style, shown) if plan["measures"] else {}
    return hook_of(style, plan, powers, frozen, film.name if film else "a picture of all tones")
