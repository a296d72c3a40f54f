"""Small pictures for the tests of planes, blocks and the CPU renderer, and a function that restyles one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from media import photograph

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.core.planes import color_rows
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.regions.boxes import Box
from vidstyle.style import Step, Style

VIDEO = Encoding()
RGB8 = Encoding(full_range=True, subsampling=(1, 1))
FLOAT = Encoding(depth=0, full_range=True, subsampling=(1, 1))
"""float32 planes at full chroma resolution."""


def step(block: str = "", save: str = "", source: str = "", **values: Any) -> Step:
    return Step(block, values, save, source)


def style(*background: Step, **fields: Any) -> Style:
    return Style("test", background=background, **fields)


def run(chosen: Style, picture: Picture, threads: int = 2, **options: Any) -> Picture:
    with CpuRenderer(chosen, threads) as renderer:
        return renderer.run(picture, **options)


def run_luma(chosen: Style, luma: np.ndarray, **options: Any) -> np.ndarray:
    """Restyle a gray float picture and return the luma of the result, float32."""
    result = run(chosen, Picture(FLOAT, luma=np.asarray(luma, np.float32)), **options).luma
    assert result is not None
    return result


def run_color(chosen: Style, color: np.ndarray, **options: Any) -> np.ndarray:
    """Restyle an RGB float picture and return the RGB of the result, float32."""
    result = run(chosen, Picture(FLOAT, color=np.asarray(color, np.float32)), rgb=True, **options).color
    assert result is not None
    return result


def noise(*shape: int, seed: int = 1, low: float = 0, high: float = 1) -> np.ndarray:
    return np.random.default_rng(seed).uniform(low, high, shape).astype(np.float32)


def codes(encoding: Encoding, height: int, width: int, seed: int = 1) -> Picture:
    """Return random planes in the legal range of an encoding, whose RGB is within 0..1."""
    random = np.random.default_rng(seed)

    def plane(shape: tuple[int, int], low: float, high: float) -> np.ndarray:
        values = random.uniform(low, high, shape)
        return (values if encoding.depth == 0 else np.rint(values)).astype(encoding.dtype)

    (black, white), (neutral, span) = encoding.luma_levels, encoding.chroma_levels
    chroma_shape = encoding.chroma_shape(height, width)
    luma = plane((height, width), black + 0.4 * (white - black), black + 0.6 * (white - black))
    blue, red = (plane(chroma_shape, neutral - 0.12 * span, neutral + 0.12 * span) for _ in range(2))
    return Picture(encoding, luma=luma, chroma=(blue, red))


def planes(picture: Picture) -> list[np.ndarray]:
    """Return all planes of a picture."""
    held = (picture.luma, *(picture.chroma or ()), picture.color, picture.alpha)
    return [plane for plane in held if plane is not None]


def same_bits(first: Picture, second: Picture) -> bool:
    pairs = zip(planes(first), planes(second), strict=True)
    return first.encoding == second.encoding and all(
        one.dtype == two.dtype and one.shape == two.shape and one.tobytes() == two.tobytes()
        for one, two in pairs
    )


def rgb_of(picture: Picture) -> np.ndarray:
    return color_rows(picture, 0, picture.shape[0]).astype(np.float64)


SOURCES = {
    "video": codes(VIDEO, 37, 41),
    "deep": codes(Encoding("bt2020", depth=10, subsampling=(2, 1)), 37, 41),
    "rgb": Picture(RGB8, color=codes(RGB8, 37, 41 * 3).luma.reshape(37, 41, 3)),  # type: ignore[union-attr]
    "float": Picture(FLOAT, color=noise(37, 41, 3)),
    "gray": Picture(VIDEO, luma=codes(VIDEO, 37, 41).luma),
}
"""One picture of each kind, 37 x 41."""

TARGETS = [
    VIDEO,
    Encoding("bt601"),
    Encoding("bt2020", depth=10),
    Encoding(full_range=True),
    Encoding(subsampling=(2, 1)),
    Encoding(subsampling=(1, 1)),
    Encoding(subsampling=(4, 1)),
    Encoding(subsampling=(4, 4), siting=(0.0, 0.0)),
    Encoding(siting=SITINGS["topleft"]),
    Encoding(siting=SITINGS["bottom"]),
    Encoding("bt601", True, 16, (1, 2)),
    FLOAT,
]
"""Encodings of results: matrices, ranges, depths, chroma grids and sitings."""


_PICTURE_SIZE = 480, 640
"""Height and width of pictures with a face."""
FACE = Box(60, 21, 105, 77)
"""The face in the crop of a photograph that is pasted over the background."""


def picture_with_face(left: float | None = 250, top: float = 150) -> np.ndarray:
    """Return a face, 56 pixels high, in front of a table, H x W x 3 uint8; if `left` is None only the table.

    Args:
        left, top: position of the crop with the face, in pixels.
    """
    table = cv2.resize(photograph("coffee"), _PICTURE_SIZE[::-1], interpolation=cv2.INTER_AREA)
    if left is None:
        return table
    person = cv2.resize(
        photograph("astronaut")[20:260, 60:360], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA
    )
    place = np.array([[1, 0, left], [0, 1, top]], np.float32)
    return cv2.warpAffine(person, place, _PICTURE_SIZE[::-1], table, borderMode=cv2.BORDER_TRANSPARENT)


def keep_writing(picture: Picture, amount: float) -> tuple[Picture, list[object]]:
    """Replace `lift_writing`, also in other processes."""
    return picture, []


def picture_with_writing(dark: bool = True) -> np.ndarray:
    """Return two lines of thin letters, on a sheet on a table, H x W x 3 uint8; or the negative."""
    sheet = np.repeat(np.linspace(215, 235, 640, dtype=np.float32)[None, :, None], 480, axis=0)
    picture = np.repeat(sheet, 3, axis=2).astype(np.uint8)
    picture[330:], picture[360:420, 200:440] = (60, 50, 40), (250, 250, 245)
    for top, words in ((130, "the quick brown fox"), (180, "jumps over 13 dogs")):
        cv2.putText(picture, words, (140, top), cv2.FONT_HERSHEY_COMPLEX, 0.6, (30, 30, 40), 1, cv2.LINE_AA)
    return picture if dark else 255 - picture


def film_with_face(place: Callable[[int], float | None], frames: int) -> list[tuple[Picture, float]]:
    """Return frames at 25 per second with their times; `place` returns `left` of the face in a frame."""
    return [(Picture.from_array(picture_with_face(place(number))), number / 25) for number in range(frames)]
