"""Some rows of a picture on their way through steps, in whatever form the last step left them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import Chroma, chroma_rows, color_rows, luma_rows, rgb_from_yuv, yuv_from_rgb


@dataclass(frozen=True)
class Whole:
    """A whole picture, whose chroma may still lie in another one that nobody has touched.

    Attributes:
        main: holds luma or RGB.
        tint: where the chroma is; `main` itself, an earlier picture, or None for gray.
    """

    main: Picture
    tint: Picture | None

    @classmethod
    def of(cls, picture: Picture) -> Whole:
        """The picture as it is."""
        return cls(picture, None if picture.color is None and picture.chroma is None else picture)


class Band:
    """Rows top..bottom; converted only when a step asks for another form, and then only these rows.

    Attributes:
        top, bottom: which rows of the page these are.
        tint: the picture whose chroma belongs to them while no step has made its own; None for gray.
    """

    def __init__(self, whole: Whole, top: int, bottom: int) -> None:
        self.encoding: Encoding = whole.main.encoding
        self.top, self.bottom = top, bottom
        self.tint = whole.tint
        self._main = whole.main
        self._luma: np.ndarray | None = None
        self._chroma: Chroma | None = None
        self._color: np.ndarray | None = None

    @property
    def is_gray(self) -> bool:
        """Whether there is no chroma."""
        return self.tint is None and self._chroma is None and self._color is None

    @property
    def is_color(self) -> bool:
        """Whether the rows are held as RGB."""
        loaded = self._luma is not None or self._chroma is not None
        return self._color is not None or (
            not loaded and self._main is self.tint and self._main.color is not None
        )

    @property
    def own_chroma(self) -> Chroma | None:
        """Blue and red difference made by steps, or None while they are the tint's or there are none."""
        return self._chroma

    def luma(self) -> np.ndarray:
        """Luma, N x W float32."""
        if self.is_color:
            self._luma, *chroma = yuv_from_rgb(self.color(), self.encoding)
            self._chroma, self._color = (chroma[0], chroma[1]), None
        if self._luma is None:
            self._luma = luma_rows(self._main, self.top, self.bottom)
        return self._luma

    def chroma(self) -> Chroma:
        """Blue and red difference, N x W float32 each; zero for gray."""
        if self.is_color:
            self.luma()
        if self._chroma is None:
            if self.tint is None:
                return np.zeros_like(self.luma()), np.zeros_like(self.luma())
            self._chroma = chroma_rows(self.tint, self.top, self.bottom)
        return self._chroma

    def color(self) -> np.ndarray:
        """RGB, N x W x 3 float32."""
        if self._color is not None:
            return self._color
        if self.is_color:
            self._color = color_rows(self._main, self.top, self.bottom)
        elif self.is_gray:
            return np.repeat(self.luma()[..., None], 3, axis=2)
        else:
            return rgb_from_yuv(self.luma(), self.chroma(), self.encoding)
        return self._color

    def channels(self) -> np.ndarray:
        """Luma of a gray picture, RGB of any other."""
        return self.luma() if self.is_gray else self.color()

    def set_luma(self, luma: np.ndarray) -> None:
        """Put other luma in the place of what `luma` gave."""
        self._luma = luma

    def set_color(self, color: np.ndarray) -> None:
        """Put RGB in the place of all there was."""
        self._luma, self._chroma, self._color = None, None, color

    def set_chroma(self, chroma: Chroma) -> None:
        """Put other chroma, at luma's resolution, in the place of what there was."""
        self.luma()
        self._chroma = chroma

    def take_tint(self, tint: Picture | None) -> None:
        """Let the chroma be another picture's, or none."""
        self.luma()
        self.tint, self._chroma = tint, None

    def take_matrix(self, matrix: str) -> None:
        """Let luma and chroma be those of another colour matrix."""
        if matrix != self.encoding.matrix and not self.is_gray:
            self.set_color(self.color())
            self.encoding = replace(self.encoding, matrix=matrix)

    def crop(self, top: int, bottom: int) -> None:
        """Leave only these rows of the page."""
        rows = slice(top - self.top, bottom - self.top)
        self._luma = None if self._luma is None else self._luma[rows]
        self._color = None if self._color is None else self._color[rows]
        if self._chroma is not None:
            self._chroma = (self._chroma[0][rows], self._chroma[1][rows])
        self.top, self.bottom = top, bottom
