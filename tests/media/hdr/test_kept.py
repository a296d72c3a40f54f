"""`--hdr keep`: PQ and HLG with their metadata in every container that stores them, refusals in others."""

from __future__ import annotations

import logging
from pathlib import Path

import av
import media
import numpy as np
import pytest

from vidstyle.errors import UsageError
from vidstyle.media.color_tags import HLG_CODE, PQ_CODE, ColorTags
from vidstyle.media.frame import Frame
from vidstyle.media.hdr_encoding import CHECKED_METADATA, hdr_options
from vidstyle.media.hdr_metadata import HdrMetadata, MasteringDisplay, dynamic_metadata, first_metadata
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.read.reader import open_reader
from vidstyle.media.write.containers import CONTAINER_KINDS
from vidstyle.pipeline.render import render

KEEP = ReadOptions(hdr="keep")
SWAPPED = MasteringDisplay((0.265, 0.69), (0.68, 0.32), (0.15, 0.06), (0.3127, 0.329), 1000, 0.005)
DIM = MasteringDisplay((0.68, 0.32), (0.265, 0.69), (0.15, 0.06), (0.3127, 0.329), 0.1, 0.005)
PLAIN = {"format": 1, "name": "plain"}
PAPER = {"format": 1, "name": "lines", "lines": [{"block": "brightness", "factor": 2.5}]}
SOFT = {"format": 1, "name": "soft", "background": [{"block": "gaussian", "sigma": 0.4}]}


def clip(path: Path, transfer: str = "pq", metadata: HdrMetadata = CHECKED_METADATA, frames: int = 3) -> Path:
    parameters = hdr_options("libx265", metadata).get("x265-params", "")
    options = {"x265-params": f"log-level=none:{parameters}".rstrip(":")}
    return media.make_clip(
        path,
        frames=frames,
        codec="libx265",
        pix_fmt="yuv420p10le",
        matrix="bt2020",
        transfer=transfer,
        options=options,
    )


def restyled(source: Path, target: Path, style: object = PLAIN, **options: object) -> Path:
    render(source, target, style, read=KEEP, write=WriteOptions(**options), device="cpu")  # type: ignore[arg-type]
    return target


HDR_FILES = [(kind.endings[0], codec) for kind in CONTAINER_KINDS for codec in kind.hdr]


@pytest.mark.parametrize("transfer", ["pq", "hlg"])
@pytest.mark.parametrize(("ending", "codec"), HDR_FILES)
def test_tags_and_metadata_come_back_from_every_container(tmp_path, ending, codec, transfer):
    metadata = CHECKED_METADATA if transfer == "pq" else HdrMetadata()
    source = clip(tmp_path / "in.mp4", transfer, metadata)
    target = restyled(source, tmp_path / f"out{ending}", SOFT, codec=codec)
    with av.open(str(target)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.codec.canonical_name == codec
        assert (stream.codec_context.codec_tag == "hvc1") == (codec == "hevc" and ending in (".mp4", ".mov"))
        frame = next(container.decode(stream))
        assert frame.format.name == "yuv420p10le"
        assert ColorTags.of(frame) == ColorTags(9, PQ_CODE if transfer == "pq" else HLG_CODE, 9, 1)
    found, _ = first_metadata(str(target), 0)
    assert found.content_light == metadata.content_light
    assert (found.mastering is None) == (metadata.mastering is None)
    assert found.mastering is None or found.mastering.is_close(metadata.mastering)


def test_a_plain_film_has_the_same_frames(tmp_path):
    source = clip(tmp_path / "in.mp4")
    target = restyled(source, tmp_path / "out.mkv", crf=0)
    for before, after in zip(media.read_all(source), media.read_all(target), strict=True):
        difference = before.to_ndarray().astype(int) - after.to_ndarray()
        assert np.abs(difference).mean() < 0.7


@pytest.mark.parametrize(("transfer", "white"), [("pq", 573), ("hlg", 721)])
def test_paper_has_diffuse_white_and_black_is_black(tmp_path, transfer, white):
    source = clip(tmp_path / "in.mp4", transfer, HdrMetadata())
    luma = decoded_luma(restyled(source, tmp_path / "out.mkv", PAPER, crf=0))
    assert luma.max() == pytest.approx(white, abs=5)
    ink = {**PAPER, "lines": [{"block": "brightness", "factor": 0.0}]}
    black = decoded_luma(restyled(source, tmp_path / "ink.mkv", ink, crf=0))
    assert black.min() == pytest.approx(64, abs=1) and black.max() == pytest.approx(64, abs=1)


def test_highlights_keep_their_place_where_a_style_keeps_tones(tmp_path):
    source = clip(tmp_path / "in.mp4", "pq")
    before, after = decoded_luma(source), decoded_luma(restyled(source, tmp_path / "out.mkv", SOFT, crf=0))
    assert before.max() > 650, "well above diffuse white, 573"
    bright = before > np.percentile(before, 99)
    assert abs(before[bright].mean() - after[bright].mean()) < 12


def decoded_luma(path: Path) -> np.ndarray:
    with open_reader(path, KEEP) as reader:
        return next(item for item in reader if isinstance(item, Frame)).picture.luma.astype(int)


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("out.avi", {}, "--hdr keep: .avi files do not store HDR"),
        ("out.png", {}, "--hdr keep: .png files do not store HDR"),
        ("out.mp4", {"codec": "libx264"}, "--hdr keep: libx264 does not store HDR in .mp4 files"),
        ("out.mov", {"codec": "prores_ks"}, "--hdr keep: prores_ks does not store HDR in .mov files"),
        ("out.mp4", {"pix_fmt": "yuv420p"}, "--pix-fmt: yuv420p cannot be used for HDR"),
    ],
)
def test_what_cannot_store_hdr_refuses_in_one_line(tmp_path, name, options, reason):
    source = clip(tmp_path / "in.mp4")
    with pytest.raises(UsageError, match=f"^{reason}.*--hdr map$"):
        restyled(source, tmp_path / name, **options)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("metadata", "notice"),
    [
        (HdrMetadata(SWAPPED, (1000, 200)), "the mastering display metadata is dropped: its primaries"),
        (HdrMetadata(DIM, (1000, 200)), "the mastering display metadata is dropped: its peak is 0.1 cd/m2"),
        (HdrMetadata(None, (10, 5)), "the content light levels are dropped: the maximum is 10 cd/m2"),
        (HdrMetadata(None, (100, 400)), "the content light levels are dropped: a mean of 400 exceeds 100"),
    ],
)
def test_implausible_metadata_is_dropped_with_a_notice(tmp_path, caplog, metadata, notice):
    source = clip(tmp_path / "in.mp4", metadata=metadata)
    with open_reader(source, KEEP) as reader:
        assert reader.info.hdr.mastering is None
        assert (reader.info.hdr.content_light is None) == (metadata.mastering is None)
    assert notice in caplog.text


