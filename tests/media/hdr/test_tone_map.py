"""Tone mapping: curves against closed forms, kernels against the curves."""

from __future__ import annotations

import cv2
import media
import numpy as np
import pytest

from vidstyle.core.color.hdr_curves import BT2020_TO_BT709_MATRIX, hlg_to_scene, nits_to_pq, pq_to_nits
from vidstyle.core.picture import Encoding, Picture
from vidstyle.media.color_tags import HLG_CODE, PQ_CODE, ColorTags
from vidstyle.media.frame import Frame, picture_from_frame
from vidstyle.media.hdr import (
    ToneMap,
    compress_nits,
    read_peak_nits,
)
from vidstyle.media.read.reader import open_reader


@pytest.mark.parametrize(
    ("nits", "signal"), [(0, 0.0), (100, 0.5080784), (203, 0.5806889), (1000, 0.7518271), (10000, 1.0)]
)
def test_pq_has_the_values_of_the_standard(nits, signal):
    assert nits_to_pq(np.array(nits)) == pytest.approx(signal, abs=1e-6)
    assert pq_to_nits(np.array(signal)) == pytest.approx(nits, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize(("signal", "scene"), [(0, 0), (0.5, 1 / 12), (0.75, 0.2649626), (1.0, 1.0)])
def test_hlg_has_the_values_of_the_standard(signal, scene):
    assert hlg_to_scene(np.array(signal)) == pytest.approx(scene, abs=1e-6)


def test_the_knee_keeps_the_dark_grows_and_ends_at_white():
    nits = np.linspace(0, 1000, 4001)
    bent = compress_nits(nits, 1000)
    top, target = nits_to_pq(np.array(1000.0)), nits_to_pq(np.array(203.0))
    start = float(pq_to_nits((1.5 * target / top - 0.5) * top))
    assert bent[nits < start] == pytest.approx(nits[nits < start], rel=1e-9)
    assert (np.diff(bent) > 0).all() and bent[-1] == pytest.approx(203)
    slopes = np.diff(bent) / np.diff(nits)
    assert np.abs(np.diff(slopes)).max() < 0.01, "no edge at the knee"


def reference(rgb: np.ndarray, transfer: int) -> np.ndarray:
    """The whole way for RGB signals in float64, straight from the standards."""
    if transfer == PQ_CODE:
        nits = pq_to_nits(rgb)
    else:
        scene = hlg_to_scene(rgb)
        nits = 1000 * scene * (scene @ np.array([0.2627, 0.6780, 0.0593]))[..., None] ** 0.2
    most = nits.max(-1, keepdims=True)
    light = nits * compress_nits(most, 1000) / np.maximum(most, 1e-12) / 203
    return np.clip(light @ BT2020_TO_BT709_MATRIX.T.astype(np.float64), 0, 1) ** (1 / 2.4)


@pytest.mark.parametrize("transfer", [PQ_CODE, HLG_CODE])
def test_rgb_is_mapped_as_the_closed_form_says(transfer):
    steps = np.linspace(0.02, 0.75, 12)
    rgb = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(36, 48, 3)
    codes = np.round(rgb * 65535).astype(np.uint16)
    picture = Picture(Encoding("bt709", True, 16, (1, 1)), color=codes)
    mapped = ToneMap(transfer).apply(picture).color / 65535
    assert np.abs(mapped - reference(codes / 65535, transfer)).max() < 0.002


@pytest.mark.parametrize(("transfer", "code"), [("pq", PQ_CODE), ("hlg", HLG_CODE)])
@pytest.mark.parametrize("pix_fmt", ["yuv420p10le", "yuv422p10le", "yuv444p10le"])
def test_planes_are_mapped_as_their_rgb_is(transfer, code, pix_fmt):
    rgb = next(media.moving_frames(1, (322, 182)))
    frame = media.frame_from_rgb(rgb, pix_fmt, "bt2020", transfer=transfer)
    tags = ColorTags(9, code, 9, 1)
    tags.put_on(frame)
    source = picture_from_frame(frame, "hevc")
    mapped = ToneMap.of(frame, tags).apply(source)
    assert (mapped.encoding.matrix, mapped.encoding.full_range) == ("bt709", False)
    expected = reference(_rgb(source) / 255, code) @ mapped.encoding.from_rgb.T.astype(np.float64)
    across, down = mapped.encoding.subsampling
    assert np.abs(mapped.luma - 64 - 876 * expected[..., 0]).max() < 3
    for plane, difference in zip(mapped.chroma, (expected[..., 1], expected[..., 2]), strict=True):
        wanted = 512 + 896 * media.subsample(difference, (across, down))
        assert media.rms_error(plane, wanted) < 1


def test_gray_and_odd_sizes():
    luma = np.full((3, 5), 64 + 876 // 2, np.uint16)
    chroma = np.full((2, 3), 512, np.uint16)
    tone_map = ToneMap(PQ_CODE)
    gray = tone_map.apply(Picture(Encoding("bt2020", False, 10, (1, 1)), luma=luma))
    film = tone_map.apply(Picture(Encoding("bt2020", False, 10), luma=luma, chroma=(chroma, chroma)))
    expected = 64 + 876 * float(reference(np.full((1, 3), 0.5), PQ_CODE)[0, 1])
    assert gray.chroma is None and np.abs(gray.luma - expected).max() <= 2
    assert np.abs(film.luma - expected).max() <= 2 and np.abs(film.chroma[0] - 512.0).max() <= 2


def test_an_hdr_film_comes_out_as_sdr_and_says_so(tmp_path, caplog):
    path = media.make_clip(
        tmp_path / "hdr.mp4", frames=3, codec="libx265", pix_fmt="yuv420p10le", matrix="bt2020", transfer="pq"
    )
    with open_reader(path) as reader:
        frames = [item for item in reader if isinstance(item, Frame)]
        assert reader.info.color_tags == ColorTags(1, 1, 1, 1)
    assert caplog.text.count("HDR") == 1
    photograph = next(media.moving_frames(1, (160, 90)))
    assert media.rms_error(_rgb(frames[0].picture), photograph) < 15, "not grey, not neon"


def test_ten_bits_alone_are_not_hdr(tmp_path, caplog):
    path = media.make_clip(tmp_path / "ten.mkv", frames=3, codec="libx265", pix_fmt="yuv420p10le")
    with open_reader(path) as reader:
        assert reader.info.encoding.depth == 10 and reader.info.color_tags.transfer == 1
    assert "HDR" not in caplog.text


def test_the_peak_comes_from_the_stream(tmp_path):
    path = media.make_clip(
        tmp_path / "hdr.mp4",
        frames=3,
        codec="libx265",
        pix_fmt="yuv420p10le",
        matrix="bt2020",
        transfer="pq",
        options={"x265-params": "log-level=error:max-cll=640,120:hdr10=1"},
    )
    assert read_peak_nits(media.read_all(path)[0]) == 640
    assert read_peak_nits(media.frame_from_rgb(media.photograph())) == 1000


def _rgb(picture: Picture) -> np.ndarray:
    """The picture in RGB 0..255, chroma raised by OpenCV."""
    black, white = picture.encoding.luma_levels
    neutral, span = picture.encoding.chroma_levels
    luma = (picture.luma - black) / (white - black)
    height, width = picture.shape
    x, y = picture.encoding.siting
    across, down = picture.encoding.subsampling
    places = np.meshgrid(
        (np.arange(width, dtype=np.float32) - x) / across, (np.arange(height, dtype=np.float32) - y) / down
    )
    raised = [
        cv2.remap((plane - neutral) / span, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for plane in picture.chroma
    ]
    return 255 * np.clip(np.dstack([luma, *raised]) @ picture.encoding.to_rgb.T.astype(np.float64), 0, 1)
