"""Round trips between frames and pictures without a changed sample, and interpretation of colour tags."""

from __future__ import annotations

import gc
import tracemalloc

import av
import media
import numpy as np
import pytest
from covering import in_one_test

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import InputError
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.frame import frame_from_picture, picture_from_frame, to_supported_format
from vidstyle.media.pixel_formats import REORDERED_FORMATS, layout_of

ODD = (101, 37)
PLAIN = [
    "yuv420p", "yuvj420p", "yuv422p", "yuv444p", "yuv440p", "yuv411p", "yuv410p", "yuva420p", "yuva444p10le",
    "yuv420p10le", "yuv422p12le", "yuv444p16le", "yuv420p9le", "gray", "gray10le", "gray16le", "ya8",
    "ya16le",
    "rgb24", "rgba", "rgb48le", "rgba64le", "gbrp10le", "gbrap12le",
]  # fmt: skip
FOREIGN_ORDER = ["yuv420p10be", "yuv444p12be", "gray16be", "gbrp14be", "ya16be"]


def noisy_frame(name: str, size: tuple[int, int] = ODD) -> av.VideoFrame:
    """A frame of random samples that are valid in its format."""
    frame = av.VideoFrame(*size, name)
    random = np.random.default_rng(len(name))
    bits = frame.format.components[0].bits
    for plane in frame.planes:
        content = np.frombuffer(plane, np.uint8)
        if bits > 8:
            order = ">u2" if name.endswith("be") else "<u2"
            high = 16 - bits if name.startswith("p") else 0
            content.view(order)[:] = random.integers(0, 2**bits, content.size // 2) << high
        else:
            content[:] = random.integers(0, 256, content.size)
    return frame


@in_one_test("name", PLAIN)
def test_planes_survive_the_round_trip(name):
    frame = noisy_frame(name)
    picture = picture_from_frame(frame)
    assert picture.shape == ODD[::-1]
    again = frame_from_picture(picture, tags=ColorTags.of(frame))
    assert again.format.name == name.replace("yuvj", "yuv")
    for plane, copied in zip(frame.planes, again.planes, strict=True):
        assert (visible(plane, name) == visible(copied, name)).all()


@pytest.mark.parametrize("name", FOREIGN_ORDER)
def test_the_other_byte_order(name):
    frame = noisy_frame(name)
    again = frame_from_picture(picture_from_frame(frame))
    for plane, copied in zip(frame.planes, again.planes, strict=True):
        swapped = visible(plane, name).reshape(-1, 2)[:, ::-1].reshape(-1)
        assert (swapped == visible(copied, name).reshape(-1)).all()


@in_one_test("name", ["nv12", "nv21", "nv16", "nv24", "p010le", "p210le", "yuyv422", "uyvy422"])
@in_one_test("color_range", [0, 1, 2])
def test_shuffled_formats_lose_nothing_in_either_range(name, color_range):
    frame = noisy_frame(name, (64, 32))
    frame.color_range = color_range
    planar = to_supported_format(frame)
    assert planar.format.name == REORDERED_FORMATS[name] and planar.color_range == color_range
    picture = picture_from_frame(planar)
    luma, first_chroma = reference_samples(frame)
    assert (picture.luma == luma).all()
    assert picture.chroma[0].flat[0] == first_chroma


@pytest.mark.parametrize("name", ["bgr24", "bgra", "argb", "rgb0", "gbrp"])
def test_rgb_in_any_order(name):
    rgb = next(media.moving_frames(1, ODD))
    source = av.VideoFrame(*ODD, "rgba")
    media.fill_frame(source, [np.dstack([rgb, media.alpha_ramp(*ODD[::-1])])])
    picture = picture_from_frame(source.reformat(format=name))
    assert (picture.color == rgb).all()
    assert (picture.alpha is not None) == ("a" in name)


def test_palettes():
    frame = noisy_frame("pal8")
    palette = np.frombuffer(frame.planes[1], np.uint8).reshape(256, 4)
    expected = palette[visible(frame.planes[0], "pal8")]
    picture = picture_from_frame(frame)
    assert (picture.color == expected[..., 2::-1]).all() and (picture.alpha == expected[..., 3]).all()


@pytest.mark.parametrize(("name", "order", "mirrored"), [("bgr48le", "<u2", True), ("rgb48be", ">u2", False)])
def test_rgb_of_sixteen_bits_in_any_order(name, order, mirrored):
    frame = noisy_frame(name)
    rows = np.frombuffer(frame.planes[0], np.uint8).reshape(-1, frame.planes[0].line_size)[:, : 101 * 6]
    expected = np.ascontiguousarray(rows).view(order).reshape(37, 101, 3)
    assert (picture_from_frame(frame).color == (expected[..., ::-1] if mirrored else expected)).all()


def test_views_are_not_copies_and_keep_the_frame_alive():
    frame = media.frame_from_rgb(next(media.moving_frames(1)))
    picture = picture_from_frame(frame)
    before = picture.luma.copy()
    assert np.shares_memory(picture.luma, np.frombuffer(frame.planes[0], np.uint8))
    del frame
    gc.collect()
    for number in range(20):
        media.frame_from_rgb(np.full((180, 320, 3), number, np.uint8))
    assert (picture.luma == before).all()


def test_a_picture_costs_next_to_nothing():
    """No plane is copied: NumPy tells tracemalloc of what it allocates."""
    frame = av.VideoFrame(1920, 1080, "yuv420p")
    picture_from_frame(frame)
    tracemalloc.start()
    try:
        picture = picture_from_frame(frame)
        assert picture.shape == (1080, 1920) and tracemalloc.get_traced_memory()[1] < 50_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("size", "tagged", "codec", "matrix"),
    [
        ((1280, 536), 2, "h264", "bt709"),
        ((960, 720), 2, "h264", "bt709"),
        ((1024, 576), 2, "h264", "bt601"),
        ((1280, 720), 6, "h264", "bt601"),
        ((320, 180), 1, "h264", "bt709"),
        ((320, 180), 9, "hevc", "bt2020"),
        ((1920, 1080), 2, "mjpeg", "bt601"),
    ],
)
def test_the_matrix_is_as_tagged_or_else_by_size(size, tagged, codec, matrix):
    frame = av.VideoFrame(*size, "yuv420p")
    frame.colorspace = tagged
    assert picture_from_frame(frame, codec).encoding.matrix == matrix


