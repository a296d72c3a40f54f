"""Ten bits and alpha in every container, as the table of docs/hdr.md says."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.errors import UsageError
from vidstyle.media.color_tags import default_tags
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo, WriteOptions
from vidstyle.media.pixel_formats import format_name
from vidstyle.media.read.reader import open_reader
from vidstyle.media.write.writer import open_writer
from vidstyle.pipeline.render import render

DOCUMENT = (Path(__file__).parents[3] / "docs" / "hdr.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip().strip("`") for cell in line.strip("|").split("|")]
    for line in DOCUMENT.partition("| output |")[2].splitlines()[2:]
    if line.startswith("| `")
]
PLAIN = {"format": 1, "name": "plain"}
LOSSY = (".webm", ".mp4", ".webp", ".avi")
DEEP = Encoding("bt709", False, 10, (2, 1), SITINGS["topleft"])
RAMP = np.ascontiguousarray(np.tile(np.arange(1024, dtype=np.uint16).reshape(-1, 64), (8, 4)))


def ramp(path: Path, alpha: bool = False, encoding: Encoding = DEEP) -> Path:
    """Write a film of three frames with every code in luma, and in alpha the other way round."""
    neutral = np.full(encoding.chroma_shape(*RAMP.shape), 512, np.uint16)
    picture = Picture(encoding, RAMP, (neutral, neutral), alpha=RAMP[::-1].copy() if alpha else None)
    height, width = RAMP.shape
    tags, base = default_tags(encoding, height), Fraction(1, 25)
    info = VideoInfo(width, height, encoding, tags, base, 1 / base, frames=3, alpha=alpha)
    name = format_name(10, encoding.subsampling, rgb=False, chroma=True, alpha=alpha)
    with open_writer(path, info, WriteOptions(codec="ffv1", pix_fmt=name)) as writer:
        for number in range(3):
            writer.write(Frame(picture, number, base, 1))
    return path


def first_picture(path: Path) -> Picture:
    with open_reader(path) as reader:
        return next(item for item in reader if isinstance(item, Frame)).picture


def rendered(source: Path, output: str, arguments: str, **options: object) -> Picture:
    codec = arguments.rpartition(" ")[2] or None
    target = source.with_name("out").with_suffix(output) if output[0] == "." else source.with_name(output)
    frames = 1 if output == ".webp" else None
    write = WriteOptions(codec=codec, **options)  # type: ignore[arg-type]
    render(source, target, PLAIN, write=write, device="cpu", frames=frames)
    return first_picture(target)


@pytest.mark.parametrize(("output", "arguments", "bits", "codes", "alpha"), ROWS)
def test_the_table_of_the_guide_is_true(tmp_path, caplog, output, arguments, bits, codes, alpha):
    picture = rendered(ramp(tmp_path / "in.mkv"), output, arguments)
    seen = picture.luma if picture.color is None else picture.color[..., 1]
    assert picture.encoding.depth == int(bits)
    count = len(np.unique(seen))
    is_exact = output not in LOSSY
    assert count == int(codes) if is_exact else count >= int(codes)
    (tmp_path / "in.mkv").unlink()
    clear = rendered(
        ramp(tmp_path / "in.mkv", alpha=True), output.replace("out", "clear"), arguments, overwrite=True
    )
    if alpha == "none":
        assert clear.alpha is None and "transparency is lost" in caplog.text
        return
    assert clear.alpha is not None
    found = clear.alpha / float(2**clear.encoding.depth - 1) * 255
    error = np.abs(found - RAMP[::-1] / 1023 * 255).max()
    rounding = 0.51 if clear.encoding.depth == 8 else 0.05
    assert error <= int(alpha) + rounding


@pytest.mark.parametrize("depth", [10, 12])
def test_a_full_range_ramp_keeps_every_code_in_16_bit_stills(tmp_path, depth):
    codes = np.arange(2**depth, dtype=np.uint16).reshape(-1, 64)
    encoding = Encoding("bt709", True, depth, (1, 1), SITINGS["topleft"])
    neutral = np.full(codes.shape, 2 ** (depth - 1), np.uint16)
    height, width = codes.shape
    info = VideoInfo(width, height, encoding, default_tags(encoding), Fraction(1, 25), frames=1, still=True)
    with open_writer(tmp_path / "in.mkv", info, WriteOptions(codec="ffv1")) as writer:
        writer.write(Frame(Picture(encoding, codes, (neutral, neutral)), 0, Fraction(1, 25), 1))
    for still in ("a.png", "a.tif"):
        render(tmp_path / "in.mkv", tmp_path / still, PLAIN, device="cpu", frames=1)
        seen = first_picture(tmp_path / still).color
        assert seen.dtype == np.uint16 and len(np.unique(seen[..., 1])) == 2**depth


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"codec": "libx265", "pix_fmt": "yuva420p"}, "libx265 refuses"),
        ({"codec": "libvpx-vp9", "pix_fmt": "yuv420p10le"}, "libvpx-vp9 refuses"),
        ({"codec": "utvideo"}, "matroska files do not support utvideo"),
    ],
)
def test_formats_that_an_encoder_only_lists_are_refused(tmp_path, options, reason):
    with pytest.raises(UsageError, match=reason):
        render(
            ramp(tmp_path / "in.mkv"),
            tmp_path / "out.mkv",
            PLAIN,
            write=WriteOptions(**options),
            device="cpu",
        )
