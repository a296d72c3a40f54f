"""Alpha: kept through every style, restyled edges, and a colour behind it."""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from media import photograph
from PIL import Image

from vidstyle.core.convert import convert
from vidstyle.core.matte import over_color
from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import UsageError
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.pipeline.render import render
from vidstyle.renderer import stylize
from vidstyle.style import style_names

SIZE_PX = (160, 120)
DOTS = {"format": 1, "name": "dots", "background": [{"block": "halftone"}]}
LINES = {"format": 1, "name": "lines", "lines": [{"block": "sobel"}]}
INVERTED = {"format": 1, "name": "inverted", "background": [{"block": "brightness", "factor": 0.0}]}
STYLED = WriteOptions(alpha="style")


def disc() -> np.ndarray:
    """Alpha of a disc with a soft edge."""
    alpha = np.zeros(SIZE_PX[::-1], np.uint8)
    cv2.circle(alpha, (80, 60), 40, 255, -1)
    return cv2.GaussianBlur(alpha, (0, 0), 2)


def logo(alpha: np.ndarray | None = None) -> np.ndarray:
    color = cv2.resize(photograph("astronaut"), SIZE_PX)
    return np.dstack([color, disc() if alpha is None else alpha])


@pytest.fixture
def source(tmp_path: Path) -> Path:
    Image.fromarray(logo()).save(tmp_path / "logo.png")
    return tmp_path / "logo.png"


@pytest.mark.parametrize("name", style_names())
def test_every_style_keeps_alpha(name):
    assert np.array_equal(stylize(logo(), name, device="cpu")[..., 3], disc())


def alpha_of(source: Path, style: object, write: WriteOptions = STYLED) -> np.ndarray:
    target = source.with_name("out.png")
    render(source, target, style, write=write, device="cpu")  # type: ignore[arg-type]
    return np.asarray(Image.open(target))[..., 3]


def test_styled_alpha_differs_only_at_edges(source):
    alpha, before = alpha_of(source, DOTS), disc()
    kernel = np.ones((5, 5))
    assert np.all(alpha[cv2.erode(before, kernel) == 255] == 255)
    assert np.all(alpha[cv2.dilate(before, kernel) == 0] == 0)
    edge = (before > 30) & (before < 225)
    assert np.abs(alpha[edge].astype(int) - before[edge]).mean() > 30


@pytest.mark.parametrize("style", [LINES, INVERTED], ids=lambda style: style["name"])
def test_alpha_stays_where_a_style_says_nothing_about_edges(source, style):
    assert np.array_equal(alpha_of(source, style), disc())


def test_opaque_pictures_stay_opaque(tmp_path):
    Image.fromarray(logo(np.full(SIZE_PX[::-1], 255, np.uint8))).save(tmp_path / "logo.png")
    assert alpha_of(tmp_path / "logo.png", DOTS).min() == 255


def test_styled_alpha_wants_one_style(source, tmp_path):
    from vidstyle.cues.cue_list import CueList
    from vidstyle.style import load_style

    cues = CueList.of(load_style("ink"))
    with pytest.raises(UsageError, match="--alpha style needs one style"):
        render(source, tmp_path / "out.png", cues, write=STYLED, device="cpu")


@pytest.mark.parametrize("depth", [8, 10, 0])
@pytest.mark.parametrize("subsampling", [(1, 1), (2, 2)])
def test_a_matte_is_behind_clear_parts_and_leaves_opaque_ones(depth, subsampling):
    encoding = Encoding("bt601", False, depth, subsampling)
    alpha = np.zeros((16, 24), encoding.dtype)
    alpha[:, :12] = 2**depth - 1 if depth else 1
    color = cv2.resize(photograph("coffee"), (24, 16))
    picture = convert(Picture.from_array(color), encoding)
    picture = Picture(encoding, picture.luma, picture.chroma, alpha=alpha)
    shown = over_color(picture, (1.0, 0.0, 0.0))
    red = convert(Picture.from_array(np.full((16, 24, 3), (255, 0, 0), np.uint8)), encoding)
    assert shown.alpha is None
    for kind, first in (("luma", 12), ("chroma", 12 // subsampling[0])):
        now, before, behind = (np.asarray(getattr(each, kind)) for each in (shown, picture, red))
        assert np.abs(now[..., :first].astype(float) - before[..., :first]).max() < 1e-6
        assert now[..., first:] == pytest.approx(behind[..., first:], abs=1)


def test_a_gray_picture_gets_a_colored_matte():
    gray = Picture(
        Encoding(full_range=True), luma=np.full((4, 4), 9, np.uint8), alpha=np.zeros((4, 4), np.uint8)
    )
    shown = convert(
        over_color(gray, (0.0, 0.0, 1.0)), Encoding(full_range=True, subsampling=(1, 1)), rgb=True
    )
    assert np.abs(shown.color.astype(int) - (0, 0, 255)).max() <= 2


def test_a_film_without_alpha_gets_the_matte(source, tmp_path, caplog):
    read = ReadOptions(matte=(0.0, 1.0, 0.0))
    render(source, tmp_path / "out.mp4", "plain", read=read, write=WriteOptions(crf=4), device="cpu")
    with av.open(str(tmp_path / "out.mp4")) as container:
        corner = next(container.decode(video=0)).to_ndarray(format="rgb24")[2, 2]
    assert corner == pytest.approx([0, 255, 0], abs=12)
    assert "transparency is lost" not in caplog.text
