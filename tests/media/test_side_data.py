"""Pictures and films with profiles, EXIF and other side data: upright, in the right light, and no crash.

PyAV crashes when it frees side data that was read, so a separate process reads all of it.
"""

from __future__ import annotations

import io
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np
import pytest
from covering import in_one_test
from media import make_clip
from PIL import Image, ImageCms

from vidstyle.core.convert import to_rgb
from vidstyle.media.exif import exif_orientation
from vidstyle.media.frame import Frame
from vidstyle.media.orientation import Orientation
from vidstyle.media.read.reader import open_reader

READ_AND_COLLECT = """
import gc, sys
from vidstyle.media.read.reader import open_reader
gc.freeze()  # makes each collection fast
for path in sys.argv[2:]:
    for _ in range(int(sys.argv[1])):
        with open_reader(path) as reader:
            for item in reader:
                del item
                gc.collect()
        del reader
        gc.collect()
"""
SIZE = (48, 32)
STILLS = ("png", "jpg", "webp", "tif")
PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def read_and_collect(paths: list[Path], times: int) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", READ_AND_COLLECT, str(times), *map(str, paths)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def picture() -> Image.Image:
    """Each quarter has a different colour."""
    rgb = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    rgb[: SIZE[1] // 2, : SIZE[0] // 2] = (255, 0, 0)
    rgb[: SIZE[1] // 2, SIZE[0] // 2 :] = (0, 255, 0)
    rgb[SIZE[1] // 2 :, : SIZE[0] // 2] = (0, 0, 255)
    return Image.fromarray(rgb)


def exif(orientation: int, filler: int = 0) -> bytes:
    tags = Image.Exif()
    tags[0x0112] = orientation
    if filler:
        tags[0x010E] = "x" * filler
    return tags.tobytes()


def upright(path: Path | str) -> np.ndarray:
    """The first frame, H x W x 3 floats 0..1."""
    with open_reader(path) as reader:
        frame = next(item for item in reader if isinstance(item, Frame))
        return to_rgb(frame.picture).astype(float) / 255


def turned(orientation: int) -> np.ndarray:
    return Orientation.from_exif(orientation).plane(np.asarray(picture())) / 255.0


@in_one_test("ending", STILLS)
@in_one_test("orientation", list(range(1, 9)))
@in_one_test("profile", [b"", PROFILE])
def test_photographs_are_turned_as_their_exif_says(tmp_path, ending, orientation, profile):
    path = tmp_path / f"{orientation}.{ending}"
    picture().save(path, exif=exif(orientation), icc_profile=profile or None, quality=95)
    shown, wanted = upright(path), turned(orientation)
    assert shown.shape == wanted.shape and np.abs(shown - wanted).mean() < 0.06
    path.rename(tmp_path / f"00001.{ending}")
    assert np.abs(upright(str(tmp_path / f"%05d.{ending}")) - wanted).mean() < 0.06
    (tmp_path / f"00001.{ending}").unlink()


@pytest.mark.parametrize("orientation", range(1, 9))
def test_avif_is_turned_as_its_boxes_say(tmp_path, orientation):
    path = tmp_path / "a.avif"
    try:
        picture().save(path, exif=exif(orientation), quality=95)
    except (KeyError, OSError):
        pytest.skip("this Pillow writes no AVIF")
    wanted = turned(orientation)
    assert upright(path).shape == wanted.shape and np.abs(upright(path) - wanted).mean() < 0.08


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("ending", ["mp4", "mov"])
def test_films_are_turned_and_mirrored_as_their_matrix_says(tmp_path, ending, orientation):
    path = make_clip(tmp_path / f"a.{ending}", size=(64, 48), frames=2)
    plain = upright(path)
    wanted = Orientation.from_exif(orientation)
    across, down = (-65536 if mirrored else 65536 for mirrored in (wanted.mirror_x, wanted.mirror_y))
    a, b, c, d = (0, down, across, 0) if wanted.transpose else (across, 0, 0, down)
    content = bytearray(path.read_bytes())
    struct.pack_into(">9i", content, content.index(b"tkhd") + 44, a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(content)
    assert np.abs(upright(path) - wanted.plane(plain)).mean() < 0.01


def test_pictures_with_profiles_and_tags_are_read_hundreds_of_times(tmp_path):
    paths = []
    contents = {
        "icc": {"icc_profile": PROFILE},
        "exif": {"exif": exif(6)},
        "both": {"icc_profile": PROFILE, "exif": exif(3)},
        "large": {"icc_profile": PROFILE, "exif": exif(8, filler=60_000)},
        "zero": {"exif": exif(0)},
        "odd": {"exif": b"Exif\0\0II*\0\xff\xff\xff\xff" + bytes(range(200))},
    }
    for name, options in contents.items():
        for ending in STILLS:
            if ending != "tif" or name != "odd":
                paths.append(tmp_path / f"{name}.{ending}")
                picture().save(paths[-1], **options)
    paths.append(tmp_path / "gain.jpg")  # a second picture follows, as in photographs with a gain map
    first, second = io.BytesIO(), io.BytesIO()
    picture().save(first, "jpeg", icc_profile=PROFILE)
    picture().save(second, "jpeg", exif=exif(6))
    paths[-1].write_bytes(first.getvalue() + second.getvalue())
    assert upright(paths[-1]).shape == (SIZE[1], SIZE[0], 3), "the tags of the second do not turn the first"
    outcome = read_and_collect(paths, 20)
    assert outcome.returncode == 0, outcome.stderr


def supplemental(kind: int, payload: bytes, hevc: bool) -> bytes:
    """A unit of supplemental enhancement information (ITU-T H.264, 7.3.2.3), with emulation bytes."""
    data = (b"\x4e\x01" if hevc else b"\x06") + bytes([kind, len(payload)]) + payload + b"\x80"
    kept = bytearray()
    for byte in data:
        if kept[-2:] == b"\0\0" and byte <= 3:
            kept.append(3)
        kept.append(byte)
    return b"\0\0\0\1" + bytes(kept)


def messages() -> Iterator[tuple[int, bytes]]:
    """One of each kind that decoders turn into side data, by its number in the standards."""
    yield 4, b"\xb5\0\x31GA94\x03\xc1\xff\xfc\x94\x2c\xff"  # closed captions (A/53)
    yield 4, b"\xb5\0\x31DTG1\x41\xf8"  # active format (A/53)
    yield 4, b"\xb5\0\x3c\0\x01\x04\x01\x40\0\x0c\x80" + bytes(40)  # HDR10+ (ST 2094-40)
    yield 5, bytes(range(16)) + b"anything"  # from a program
    yield 45, b"\x80\x83\0\0\0\x03\0\0"  # stereo
    yield 47, b"\x04\0\0\x10"  # orientation
    yield 136, b"\x61\x20\x80\0"  # time code
    yield 137, struct.pack(">8H2I", *[10_000] * 8, 6_000_000, 50)  # mastering display
    yield 144, struct.pack(">2H", 640, 120)  # light levels
    yield 147, b"\x10\0"  # preferred transfer
    yield 148, struct.pack(">I2H", 314_000, 15_635, 16_450)  # surroundings


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_films_with_side_data_in_every_frame(tmp_path, codec):
    hevc = codec == "libx265"
    raw = make_clip(tmp_path / ("a.hevc" if hevc else "a.h264"), size=(64, 48), frames=200, codec=codec)
    units = b"".join(supplemental(*message, hevc=hevc) for message in messages())
    with av.open(str(raw)) as given:
        packets = [bytes(packet) for packet in given.demux(video=0) if packet.size]
    raw.write_bytes(b"".join(units + each for each in packets))
    assert len(packets) == 200
    outcome = read_and_collect([raw], 2)
    assert outcome.returncode == 0, outcome.stderr


def test_only_the_tags_of_the_picture_itself_count():
    tiff = b"II*\0" + struct.pack("<IHHHIHH", 8, 1, 0x0112, 3, 1, 6, 0)
    wanted = Orientation.from_exif(6)
    assert exif_orientation(tiff) == wanted
    chunk = struct.pack(">I4s", len(tiff), b"eXIf") + tiff + bytes(4)
    assert exif_orientation(b"\x89PNG\r\n\x1a\n" + chunk) == wanted
    assert (
        exif_orientation(b"RIFF\0\0\0\0WEBPEXIF" + struct.pack("<I", len(tiff) + 6) + b"Exif\0\0" + tiff)
        == wanted
    )
    for broken in (
        b"",
        tiff[:12],
        b"II*\0\xff\xff\xff\xff",
        b"\xff\xd8\xff\xe1\0",
        b"\x89PNG\r\n\x1a\n\xff\xff\xff\xffeXIf",
    ):
        assert exif_orientation(broken) is None
