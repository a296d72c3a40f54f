"""Shared by the tests of GPU agreement: cached sessions, pictures, and the tolerance."""

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
"""Height and width by a name of width x height."""
ODD = (75, 101)
SMALL = (61, 97)
"""Heights and widths of most pictures: whole multiples of no group of a shader."""

AGREEMENT = 0.999
"""The share of the samples of each plane that must not differ by more than one level of 255."""
BIAS = 0.1
"""By how many levels a plane may be darker or brighter as a whole: to round down would make it 0.5 in 8 bits.
Not less, because means of a few chroma codes often lie at a half, which a texture's rounding tips over; and
each tone counts once, because a flat color may lie there, too."""


def device() -> Device:
    """The device that the tests run on: Mesa's where there is no graphics card. Not optional."""
    chosen = choose("gpu").device
    assert chosen is not None
    return chosen


class Sessions:
    """A session for each form, opened once: a context takes long to open, and a program to compile.

    Args:
        options: those of every session.
    """

    def __init__(self, **options: Any) -> None:
        self._sessions = {form: GpuSession(device(), form, **options) for form in FORMS}

    @classmethod
    def fixture(cls, **options: Any) -> Any:
        """A fixture: the sessions of a module's tests."""

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
        """Begin to restyle a picture on the GPU while other work goes on; call what this gives for it."""
        session = self[form]
        started = session.start(chosen, FrameRequest(picture, time, target, rgb))
        return lambda: session.fetch(started.result()).result()

    def run(self, form: Form, chosen: Style, picture: Picture, **options: Any) -> Picture:
        """A picture in a style, on the GPU."""
        return self.start(form, chosen, picture, **options)()


@cache
def scene(height: int, width: int, name: str = "coffee") -> np.ndarray:
    """A photograph stretched to a size, with noise upon it: RGB, float32 0..1."""
    still = cv2.resize(photograph(name), (width, height), interpolation=cv2.INTER_AREA)
    grain = np.random.default_rng(1).normal(0, 0.03, still.shape)
    return np.clip(still / 255 + grain, 0, 1).astype(np.float32)


@cache
def film_picture(height: int, width: int, encoding: Encoding = VIDEO, name: str = "coffee") -> Picture:
    """The scene as planes of an encoding, legal video 4:2:0 in 8 bits if nothing else is said."""
    return run(style(), Picture(FLOAT, color=scene(height, width, name)), target=encoding)


def gray_picture(height: int, width: int) -> Picture:
    """The scene's luma alone."""
    return Picture(VIDEO, luma=film_picture(height, width).luma)


def packed_picture(height: int, width: int, encoding: Encoding = RGB8) -> Picture:
    """The scene as packed RGB of an encoding's depth."""
    return run(style(), Picture(FLOAT, color=scene(height, width)), target=encoding, rgb=True)


def named_planes(picture: Picture) -> dict[str, np.ndarray]:
    """The planes that a picture has."""
    blue, red = picture.chroma or (None, None)
    named = {"luma": picture.luma, "blue": blue, "red": red, "color": picture.color, "alpha": picture.alpha}
    return {name: plane for name, plane in named.items() if plane is not None}


def differences(one: Picture, other: Picture) -> dict[str, np.ndarray]:
    """For each plane by how many levels of 255 its samples differ.

    Both pictures must have the same planes, of the same sizes and types, in the same encoding.
    """
    assert one.encoding == other.encoding
    planes, others = named_planes(one), named_planes(other)
    described, described_other = (
        {name: (plane.shape, plane.dtype) for name, plane in each.items()} for each in (planes, others)
    )
    assert described == described_other
    # The whole level of an integer sample; in float32 a level more is not told from rounding.
    level = (2**one.encoding.depth - 1) // 255 if one.encoding.depth else 1 / 255 + 1e-6
    return {name: (others[name] - plane.astype(np.float64)) / level for name, plane in planes.items()}


SAMPLES_AROUND_A_CHOICE = 9
"""Samples of 3 x 3 pixels: where one pixel takes another filter of a bank, a second bank spreads that. In
small pictures these are more than the share that may be off."""


def disagreements(right: Picture, made: Picture, agreement: float = AGREEMENT) -> list[str]:
    """What is not alike, a line for each reason and plane; nothing where the rule is kept.

    The rule lets every sample be off by a level, but not all to one side: that would be a wrong rounding.

    Args:
        agreement: the share of the samples that must not be off by more than a level.
    """
    found = []
    planes = named_planes(right)
    for name, levels in differences(right, made).items():
        off = np.abs(levels) > 1
        if off.sum() > max((1 - agreement + 1e-12) * off.size, SAMPLES_AROUND_A_CHOICE):
            found.append(f"{name}: {off.mean():.3%} of the samples are off")
        _, tones, counts = np.unique(planes[name], return_inverse=True, return_counts=True)
        # A tone that a few samples have is rounded to one side by chance.
        often = (counts > 3) | (counts == counts.max())
        biases = (np.bincount(tones.ravel(), levels.ravel()) / counts)[often]
        if abs(bias := float(biases.mean())) > BIAS + 1 / biases.size:
            found.append(f"{name}: {bias:.3f} levels of bias")
    return found


def most_off(one: Picture, other: Picture) -> int:
    """By how many codes the two differ at most."""
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
    """Where either form disagrees with the CPU."""
    started = {form: sessions.start(form, chosen, picture, **options) for form in forms}
    right = run(chosen, picture, **options)
    return [
        f"{label}, {form}: {line}" for form, made in started.items() for line in disagreements(right, made())
    ]


def faults_of_kinds(sessions: Sessions, chosen: Style) -> list[str]:
    """Where a form disagrees with the CPU on a film, or one of them on gray pictures, of any size."""
    return [
        line
        for make, forms in ((film_picture, FORMS), (gray_picture, [drawn(FORMS, chosen.name)]))
        for shape in (SMALL, (1, 1))
        for line in faults(sessions, chosen, make(*shape), f"{make.__name__} {shape}", forms)
    ]
