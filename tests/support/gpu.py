"""Cached sessions, pictures and tolerances for the tests of GPU agreement."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

import cv2
import numpy as np
import pytest
from covering import drawn
from media import photograph
from pictures import FLOAT, RGB8, VIDEO, run, style

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.device.devices import Device, choose
from vidstyle.gpu.session import GpuSession
from vidstyle.style import Style

FORMS: tuple[Form, ...] = ("compute", "fragment")
SHAPES = {
    f"{width}x{height}": (height, width)
    for height, width in ((360, 640), (361, 641), (1, 1), (8192, 16), (16, 8192))
}
"""Height and width by name, width x height."""
ODD = (75, 101)
SMALL = (61, 97)
"""Heights and widths of most pictures, no multiples of work group sizes."""

AGREEMENT = 0.999
"""Minimum share of the samples of each plane that differ by at most one level of 255."""
BIAS = 0.1
"""Maximum mean difference of a plane in levels; rounding down would cause 0.5 in 8 bits. A lower limit would
fail for means of a few chroma codes, which are often halves that textures round either way. Each tone counts
once, because a flat colour may be such a half."""


def device() -> Device:
    """Return the device for the tests, without a graphics card Mesa's; a missing device is a failure."""
    chosen = choose("gpu").device
    assert chosen is not None
    return chosen


class Sessions:
    """A session for each form, opened once because contexts and shaders are slow to create.

    Args:
        options: arguments of each session.
    """

    def __init__(self, **options: Any) -> None:
        self._sessions = {form: GpuSession(device(), form, **options) for form in FORMS}

    @classmethod
    def fixture(cls, **options: Any) -> Any:
        """Return a fixture with sessions for the tests of a module."""

        @pytest.fixture(scope="module")
        def opened() -> Iterator[Sessions]:
            with cls(**options) as sessions:
                yield sessions

        return opened

    def __enter__(self) -> Sessions:
        return self

    def __exit__(self, *_: object) -> None:
        for session in self._sessions.values():
            session.close()

    def __getitem__(self, form: Form) -> GpuSession:
        return self._sessions[form]

    def start(
        self,
        form: Form,
        chosen: Style,
        picture: Picture,
        target: Encoding | None = None,
        rgb: bool = False,
        time: float | None = None,
    ) -> Callable[[], Picture]:
        """Start to restyle a picture on the GPU, and return a function that waits for the result."""
        session = self[form]
        started = session.start(chosen, FrameRequest(picture, time, target, rgb))
        return lambda: session.fetch(started.result()).result()

    def run(self, form: Form, chosen: Style, picture: Picture, **options: Any) -> Picture:
        """Restyle a picture on the GPU."""
        return self.start(form, chosen, picture, **options)()


@cache
def scene(height: int, width: int, name: str = "coffee") -> np.ndarray:
    """Return a photograph stretched to a size, with noise, RGB float32 0..1."""
    still = cv2.resize(photograph(name), (width, height), interpolation=cv2.INTER_AREA)
    grain = np.random.default_rng(1).normal(0, 0.03, still.shape)
    return np.clip(still / 255 + grain, 0, 1).astype(np.float32)


@cache
def film_picture(height: int, width: int, encoding: Encoding = VIDEO, name: str = "coffee") -> Picture:
    """Return the scene as planes of an encoding, by default 8-bit 4:2:0 video."""
    return run(style(), Picture(FLOAT, color=scene(height, width, name)), target=encoding)


def gray_picture(height: int, width: int) -> Picture:
    """Return the luma of the scene."""
    return Picture(VIDEO, luma=film_picture(height, width).luma)


def packed_picture(height: int, width: int, encoding: Encoding = RGB8) -> Picture:
    """Return the scene as packed RGB with the depth of an encoding."""
    return run(style(), Picture(FLOAT, color=scene(height, width)), target=encoding, rgb=True)


def named_planes(picture: Picture) -> dict[str, np.ndarray]:
    """Return the planes of a picture by name."""
    blue, red = picture.chroma or (None, None)
    named = {"luma": picture.luma, "blue": blue, "red": red, "color": picture.color, "alpha": picture.alpha}
    return {name: plane for name, plane in named.items() if plane is not None}


def differences(one: Picture, other: Picture) -> dict[str, np.ndarray]:
    """Return the differences of the samples of each plane, in levels of 255.

    Both pictures must have the same planes, of the same sizes and types, in the same encoding.
    """
    assert one.encoding == other.encoding
    planes, others = named_planes(one), named_planes(other)
    described, described_other = (
        {name: (plane.shape, plane.dtype) for name, plane in each.items()} for each in (planes, others)
    )
    assert described == described_other
    # Exact for integer samples; float32 needs a margin for rounding.
    level = (2**one.encoding.depth - 1) // 255 if one.encoding.depth else 1 / 255 + 1e-6
    return {name: (others[name] - plane.astype(np.float64)) / level for name, plane in planes.items()}


MAX_OFF_PIXELS = 9
"""Samples that may always differ: if one pixel selects another filter of a bank, a second bank spreads the
difference to 3 x 3 pixels, which exceed the allowed share in small pictures."""


def disagreements(right: Picture, made: Picture, agreement: float = AGREEMENT) -> list[str]:
    """Return a line for each plane and reason if two pictures disagree.

    Every sample may differ by one level, but not all in the same direction: that would be wrong rounding.

    Args:
        agreement: minimum share of the samples that differ by at most one level.
    """
    found = []
    planes = named_planes(right)
    for name, levels in differences(right, made).items():
        off = np.abs(levels) > 1
        if off.sum() > max((1 - agreement + 1e-12) * off.size, MAX_OFF_PIXELS):
            found.append(f"{name}: {off.mean():.3%} of the samples are off")
        _, tones, counts = np.unique(planes[name], return_inverse=True, return_counts=True)
        # A few samples of the same tone are rounded in the same direction by chance.
        often = (counts > 3) | (counts == counts.max())
        biases = (np.bincount(tones.ravel(), levels.ravel()) / counts)[often]
        if abs(bias := float(biases.mean())) > BIAS + 1 / biases.size:
            found.append(f"{name}: {bias:.3f} levels of bias")
    return found


def max_code_difference(one: Picture, other: Picture) -> int:
    """Return the maximum difference in codes."""
    pairs = zip(named_planes(one).values(), named_planes(other).values(), strict=True)
    return max(int(np.abs(plane.astype(int) - same).max()) for plane, same in pairs)


def faults(
    sessions: Sessions,
    chosen: Style,
    picture: Picture,
    label: str,
    forms: Sequence[Form] = FORMS,
    **options: Any,
) -> list[str]:
    """Return the disagreements of each form with the CPU."""
    started = {form: sessions.start(form, chosen, picture, **options) for form in forms}
    right = run(chosen, picture, **options)
    return [
        f"{label}, {form}: {line}" for form, made in started.items() for line in disagreements(right, made())
    ]


def faults_of_kinds(sessions: Sessions, chosen: Style) -> list[str]:
    """Return disagreements with the CPU: of each form for a film, and of one form for gray pictures."""
    return [
        line
        for make, forms in ((film_picture, FORMS), (gray_picture, [drawn(FORMS, chosen.name)]))
        for shape in (SMALL, (1, 1))
        for line in faults(sessions, chosen, make(*shape), f"{make.__name__} {shape}", forms)
    ]
