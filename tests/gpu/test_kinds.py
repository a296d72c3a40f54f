"""Every kind of picture gives the same result on GPU and CPU: depths, chroma grids, RGB, alpha."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from covering import covering_rows, drawn
from gpu import FORMS, ODD, SMALL, Sessions, faults, film_picture, gray_picture, packed_picture
from pictures import FLOAT, RGB8, VIDEO, planes, run, same_bits, step, style

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.style import Style

SHAPE = SMALL

BOTH = Style(
    "both",
    ink="#204080",
    paper="#fff4e0",
    base=(step("brightness", factor=1.1), step("gaussian", sigma=0.8)),
    background=(step("saturation", factor=1.4),),
    lines=(step("to_gray"), step("sobel", invert=True, gain=1.5)),
)
"""Changes luma and colour, and blends them."""
ON_PLANES = style(
    step("brightness", factor=0.9), step("gaussian", sigma=1), step("to_color", chroma="source")
)
"""Keeps chroma unchanged."""
HALF_SIZE = style(step("scale", factor=0.6), step("brightness", factor=1.1))
"""Resamples chroma on its grid."""

STEPS = {"4:2:0": (2, 2), "4:2:2": (2, 1), "4:4:4": (1, 1), "4:1:1": (4, 1), "4:1:0": (4, 4), "4:4:0": (1, 2)}
DEPTHS = (8, 10, 12, 16, 0)
LEVELS = {"depth": DEPTHS, "full_range": (False, True), "subsampling": ((2, 2), (1, 1))}
GRIDS = [
    *(Encoding(siting=siting) for siting in SITINGS.values()),
    *(Encoding("bt601", subsampling=grid) for grid in STEPS.values()),
    Encoding(subsampling=(2, 2), siting=(1.0, 0.5)),
    Encoding("bt2020", depth=10, subsampling=(4, 4), siting=(1.5, 0.0)),
]
PAIRED = [*(Encoding(**row) for row in covering_rows(LEVELS)), *GRIDS]
ENCODINGS = [
    *(Encoding(**dict(zip(LEVELS, each, strict=True))) for each in product(*LEVELS.values())),
    *GRIDS,
]
CHANGES = {
    "bt601 in, bt709 out": (Encoding("bt601"), Encoding("bt709")),
    "limited in, full out": (VIDEO, Encoding(full_range=True)),
    "10 bit in, 8 bit out": (Encoding("bt2020", depth=10), VIDEO),
    "8 bit in, 10 bit out": (VIDEO, Encoding(depth=10, subsampling=(2, 1))),
    "16 bit in, float out": (Encoding(full_range=True, depth=16, subsampling=(1, 1)), FLOAT),
    "float in, 12 bit out": (FLOAT, Encoding(depth=12)),
    "4:4:4 in, 4:1:1 out": (Encoding(subsampling=(1, 1)), Encoding(subsampling=(4, 1))),
    "4:1:0 in, 4:2:2 out": (Encoding(subsampling=(4, 4)), Encoding(subsampling=(2, 1))),
    "left in, topleft out": (VIDEO, Encoding(siting=SITINGS["topleft"])),
}


sessions = Sessions.fixture()


def named(encoding: Encoding) -> str:
    kind = "full" if encoding.full_range else "limited"
    return f"{encoding.matrix} {encoding.depth} bit {kind} {encoding.subsampling} at {encoding.siting}"


def faults_by_encoding(
    chosen: Style,
    sessions: Sessions,
    encodings: Iterable[Encoding],
    shape: tuple[int, int],
    in_one_form: bool = False,
) -> list[str]:
    return [
        line
        for encoding in encodings
        for forms in [[drawn(FORMS, f"{chosen} {encoding}")] if in_one_form else FORMS]
        for line in faults(sessions, chosen, film_picture(*shape, encoding), named(encoding), forms)
    ]


every_change = pytest.mark.parametrize(
    "chosen", [BOTH, ON_PLANES, HALF_SIZE], ids=["both", "luma", "half size"]
)


@every_change
def test_every_encoding_agrees(chosen: Style, sessions: Sessions) -> None:
    assert faults_by_encoding(chosen, sessions, PAIRED, SHAPE, in_one_form=True) == []


@pytest.mark.thorough
@every_change
def test_every_depth_agrees_in_every_range_and_grid(chosen: Style, sessions: Sessions) -> None:
    assert faults_by_encoding(chosen, sessions, ENCODINGS, ODD) == []


@pytest.mark.parametrize("chosen", [style(), BOTH, ON_PLANES], ids=["plain", "both", "luma"])
def test_every_change_of_encoding_agrees(chosen: Style, sessions: Sessions) -> None:
    found = [
        line
        for name, (old, new) in CHANGES.items()
        for form in [drawn(FORMS, f"{chosen} {name}")]
        for line in faults(sessions, chosen, film_picture(*SHAPE, old), name, [form], target=new)
    ]
    assert not found, "\n".join(found)


def test_packed_rgb_as_input_and_output(sessions: Sessions) -> None:
    found = []
    for depth in DEPTHS:
        packed = packed_picture(*SHAPE, replace(RGB8, depth=depth))
        film = film_picture(*SHAPE, Encoding(depth=depth))
        for other in (8, 12, 0):
            target = replace(RGB8, depth=other)
            label = f"{depth} bit in, {other} bit out"
            found += faults(sessions, BOTH, packed, f"RGB in and out, {label}", target=target, rgb=True)
            found += faults(sessions, BOTH, film, f"RGB out, {label}", target=target, rgb=True)
        found += faults(sessions, BOTH, packed, f"RGB in, {depth} bit", target=Encoding(depth=depth))
        found += faults(sessions, BOTH, packed, f"RGB as 601, {depth} bit", target=Encoding("bt601"))
    assert not found, "\n".join(found)


@pytest.mark.parametrize("chosen", [style(), BOTH, ON_PLANES], ids=["plain", "both", "luma"])
def test_gray_output_as_planes_or_rgb(chosen: Style, sessions: Sessions) -> None:
    gray = gray_picture(*SHAPE)
    for target, rgb in [(Encoding(depth=10), False), (Encoding("bt601"), False), (RGB8, True)]:
        found = faults(sessions, chosen, gray, f"gray to {named(target)}", target=target, rgb=rgb)
        assert not found, "\n".join(found)


def test_a_gray_result_has_neutral_chroma(sessions: Sessions) -> None:
    found = faults(sessions, style(step("to_gray")), film_picture(*SHAPE), "to_gray")
    assert not found, "\n".join(found)


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("target_depth", [8, 10, 0])
def test_alpha_is_kept(depth: int, target_depth: int, sessions: Sessions) -> None:
    """The same plane object if the depth does not change."""
    packed = packed_picture(*SHAPE, replace(RGB8, depth=depth))
    assert packed.color is not None
    source = replace(packed, alpha=np.ascontiguousarray(packed.color[::-1, :, 0]))
    target = replace(RGB8, depth=target_depth)
    right = run(BOTH, source, target=target, rgb=True)
    for form in FORMS:
        made = sessions.run(form, BOTH, source, target=target, rgb=True)
        assert made.alpha is not None
        np.testing.assert_array_equal(made.alpha, right.alpha)
        assert (made.alpha is source.alpha) == (depth == target_depth)


def views(picture: Picture) -> dict[str, Picture]:
    """The same samples in other memory layouts."""

    def changed(change) -> Picture:  # type: ignore[no-untyped-def]
        luma, color = (None if each is None else change(each) for each in (picture.luma, picture.color))
        chroma = None if picture.chroma is None else (change(picture.chroma[0]), change(picture.chroma[1]))
        return Picture(picture.encoding, luma, chroma, color)

    def padded(plane: np.ndarray) -> np.ndarray:
        wider = np.full((plane.shape[0] + 3, plane.shape[1] + 29, *plane.shape[2:]), 77, plane.dtype)
        wider[2:-1, 13:-16] = plane
        return wider[2:-1, 13:-16]

    return {
        "padded": changed(padded),
        "mirrored": changed(lambda plane: np.ascontiguousarray(plane[:, ::-1])[:, ::-1]),
        "upside down": changed(lambda plane: np.ascontiguousarray(plane[::-1])[::-1]),
        "columns first": changed(np.asfortranarray),
    }


@pytest.mark.parametrize("depth", [8, 10, 0])
def test_any_memory_order_is_read(depth: int, sessions: Sessions) -> None:
    for source in (
        film_picture(*SHAPE, Encoding(depth=depth)),
        packed_picture(*SHAPE, replace(RGB8, depth=depth)),
    ):
        for form in FORMS:
            right = sessions.run(form, BOTH, source, target=VIDEO)
            for name, view in views(source).items():
                assert same_bits(sessions.run(form, BOTH, view, target=VIDEO), right), (name, form)


UNTOUCHED = {
    "nothing": (style(), (True, True)),
    "luma": (style(step("brightness")), (False, True)),
    "luma by way of gray": (style(step("to_gray"), step("gaussian"), step("to_color")), (False, True)),
    "chroma": (
        style(step("gaussian", save="soft"), step("to_color", source="source", chroma="soft")),
        (True, False),
    ),
    "what comes back": (
        style(step("gaussian"), step("to_color", source="source", chroma="source")),
        (True, True),
    ),
}
"""Styles, and whether luma and chroma of the result are the source's planes."""


@pytest.mark.parametrize("name", UNTOUCHED)
@pytest.mark.parametrize("encoding", [VIDEO, Encoding(depth=10, subsampling=(1, 1)), FLOAT], ids=named)
def test_unmodified_planes_are_passed_through(name: str, encoding: Encoding, sessions: Sessions) -> None:
    chosen, expected = UNTOUCHED[name]
    source = film_picture(*SHAPE, encoding)
    assert faults(sessions, chosen, source, name) == []
    for form in FORMS:
        made = sessions.run(form, chosen, source)
        held = [any(plane is old for old in planes(source)) for plane in planes(made)]
        assert held == [expected[0], expected[1], expected[1]], form
