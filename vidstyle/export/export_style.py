"""Export a style in the format of a file extension."""

from __future__ import annotations

from pathlib import Path

from vidstyle.errors import UsageError, log
from vidstyle.export.export_targets import EXPORT_TARGETS, ExportRequest, film_targets
from vidstyle.media.write.atomic import atomic_file
from vidstyle.style import Style
from vidstyle.style.resolve import masks_read


def export_style(
    style: Style,
    target: Path,
    like: Path | None = None,
    overwrite: bool = False,
    film: Path | None = None,
    size: tuple[int, int] | None = None,
) -> int:
    """Write a style to a file, in the format of its extension (see `EXPORT_TARGETS`).

    Args:
        like: the original file of the style, whose comments a style file keeps.
        overwrite: whether to replace an existing target.
        film: for a hook: take measurements and size from this film.
        size: for a hook: width and height of the pictures.

    Returns:
        The size of the file in bytes.

    Raises:
        UsageError: the target has an unknown extension, exists, or is `like`; or `film` or `size` is given
            for a target that does not use them.
        InputError: the film cannot be read.
        StyleError: the style is invalid.
        OutputError: the target cannot be written.
    """
    kind = target.suffix.lower().removeprefix(".")
    if kind not in EXPORT_TARGETS:
        endings = ", ".join(f".{each}" for each in EXPORT_TARGETS)
        raise UsageError(target, "is not an export format", f"end its name in {endings}")
    if not EXPORT_TARGETS[kind].uses_film and (film or size):
        raise UsageError("--from and --size", f"apply only to {film_targets()}", "remove them")
    if EXPORT_TARGETS[kind].fixes_masks and (names := masks_read(style)):
        log.info(
            "masks are not exported (%s): people fill the picture, other masks are empty", ", ".join(names)
        )
    with atomic_file(target, like, overwrite) as write:
        content = EXPORT_TARGETS[kind].write(ExportRequest(style, target, like, film, size)).encode("utf-8")
        write(content)
    if style.focus and style.height is not None and not EXPORT_TARGETS[kind].has_focus:
        log.info("%s has no focus on faces: what runs it finds no faces", target, extra={"once": True})
    return len(content)