DOLBY_VISION_UNIT = bytes.fromhex("7c01") + bytes(range(25, 60))
HDR10_PLUS_MESSAGE = bytes.fromhex("b5003c00010401") + bytes(range(1, 21))
HDR10_PLUS_UNIT = bytes.fromhex("4e0104") + bytes([len(HDR10_PLUS_MESSAGE)]) + HDR10_PLUS_MESSAGE + b"\x80"


def with_units(source: Path, target: Path, unit: bytes) -> Path:
    """Copy a film with another NAL unit in each packet."""
    with av.open(str(source)) as old, av.open(str(target), "w") as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(video=0):
            if packet.size:
                content = len(unit).to_bytes(4) + unit
                content = content + bytes(packet) if unit[0] != 0x7C else bytes(packet) + content
                copy = av.Packet(content)
                copy.pts, copy.dts, copy.time_base = packet.pts, packet.dts, packet.time_base
                copy.is_keyframe, copy.stream = packet.is_keyframe, stream
                new.mux(copy)
    return target


@pytest.mark.parametrize("ending", [".mp4", ".mkv", ".ts"])
@pytest.mark.parametrize(("unit", "name"), [(DOLBY_VISION_UNIT, "Dolby Vision"), (HDR10_PLUS_UNIT, "HDR10+")])
def test_dynamic_metadata_is_dropped_and_named(tmp_path, caplog, unit, name, ending):
    source = with_units(clip(tmp_path / "in.mp4", "hlg", HdrMetadata()), tmp_path / "dynamic.mp4", unit)
    if ending != ".mp4":
        source = copied(source, tmp_path / f"dynamic{ending}")
    target = restyled(source, tmp_path / "out.mp4")
    assert f"metadata of {name} is dropped" in caplog.text
    caplog.clear()
    with open_reader(target, KEEP):
        assert "dropped" not in caplog.text


def copied(source: Path, target: Path) -> Path:
    with av.open(str(source)) as old, av.open(str(target), "w") as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                new.mux(packet)
    return target


def test_damaged_packets_have_no_dynamic_metadata():
    assert dynamic_metadata(b"", "hevc") == dynamic_metadata(b"\0\0\0\1", "hevc") == []
    assert dynamic_metadata(b"\xff" * 9, "hevc") == dynamic_metadata(b"\xff" * 9, "av1") == []


def test_sdr_stays_sdr_and_says_so(tmp_path, caplog):
    caplog.set_level(logging.INFO)
    source = media.make_clip(tmp_path / "in.mp4", frames=2)
    restyled(source, tmp_path / "out.mp4")
    assert "is SDR: --hdr keep changes nothing" in caplog.text


def test_compared_halves_are_divided_by_diffuse_white(tmp_path):
    source = clip(tmp_path / "in.mp4")
    write = WriteOptions(crf=0)
    render(source, tmp_path / "out.mkv", SOFT, read=KEEP, write=write, device="cpu", compare="split")
    assert np.median(decoded_luma(tmp_path / "out.mkv")[:, 80]) == pytest.approx(573, abs=3)
