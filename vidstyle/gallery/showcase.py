"""A page on which many styles restyle the photograph, film or camera of its visitor, without a server."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import cv2
import numpy as np

import vidstyle
from vidstyle.errors import UsageError, counted, output_error
from vidstyle.export.adjust import main_controls
from vidstyle.export.page import (
    WORKING_SIDES_PX,
    minify_css,
    page_data,
    page_script,
    viewer_css,
    viewer_markup,
)
from vidstyle.gallery.preview import read_still
from vidstyle.gallery.style_samples import jpeg_address, samples_of
from vidstyle.gallery.thumbnail import thumbnail_photograph
from vidstyle.media.picture_bytes import webp_bytes
from vidstyle.media.write.atomic import atomic_file
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.style import Style, set_values, style_text, table_from_style
from vidstyle.style.paths import steps_by_path

TILE_SIDE_PX = 240
"""The working size of the tiles: the smallest of each style."""
TILE_WIDTH_PX = 320
"""Width of the finished pictures of tiles."""
TILE_QUALITY = 62
_ASSETS = Path(__file__).with_name("showcase")
_PIECE = re.compile(r"\n(?=\S)")


@dataclass(frozen=True)
class ExamplePicture:
    """A picture that comes with the page, H x W x 3 uint8 RGB."""

    name: str
    title: str
    picture: np.ndarray


@dataclass
class _Shared:
    """Pieces of shader texts and the textures that styles share."""

    pieces: dict[str, int] = field(default_factory=dict)
    textures: dict[str, Any] = field(default_factory=dict)

    def numbers(self, text: str) -> list[int]:
        """Return the numbers of the top-level declarations of a shader text."""
        return [self.pieces.setdefault(piece, len(self.pieces)) for piece in _PIECE.split(text)]


def read_example(path: Path) -> ExamplePicture:
    """Read a photograph, or the middle frame of a film.

    Raises:
        InputError: it cannot be read.
    """
    return ExamplePicture(path.stem, path.stem, read_still(path))


def default_example() -> ExamplePicture:
    """Return the photograph that comes with vidstyle."""
    return ExamplePicture("face", "A face", thumbnail_photograph())


def write_showcase(
    folder: Path,
    styles: Sequence[Style],
    examples: Sequence[ExamplePicture],
    title: str,
    overwrite: bool = False,
    on_step: ProgressCallback = ignore_progress,
    unlisted: Sequence[Style] = (),
) -> int:
    """Write the page of `styles` to `folder/index.html`, and its data next to it.

    Args:
        folder: is created if it does not exist.
        examples: pictures to start with, at least one.
        title: heading of the page.
        overwrite: whether to replace existing files.
        on_step: receives progress.
        unlisted: further styles, which the page shows only by their address, `index.html#NAME`. With
            `index.html?embed#NAME`, it shows nothing else, in a frame of another page.

    Returns:
        The size of all files in bytes.

    Raises:
        UsageError: a file exists, or there is no example.
        OutputError: a file cannot be written.
        StyleError: a style cannot be exported.
    """
    if not examples:
        raise UsageError("the page", "needs a picture to start with", "name one")
    count = 0
    for name, content in _files(styles, examples, title, on_step, unlisted):
        path = folder / name
        _make_folder(folder)
        _make_folder(path.parent, parents=True)
        with atomic_file(path, None, overwrite) as write:
            write(content)
        count += len(content)
    return count


def _make_folder(folder: Path, parents: bool = False) -> None:
    try:
        folder.mkdir(parents=parents, exist_ok=True)
    except OSError as error:
        raise output_error(folder, error) from None


def _files(
    styles: Sequence[Style],
    examples: Sequence[ExamplePicture],
    title: str,
    on_step: ProgressCallback,
    unlisted: Sequence[Style],
) -> Iterator[tuple[str, bytes]]:
    """Yield the path of each file in the folder, and its content."""
    yield "index.html", _index(styles, examples, title, unlisted).encode("utf-8")
    yield "showcase.css", (viewer_css() + minify_css(_asset("showcase.css"))).encode("utf-8")
    yield "showcase.js", page_script(_ASSETS / "showcase.js").encode("utf-8")
    shared = _Shared()
    for number, style in enumerate(styles):
        on_step("exporting styles", number, len(styles))
        yield _data_file(f"styles/{style.name}", _style_data(style, shared))
    for style in unlisted:
        yield _data_file(f"styles/{style.name}", _style_data(style, shared))
    yield _data_file("shaders", list(shared.pieces))
    for name, texture in shared.textures.items():
        yield _data_file(f"textures/{name}", texture)
    for example in examples:
        yield _data_file(f"pictures/{example.name}", jpeg_address(example.picture))
        yield f"pictures/{example.name}.webp", _tile(example.picture)
        for number, sample in enumerate(samples_of(example.picture, styles)):
            on_step(f"drawing {example.title}", number, len(styles))
            yield f"pictures/{example.name}/{sample.style.name}.webp", _tile(sample.picture)


def _index(
    styles: Sequence[Style], examples: Sequence[ExamplePicture], title: str, unlisted: Sequence[Style]
) -> str:
    listed, hidden = (
        [{"name": style.name, "note": style.summary.replace("`", "")} for style in each]
        for each in (styles, unlisted)
    )
    pictures = [{"name": each.name, "title": each.title} for each in examples]
    close = '<button id="close" aria-label="Back to all looks">All looks</button>\n'
    viewer = viewer_markup(Style(""), _asset("panel.html"))
    return Template(_asset("index.html")).substitute(
        title=escape(title),
        count=counted(len(styles), "look"),
        version=vidstyle.__version__,
        viewer=close + viewer,
        data=json.dumps({"styles": listed, "unlisted": hidden, "pictures": pictures}).replace("</", "<\\/"),
    )


def _style_data(style: Style, shared: _Shared) -> dict[str, Any]:
    data = page_data(style, (TILE_SIDE_PX, *sorted(WORKING_SIDES_PX)))
    shared.textures |= data["textures"]
    (vertex,) = {each["plan"].pop("vertex") for each in data["plans"]}
    return data | {
        "vertex": shared.pieces.setdefault(vertex, len(shared.pieces)),
        "shaders": [shared.numbers(text) for text in data["shaders"]],
        "textures": list(data["textures"]),
        "file": _style_file(style, data["controls"]),
    }


def _style_file(style: Style, controls: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the style file, and where it sets the value of each control.

    A place is the number of a line and whether that line sets the value; if not, it belongs after the line.
    """
    wanted = {control["path"] for control in controls}
    values = {each["path"]: each["value"] for each in main_controls(style) if each["path"] in wanted}
    explicit = set_values(style, values)
    text = style_text(explicit)
    lines = _lines_by_path(text, table_from_style(explicit))
    places = {
        path: [lines[path], True] if path in lines else [lines[f"{path.rpartition('.')[0]}"], False]
        for path in values
    }
    return {"text": text, "places": places}


def _lines_by_path(text: str, table: dict[str, Any]) -> dict[str, int]:
    """Return the numbers of the lines of a style file, by path: of values, of steps, and of the name ("")."""
    steps = iter(steps_by_path(table))
    found, step = {}, ""
    for number, line in enumerate(text.split("\n")):
        key, _, _ = line.partition(" = ")
        if line.startswith("[variants"):
            break
        if key == "block":
            step = next(steps)
        found[f"{step}.{key}".strip(".") if key not in ("block", "name") else step] = number
    return found


def _data_file(path: str, value: Any) -> tuple[str, bytes]:
    text = json.dumps(value, separators=(",", ":"))
    return f"data/{path}.js", f"vidstyleData({json.dumps(path)},{text});\n".encode()


def _tile(picture: np.ndarray) -> bytes:
    height, width = picture.shape[:2]
    size = TILE_WIDTH_PX, max(1, round(TILE_WIDTH_PX * height / width))
    return webp_bytes(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), TILE_QUALITY)


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8")
