"""Make the films and pictures for tests: a photograph that is panned and rotated over time.

Conversions do not use the package, so a bug cannot hide in its own tests.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cache, lru_cache, wraps
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import skimage.data

from vidstyle.media.codecs import open_encoder

MATRICES = {"bt601": (0.299, 0.114), "bt709": (0.2126, 0.0722), "bt2020": (0.2627, 0.0593)}
"""Luma weights of red and blue."""
TAGS = {
    "bt709": {"color_primaries": 1, "color_trc": 1, "colorspace": 1},
    "bt601": {"color_primaries": 6, "color_trc": 6, "colorspace": 6},
    "bt2020": {"color_primaries": 9, "color_trc": 14, "colorspace": 9},
}
"""ITU-T H.273 codes of primaries, transfer and matrix."""
TRANSFERS = {"pq": 16, "hlg": 18}
RGB_TO_BT2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
"""Linear BT.709 RGB to linear BT.2020 RGB (ITU-R BT.2087)."""


PHOTOGRAPHS = ("coffee", "astronaut", "rocket", "chelsea")


@cache
def photograph(name: str = "coffee") -> np.ndarray:
    """Return a photograph of scikit-image (astronaut, chelsea, coffee, rocket), H x W x 3 uint8."""
    return np.ascontiguousarray(getattr(skimage.data, name)())


@cache
def _still(name: str, width: int, height: int) -> tuple[np.ndarray, float]:
    """Return a photograph, blurred for frames of a size, and its zoom factor."""
    still = photograph(name)
    zoom = 1.3 * max(width / still.shape[1], height / still.shape[0])
    if zoom < 0.1:  # blurring the full photograph would take a second
        still = cv2.resize(still, None, fx=10 * zoom, fy=10 * zoom, interpolation=cv2.INTER_AREA)
        zoom = 1.3 * max(width / still.shape[1], height / still.shape[0])
    return cv2.GaussianBlur(still, (0, 0), max(0.6, 0.5 / zoom)), zoom


def moving_frames(
    frames: int = 30, size: tuple[int, int] = (320, 180), name: str = "coffee"
) -> Iterator[np.ndarray]:
    """Return frames of a smooth pan over a photograph, H x W x 3 uint8 RGB; `size` is (width, height)."""
    return (moving_frame(number, size, name) for number in range(frames))


def moving_frame(number: int, size: tuple[int, int], name: str = "coffee") -> np.ndarray:
    """Return one of `moving_frames`."""
    width, height = size
    still, zoom = _still(name, width, height)
    turn = cv2.getRotationMatrix2D((still.shape[1] / 2, still.shape[0] / 2), 3 * np.sin(number / 17), zoom)
    turn[:, 2] += (width - still.shape[1]) / 2, (height - still.shape[0]) / 2
    turn[0, 2] += 0.08 * width * np.sin(number / 23)
    turn[1, 2] += 0.08 * height * np.sin(number / 31)
    return cv2.warpAffine(still, turn, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)


def planes_from_rgb(
    rgb: np.ndarray,
    matrix: str = "bt709",
    full_range: bool = False,
    depth: int = 8,
    step: tuple[int, int] = (2, 2),
) -> list[np.ndarray]:
    """Convert RGB 0..1 (H x W x 3 floats) to Y, Cb and Cr, left-sited, as integers of `depth` bits."""
    red, blue = MATRICES[matrix]
    weights = np.array([red, 1 - red - blue, blue])
    differences = ([0, 0, 1] - weights) / (2 - 2 * blue), ([1, 0, 0] - weights) / (2 - 2 * red)
    luma, *chroma = cv2.split(cv2.transform(rgb.astype(np.float32), np.array([weights, *differences])))
    top = 2.0**depth - 1
    unit = 2.0 ** (depth - 8)
    luma_low, luma_span, chroma_span = (0.0, top, top) if full_range else (16 * unit, 219 * unit, 224 * unit)
    planes = [luma_low + luma_span * luma]
    planes += [128 * unit + chroma_span * subsample(plane, step) for plane in chroma]
    return [np.clip(plane + 0.5, 0, top).astype(np.uint8 if depth == 8 else np.uint16) for plane in planes]


def subsample(plane: np.ndarray, step: tuple[int, int]) -> np.ndarray:
    """Subsample a plane by `step`: cosited horizontally (weights 1 2 1), means of pairs vertically."""
    across, down = step
    if down == 2:
        plane = cv2.copyMakeBorder(plane, 0, plane.shape[0] % 2, 0, 0, cv2.BORDER_REPLICATE)
        plane = (plane[0::2] + plane[1::2]) / 2
    if across == 2:
        wide = cv2.copyMakeBorder(plane, 0, 0, 1, 1, cv2.BORDER_REPLICATE)
        plane = (wide[:, :-2:2] + 2 * wide[:, 1:-1:2] + wide[:, 2::2]) / 4
    return plane


def hdr_signal(rgb: np.ndarray, transfer: str) -> np.ndarray:
    """Convert RGB 0..1 to the PQ or HLG signal of a scene with white at 203 nits and highlights near 1000.

    SMPTE ST 2084 and ITU-R BT.2100, with BT.2020 primaries; 0..1.
    """
    linear = rgb**2.4
    luminance = linear @ np.array([0.2126, 0.7152, 0.0722])
    nits = linear * (203 + 800 * luminance[..., None] ** 3) @ RGB_TO_BT2020.T
    if transfer == "pq":
        power = np.clip(nits / 10000, 0, 1) ** (2610 / 16384)
        return ((3424 / 4096 + 2413 / 128 * power) / (1 + 2392 / 128 * power)) ** (2523 / 32)
    display = np.clip(nits / 1000, 0, 1)
    luminance = display @ np.array([0.2627, 0.6780, 0.0593])
    scene = display * np.maximum(luminance, 1e-6)[..., None] ** (1 / 1.2 - 1)
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    high = a * np.log(np.maximum(12 * scene - b, 1e-9)) + c
    return np.where(scene <= 1 / 12, np.sqrt(3 * scene), high)


def fill_frame(frame: av.VideoFrame, planes: Sequence[np.ndarray]) -> av.VideoFrame:
    """Write the planes into the frame, row by row."""
    for target, plane in zip(frame.planes, planes, strict=True):
        plane = plane.reshape(plane.shape[0], -1)
        rows = np.frombuffer(target, np.uint8)[: target.line_size * plane.shape[0]]
        rows.reshape(-1, target.line_size)[:, : plane.shape[1] * plane.itemsize] = plane.view(np.uint8)
    return frame


def frame_from_rgb(
    rgb: np.ndarray,
    pix_fmt: str = "yuv420p",
    matrix: str = "bt709",
    full_range: bool = False,
    transfer: str = "",
) -> av.VideoFrame:
    """Return an av.VideoFrame of an RGB picture (H x W x 3 uint8), converted without the package.

    `pix_fmt` is yuv4??p, yuvj4??p, yuv4??p10le or 12le, yuva420p (alpha: a ramp), gray, gray10le, or any RGB
    (alpha: the ramp too).
    """
    height, width = rgb.shape[:2]
    planes = stored_planes(rgb, pix_fmt, matrix, full_range, transfer)
    return _frame_of(planes, (width, height), pix_fmt)


def stored_planes(
    rgb: np.ndarray, pix_fmt: str, matrix: str, full_range: bool, transfer: str
) -> list[np.ndarray]:
    """Return the planes of a frame for an RGB picture; for RGB formats the picture with a ramp of alpha."""
    height, width = rgb.shape[:2]
    if not pix_fmt.startswith(("yuv", "gray")):
        return [np.dstack([rgb, alpha_ramp(height, width)])]
    signal = rgb.astype(np.float32) / 255
    signal = hdr_signal(signal, transfer) if transfer else signal
    depth = next((int(bits) for bits in ("10", "12", "16") if f"{bits}le" in pix_fmt), 8)
    step = {"422": (2, 1), "444": (1, 1), "440": (1, 2)}.get(pix_fmt.replace("yuvj", "yuv")[3:6], (2, 2))
    planes = planes_from_rgb(signal, matrix, full_range, depth, step)
    if pix_fmt.startswith("gray"):
        planes = planes[:1]
    if pix_fmt.startswith("yuva"):
        planes.append(alpha_ramp(height, width))
    return planes


@lru_cache(1000)
def _moving_planes(number: int, size: tuple[int, int], name: str, *stored: Any) -> list[np.ndarray]:
    """Return the planes of a frame; cached, as many films start with the same frames."""
    return stored_planes(moving_frame(number, size, name), *stored)


def _frame_of(planes: Sequence[np.ndarray], size: tuple[int, int], pix_fmt: str) -> av.VideoFrame:
    if not pix_fmt.startswith(("yuv", "gray")):
        return fill_frame(av.VideoFrame(*size, "rgba"), planes).reformat(format=pix_fmt)
    return fill_frame(av.VideoFrame(*size, pix_fmt), planes)


def alpha_ramp(height: int, width: int) -> np.ndarray:
    """Return a ramp from opaque at the left to transparent at the right, H x W uint8."""
    return np.broadcast_to(np.linspace(255, 0, width).astype(np.uint8), (height, width)).copy()


def write_once(write: Callable[..., Path]) -> Callable[..., Path]:
    """Decorate a function that writes files: cache the content for each combination of options."""
    made: dict[tuple[str, str], bytes] = {}

    @wraps(write)
    def written(path: Path, **options: object) -> Path:
        key = path.suffix, repr(sorted(options.items()))
        if key in made:
            path.write_bytes(made[key])
        else:
            made[key] = write(path, **options).read_bytes()
        return path

    return written


@write_once
def make_clip(
    path: Path,
    *,
    size: tuple[int, int] = (160, 90),
    rate: Fraction | int = 30,
    frames: int = 30,
    times: Sequence[Fraction] | None = None,
    codec: str = "libx264",
    pix_fmt: str = "yuv420p",
    matrix: str = "bt709",
    full_range: bool = False,
    transfer: str = "",
    tagged: bool = True,
    rotation: int = 0,
    sample_aspect: Fraction | None = None,
    interlaced: bool = False,
    audio_tracks: int = 0,
    subtitles: Sequence[str] = (),
    chapters: int = 0,
    title: str = "",
    attachment: bytes = b"",
    options: dict[str, str] | None = None,
    photograph_name: str = "coffee",
    scene_frames: int = 0,
    format: str | None = None,
) -> Path:
    """Write a film and return its path; the name selects the container unless `format` is given.

    Args:
        size: width and height in pixels, as stored.
        times: presentation times in seconds, instead of `frames` at a constant rate.
        matrix: matrix of the samples, also in the tags if `tagged`.
        transfer: "", "pq" or "hlg"; the latter require matrix="bt2020" and a 10-bit `pix_fmt`.
        rotation: rotation by the player, in degrees counterclockwise.
        audio_tracks: number of AAC tracks (Opus in WebM) with different tones, in English, German, French.
        subtitles: languages of subtitle tracks (MKV or MP4) with two lines each.
        chapters: number of evenly spaced chapters.
        scene_frames: frames of a scene, after which a cut to the next photograph follows; 0: no cuts.
        options: encoder options, in addition to a fast preset and a key frame every second.
    """
    times = [Fraction(number) / Fraction(rate) for number in range(frames)] if times is None else list(times)
    # Without this, Matroska files contain random numbers.
    with av.open(str(path), "w", format=format, container_options={"fflags": "+bitexact"}) as container:
        video = container.add_stream(codec, rate=Fraction(rate), options=_encoder_options(codec, options))
        video.width, video.height, video.pix_fmt = *size, pix_fmt
        video.codec_context.thread_count = 1  # the threads of libvpx would mostly wait for each other
        video.codec_context.time_base = _time_base(times, Fraction(rate))
        _tag(video.codec_context, matrix if tagged else "", full_range, transfer)
        if sample_aspect:
            video.codec_context.sample_aspect_ratio = sample_aspect
        if rotation:
            video.set_display_rotation(rotation)
        if title:
            container.metadata["title"] = title
        sounds = [_add_sound(container, number) for number in range(audio_tracks)]
        lines = [_add_subtitle(container, language) for language in subtitles]
        if attachment:
            container.add_attachment("font.ttf", "application/x-truetype-font", attachment)
        open_encoder(video.codec_context)
        length = times[-1] + 1 / Fraction(rate)
        container.set_chapters(_chapters(chapters, length))
        for number, sound in enumerate(sounds):
            write_sound(container, sound, 300 + 200 * number, length)
        for line in lines:
            _write_subtitles(container, line, length)
        stored = pix_fmt, matrix, full_range, transfer
        for number, time in enumerate(times):
            name = PHOTOGRAPHS[number // scene_frames % 4] if scene_frames else photograph_name
            planes = _moving_planes(number, tuple(size), name, *stored)
            frame = _frame_of(planes, size, pix_fmt)
            if interlaced:
                frame = _interlace(frame)
            _tag(frame, matrix if tagged else "", full_range, transfer)
            frame.time_base = video.codec_context.time_base
            frame.pts = round(time / frame.time_base)
            container.mux(video.encode(frame))
        container.mux(video.encode(None))
    return path


def make_picture(path: Path, *, size: tuple[int, int] = (320, 180), mode: str = "RGB") -> Path:
    """Write a still picture with Pillow, independently of the package; `mode` is a mode of Pillow."""
    from PIL import Image

    rgb = next(moving_frames(1, size))
    picture = Image.fromarray(rgb)
    if mode == "RGBA":
        picture.putalpha(Image.fromarray(alpha_ramp(size[1], size[0])))
    elif mode == "I;16":
        picture = Image.fromarray(rgb[..., 1].astype(np.uint16) * 257)
    elif mode != "RGB":
        picture = picture.convert(mode)
    picture.save(path)
    return path


def rgb_from_frame(frame: av.VideoFrame) -> np.ndarray:
    """Convert a frame to RGB as a player does, by its tags (else by its size): H x W x 3 floats, 0..255.

    Our own arithmetic again, chroma raised to full size with its left siting; 4:2:0, 4:2:2, 4:4:4 or gray,
    8 to 16 bits, planar.
    """
    if frame.format.name in ("rgb24", "rgba", "bgra", "gbrp", "pal8", "bgr8"):
        return frame.to_ndarray(format="rgb24").astype(np.float32)
    name = frame.format.name
    depth = frame.format.components[0].bits
    full = frame.color_range == 2 or name.startswith("yuvj")
    top, unit = 2.0**depth - 1, 2.0 ** (depth - 8)
    luma_low, luma_span, chroma_span = (0.0, top, top) if full else (16 * unit, 219 * unit, 224 * unit)
    planes = [plane_samples(plane, depth) for plane in frame.planes]
    luma = (planes[0] - luma_low) / luma_span
    if name.startswith("gray"):
        return np.clip(np.dstack([luma] * 3), 0, 1) * 255
    large = frame.height >= 720 or frame.width >= 1280
    untagged = "bt709" if large else "bt601"
    matrix = {1: "bt709", 5: "bt601", 6: "bt601", 9: "bt2020", 10: "bt2020"}.get(frame.colorspace, untagged)
    blue, red = ((_raise(plane, luma.shape) - 128 * unit) / chroma_span for plane in planes[1:3])
    red_weight, blue_weight = MATRICES[matrix]
    rgb_red, rgb_blue = luma + (2 - 2 * red_weight) * red, luma + (2 - 2 * blue_weight) * blue
    rgb_green = (luma - red_weight * rgb_red - blue_weight * rgb_blue) / (1 - red_weight - blue_weight)
    return np.clip(np.dstack([rgb_red, rgb_green, rgb_blue]), 0, 1) * 255


def rms_error(one: np.ndarray, other: np.ndarray) -> float:
    """Return the root of the mean squared difference."""
    return float(np.sqrt(np.mean((one.astype(np.float64) - other.astype(np.float64)) ** 2)))


def read_all(path: Path) -> list[av.VideoFrame]:
    """Decode all frames of the first video stream with PyAV only."""
    with av.open(str(path)) as container:
        return list(container.decode(video=0))


def plane_samples(plane: av.video.plane.VideoPlane, depth: int) -> np.ndarray:
    dtype = np.uint8 if depth == 8 else np.uint16
    rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)[: plane.height]
    width = plane.width * np.dtype(dtype).itemsize
    return np.ascontiguousarray(rows[:, :width]).view(dtype).astype(np.float32)


def _raise(plane: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Upsample chroma to the shape of luma: linear, cosited horizontally and centred vertically."""
    height, width = shape
    across, down = -(-width // plane.shape[1]), -(-height // plane.shape[0])
    x = (np.arange(width, dtype=np.float32)) / across
    y = (np.arange(height, dtype=np.float32) - (down - 1) / 2) / down
    grid = np.meshgrid(x, y)
    return cv2.remap(plane, *grid, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _time_base(times: Sequence[Fraction], rate: Fraction) -> Fraction:
    regular = all(time == number / rate for number, time in enumerate(times))
    return 1 / rate if regular else Fraction(1, 90000)


def _encoder_options(codec: str, options: dict[str, str] | None) -> dict[str, str]:
    quick = {
        "libx264": {"preset": "ultrafast", "crf": "12", "g": "30"},
        "libx265": {"preset": "ultrafast", "crf": "12", "g": "30", "x265-params": "log-level=error"},
        "libvpx-vp9": {"deadline": "realtime", "cpu-used": "8", "crf": "20", "b": "0", "g": "30"},
    }
    return quick.get(codec, {}) | (options or {})


def _tag(tagged: av.VideoCodecContext | av.VideoFrame, matrix: str, full_range: bool, transfer: str) -> None:
    if matrix:
        for name, code in TAGS[matrix].items():
            setattr(tagged, name, code)
        if transfer:
            tagged.color_trc = TRANSFERS[transfer]
        tagged.color_range = 2 if full_range else 1
    elif full_range:
        tagged.color_range = 2


def _interlace(frame: av.VideoFrame) -> av.VideoFrame:
    """Comb the frame: shift its odd rows by 6 pixels."""
    planes = [plane_samples(plane, 8).astype(np.uint8) for plane in frame.planes]
    for plane in planes:
        plane[1::2] = np.roll(plane[1::2], 6 * plane.shape[1] // frame.width, axis=1)
    return fill_frame(frame, planes)


def _add_sound(container: av.container.OutputContainer, number: int) -> av.audio.stream.AudioStream:
    webm = container.format.name == "webm"
    stream = container.add_stream("libopus" if webm else "aac", rate=48000)
    stream.layout = "stereo"
    stream.metadata["language"] = ("eng", "deu", "fra")[number % 3]
    return stream


def write_sound(
    container: av.container.OutputContainer, stream: av.audio.stream.AudioStream, pitch: int, length: Fraction
) -> None:
    samples = np.arange(int(length * 48000))
    tone = 0.3 * np.sin(2 * np.pi * pitch * samples / 48000).astype(np.float32)
    for start in range(0, len(tone), 1024):
        part = np.ascontiguousarray(np.tile(tone[start : start + 1024], (2, 1)))
        frame = av.AudioFrame.from_ndarray(part, "fltp", "stereo")
        frame.sample_rate, frame.pts, frame.time_base = 48000, start, Fraction(1, 48000)
        container.mux(stream.encode(frame))
    container.mux(stream.encode(None))


def _add_subtitle(container: av.container.OutputContainer, language: str) -> av.stream.Stream:
    stream = container.add_mux_stream("mov_text" if "mp4" in container.format.name else "subrip")
    stream.metadata["language"] = language
    stream.time_base = Fraction(1, 1000)
    return stream


def _write_subtitles(
    container: av.container.OutputContainer, stream: av.stream.Stream, length: Fraction
) -> None:
    for number in range(2):
        text = f"{stream.metadata['language']} line {number + 1}".encode()
        packed = len(text).to_bytes(2, "big") + text if "mp4" in container.format.name else text
        packet = av.Packet(packed)
        packet.stream, packet.time_base = stream, Fraction(1, 1000)
        packet.pts = packet.dts = int(length * 500 * number)
        packet.duration = int(length * 400)
        packet.is_keyframe = True
        container.mux(packet)


def _chapters(count: int, length: Fraction) -> list[dict]:
    each = int(length * 1000) // max(count, 1)
    return [
        {
            "id": number + 1,
            "start": number * each,
            "end": (number + 1) * each,
            "time_base": Fraction(1, 1000),
            "metadata": {"title": f"Part {number + 1}"},
        }
        for number in range(count)
    ]