@pytest.mark.parametrize(
    ("codec", "tags", "siting"),
    [
        ("h264", ColorTags(1, 1, 1, 1), (0.0, 0.5)),
        ("mjpeg", ColorTags(2, 2, 5, 2), (0.5, 0.5)),
        ("hevc", ColorTags(9, 16, 9, 1), (0.0, 0.0)),
        ("hevc", ColorTags(9, 14, 9, 1), (0.0, 0.5)),
    ],
)
def test_chroma_siting(codec, tags, siting):
    frame = av.VideoFrame(64, 64, "yuv420p")
    assert picture_from_frame(frame, codec, tags).encoding.siting == siting


def test_full_range_by_tag_or_by_format():
    frame = av.VideoFrame(64, 64, "yuv420p")
    assert not picture_from_frame(frame).encoding.full_range
    frame.color_range = 2
    assert picture_from_frame(frame).encoding.full_range
    assert picture_from_frame(av.VideoFrame(64, 64, "yuvj420p")).encoding.full_range


@pytest.mark.parametrize(("code", "name"), [(8, "YCgCo"), (14, "ICtCp")])
def test_a_matrix_that_we_cannot_do_is_named(code, name):
    with pytest.raises(InputError, match=name):
        picture_from_frame(av.VideoFrame(64, 64, "yuv444p"), tags=ColorTags(matrix=code))


@pytest.mark.parametrize("name", ["xyz12le", "bayer_rggb8", "gbrpf32le"])
def test_a_pixel_format_that_we_do_not_read_is_named(name):
    with pytest.raises(InputError, match=name):
        picture_from_frame(av.VideoFrame(64, 64, name))


def test_every_format_is_read_or_refused():
    read = 0
    for name in av.video.format.names:
        layout = layout_of(name)
        read += layout is not None
        assert layout is None or 8 <= layout.depth <= 16
    assert read > 100


def test_padding_repeats_the_edge():
    luma = np.arange(35, dtype=np.uint8).reshape(5, 7)
    chroma = np.arange(12, dtype=np.uint8).reshape(3, 4)
    frame = frame_from_picture(Picture(Encoding(), luma=luma, chroma=(chroma, chroma + 100)), (6, 8))
    padded = picture_from_frame(frame)
    assert (padded.luma == np.pad(luma, ((0, 1), (0, 1)), "edge")).all()
    assert (padded.chroma[1] == chroma + 100).all()


def test_frames_are_tagged_as_their_pictures_are_encoded():
    picture = picture_from_frame(av.VideoFrame(64, 64, "yuv420p"))
    frame = frame_from_picture(picture)
    assert (frame.color_primaries, frame.color_trc, frame.colorspace, frame.color_range) == (6, 6, 6, 1)


def visible(plane: av.video.plane.VideoPlane, name: str) -> np.ndarray:
    """The bytes of a plane without its padding."""
    layout = layout_of(name)
    rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)[: plane.height]
    packed = layout.kind == "packed" or (layout.planes == 1 and layout.alpha)
    channels = (layout.planes + layout.alpha) if packed and name != "pal8" else 1
    return rows[:, : plane.width * channels * (2 if layout.depth > 8 else 1)]


def reference_samples(frame: av.VideoFrame) -> tuple[np.ndarray, int]:
    """Luma and the first blue-difference sample of a semi-planar or packed 4:2:2 frame, by plain indexing."""
    name = frame.format.name
    dtype, shift = (np.uint16, 6) if name.startswith("p") else (np.uint8, 0)
    planes = [np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size) for plane in frame.planes]
    rows = [np.ascontiguousarray(plane).view(dtype) >> shift for plane in planes]
    if name in ("yuyv422", "uyvy422"):
        first = 0 if name == "yuyv422" else 1
        return rows[0][:, first : 2 * frame.width : 2], int(rows[0][0, 1 - first])
    return rows[0][:, : frame.width], int(rows[1][0, 1 if name == "nv21" else 0])
