"""Export a style in the format of a file extension."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vidstyle.errors import InputError, UsageError, text_of_name
from vidstyle.media.write.atomic import atomic_file
from vidstyle.style import Style, style_from_table, style_text, table_from_style

EXPORT_SUFFIXES = (".html", ".hook", ".toml")
DEFAULT_ASPECT = 16 / 9
"""Aspect ratio for hooks without a film or a size."""


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
        like: the original file of the style, whose comments a style file keeps.
        overwrite: whether to replace an existing target.
        film: for a hook: take measurements and size from this film.
        size: for a hook: width and height of the pictures.

    Returns:
        The size of the file in bytes.

    Raises:
        UsageError: the target has an unknown extension, exists, or is `like`; or `film` or `size` is given
            without a hook.
        InputError: the film cannot be read.
        StyleError: the style is invalid.
        OutputError: the target cannot be written.
    """
    ending = target.suffix.lower()
    if ending not in EXPORT_SUFFIXES:
        raise UsageError(target, "is no kind of export", f"end its name in {', '.join(EXPORT_SUFFIXES)}")
    if ending != ".hook" and (film or size):
        raise UsageError("--from and --size", "belong to OUT.hook", "leave them out")
    if ending != ".html" or not style.name:
        style = replace(style, name=text_of_name(target.stem))
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
    from vidstyle.export.hook import height_powers, hook_of
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
    powers = height_powers(plan, lambda other: es_plan(other, width, height, depth=0), style)
    shown = frames or [usual_picture(width // 4, height // 4)]
    freeze_colors(plan, shown)
    frozen = frozen_percentiles(style, shown) if plan["measures"] else {}
    return hook_of(style, plan, powers, frozen, film.name if film else "a picture of all tones")
