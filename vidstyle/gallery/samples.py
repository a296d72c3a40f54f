"""One picture in several styles, all cores at work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.core.bands import CORES
from vidstyle.core.picture import Picture
from vidstyle.cpu import CpuRenderer
from vidstyle.style import Style


@dataclass(frozen=True)
class StyleSample:
    """What a style makes of the picture; H x W x 3 uint8."""

    style: Style
    picture: np.ndarray


def samples_of(picture: np.ndarray, styles: Iterable[Style]) -> Iterator[StyleSample]:
    """The picture, H x W x 3 uint8, in every style, in their order; each as soon as it is there."""
    with ThreadPoolExecutor(CORES, thread_name_prefix="vidstyle-gallery") as pool:
        yield from pool.map(lambda style: StyleSample(style, restyled(picture, style)), styles)


def restyled(picture: np.ndarray, style: Style) -> np.ndarray:
    """The picture, H x W x 3 uint8, in a style, by one thread."""
    source = Picture.from_array(picture)
    with CpuRenderer(replace(style, steady=0.0), threads=1) as renderer:
        color = renderer.run(source, None, source.encoding, rgb=True).color
    assert color is not None
    return np.array(color)
