"""The last pass: lines over background, and the planes that the sink wants."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.bands import in_bands
from vidstyle.core.convert import PictureAssembler
from vidstyle.core.kernels import mix_channels
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import chroma_radius
from vidstyle.core.resample import resample
from vidstyle.cpu.band import Band, Whole
from vidstyle.cpu.work import Work
from vidstyle.style import Style

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Page:
    """What is put together at the end.

    Attributes:
        background: the colour layer, or None where the paper alone lies under the lines.
        lines: the layer whose luma lets the background through where it is white, or None.
        ink, paper: RGB 0..1.
    """

    background: Work | None
    lines: Work | None
    ink: Triple
    paper: Triple

    @classmethod
    def of(cls, style: Style, background: Work | None, lines: Work | None) -> Page:
        """A page with the style's colours."""
        return cls(background, lines, rgb_from_text(style.ink), rgb_from_text(style.paper))

    def band(self, top: int, bottom: int) -> Band:
        """These rows of the finished page."""
        if self.background is None:
            assert self.lines is not None
            return self._lines_on_paper(self.lines.band(top, bottom))
        band = self.background.band(top, bottom)
        if self.paper != (1, 1, 1):
            band.set_color(mix_channels(band.color(), np.diag([*self.paper, 0.0])[:3]))
        if self.lines is not None:
            self._draw(band, self.lines.band(top, bottom).luma())
        return band

    def _lines_on_paper(self, band: Band) -> Band:
        cover = band.luma()
        band.take_tint(None)
        paper, blue, red = band.encoding.yuv_from_color(self.paper)
        band.set_luma(np.full_like(cover, paper))
        if (blue, red) != (0, 0):
            band.set_chroma((np.full_like(cover, blue), np.full_like(cover, red)))
        self._draw(band, cover)
        return band

    def _draw(self, band: Band, cover: np.ndarray) -> None:
        """Ink where the lines are dark; mixing is linear, so luma and chroma serve, which come next."""
        ink, blue, red = band.encoding.yuv_from_color(self.ink)
        luma = band.luma()
        if not (band.is_gray and (blue, red) == (0, 0)):
            old_blue, old_red = band.chroma()
            band.set_chroma((_mixed(blue, old_blue, cover), _mixed(red, old_red, cover)))
        band.set_luma(_mixed(ink, luma, cover))


def _mixed(ink: float, under: np.ndarray, cover: np.ndarray) -> np.ndarray:
    out = under - np.float32(ink)
    out *= cover
    out += np.float32(ink)
    return out


def finish(pool: Executor, page: Page, source: Picture, target: Encoding, rgb: bool) -> Picture:
    """The finished page as integer (or, with depth 0, float32) planes of the wanted encoding.

    Planes of the source that no step has touched, and that are already encoded so, are handed on as
    they are. Values are cut off to the range that the numbers have.

    Args:
        rgb: packed RGB is wanted instead of luma and chroma; only the encoding's depth counts then.
    """
    radius = max((work.radius for work in (page.background, page.lines) if work is not None), default=0)
    assembler = PictureAssembler(source, target, rgb)
    above, below = chroma_radius(target)

    def run(top: int, bottom: int) -> None:
        if rgb:
            assembler.put_color(top, page.band(top, bottom).color())
        else:
            band = page.band(max(top - above, 0), min(bottom + below, source.shape[0]))
            _put_planes(assembler, band, top, bottom)

    in_bands(pool, source.shape, radius, run)
    return assembler.picture()


def _put_planes(assembler: PictureAssembler, band: Band, top: int, bottom: int) -> None:
    """Store the rows top..bottom of a band that may hold a few more."""
    band.take_matrix(assembler.target.matrix)
    tint = band.tint
    untouched = tint is not None and not band.is_color and band.own_chroma is None
    if tint is not None and untouched and assembler.can_reuse_chroma(tint):
        assembler.reuse_chroma(tint)
    elif not band.is_gray:
        assembler.put_chroma(top, bottom, top - band.top, band.chroma())
    assembler.put_luma(top, band.luma()[top - band.top : bottom - band.top])


def at_size(whole: Whole, shape: tuple[int, int], method: str) -> Whole:
    """The picture at another size, as float32 planes, chroma at a step of its own."""
    main, tint = whole.main, whole.tint
    if main.shape == shape and (tint is None or tint.shape == shape):
        return whole
    if main.color is not None and main is tint:
        color = Band(whole, 0, main.shape[0]).color()
        return Whole.of(Picture(main.encoding.as_float(), color=resample(color, shape, method)))
    luma = resample(Band(whole, 0, main.shape[0]).luma(), shape, method)
    if tint is None:
        return Whole.of(Picture(main.encoding.as_float(), luma=luma))
    return Whole.of(_with_chroma(luma, tint, method))


def _with_chroma(luma: np.ndarray, tint: Picture, method: str) -> Picture:
    old = tint.encoding
    if tint.chroma is None:
        blue, red = Band(Whole.of(tint), 0, tint.shape[0]).chroma()
        planes, new = (blue, red), old.as_float()
    else:
        neutral, span = old.chroma_levels
        new = old.as_float_at(tint.shape, (luma.shape[0], luma.shape[1]))
        planes = tuple((plane.astype(np.float32) - neutral) / span for plane in tint.chroma)  # type: ignore[assignment]
    shape = new.chroma_shape(*luma.shape)
    blue, red = (resample(plane.astype(np.float32, copy=False), shape, method) for plane in planes)
    return Picture(new, luma=luma, chroma=(blue, red))
