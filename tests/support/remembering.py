"""A film with scenes, and a style with all kinds of state of earlier frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from films import noisy, page, picture
from pictures import step, style

from vidstyle.core.picture import Picture

REMEMBERING = replace(
    style(
        step("gaussian", sigma=1.5),
        step("mosaic", size=5, variation=0.4, edges=0.3),
        step("equalize", low=5.0, settle=1.0),
        steady=0.6,
    ),
    lines=(step("minimum_range", settle=0.5), step("sobel", invert=True)),
)
"""All kinds of state: two measurements, moving marks, stabilization of source and result."""


def film(shape: tuple[int, int] = (45, 60)) -> Iterator[Picture]:
    """Yield two scenes with a moving camera, then a scene of another size."""
    for name, size in (("coffee", shape), ("rocket", shape), ("coffee", (shape[0] - 9, shape[1] + 10))):
        wide = page(size[0], size[1] + 12, name)
        yield from (picture(noisy(wide[:, 2 * n : 2 * n + size[1]], 3, n)) for n in range(4))


FILM = list(film())
