"""The tiles of the start screen: the whole frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from media import make_picture
from PIL import Image

from vidstyle.design.look_tiles import LookTiles
from vidstyle.preview.clip import open_clip
from vidstyle.regions.boxes import Box
from vidstyle.regions.still_faces import NO_FACES, KnownFaces
from vidstyle.style import Step, Style, load_style

SMALL_FACE = Box(0.1, 0.3, 0.16, 0.4)


@pytest.mark.parametrize(
    ("size", "shape"),
    [((1, 1), (1, 1)), ((900, 600), (213, 320)), ((90, 12), (12, 90)), ((600, 900), (480, 320))],
)
def test_a_tile_of_any_frame_has_at_most_the_width_that_is_asked(
    tmp_path: Path, size: tuple[int, int], shape: tuple[int, int]
) -> None:
    clip = open_clip(make_picture(tmp_path / "picture.png", size=size))
    tile = LookTiles(clip, 0, NO_FACES).render(load_style("poster"), 320)
    assert tile.shape == (*shape, 3)
    clip.close()


def test_a_mask_from_a_file_has_its_place_in_the_frame(tmp_path: Path) -> None:
    mask = np.zeros((90, 160), np.uint8)
    mask[:, :80] = 255
    Image.fromarray(mask).save(tmp_path / "left.png")
    Image.fromarray(np.full((90, 160, 3), 96, np.uint8)).save(tmp_path / "gray.png")
    masks = {"left": {"file": "left.png"}}
    style = Style("half", only="left", masks=masks, background=(Step("invert"),), folder=tmp_path)
    clip = open_clip(tmp_path / "gray.png")
    tile = LookTiles(clip, 0, KnownFaces({SMALL_FACE: ()}, 1.0)).render(style)
    clip.close()
    middle = tile.shape[1] // 2
    assert (tile[:, : middle - 4] > 140).all(), "inverted"
    assert (tile[:, middle + 4 :] < 110).all()
