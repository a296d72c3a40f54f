"""What a style computes at every pixel: a graph of calls of pure functions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.compile.glsl import Signature, signatures

Kind = Literal["luma", "chroma", "color", "choices"]
"""Choices are the numbers of the filters that 2 x 2 pixels choose."""
CHANNELS: dict[Kind, int] = {"luma": 1, "chroma": 2, "color": 3, "choices": 4}
"""How many numbers a value of each kind has."""

Shape = tuple[int, int]
"""Height and width."""


@dataclass(frozen=True)
class Function:
    """A GLSL function.

    Attributes:
        file: its path below shaders/.
        name: its name there.
        channels: what the word `channels` in the file stands for: 1 or 3 numbers (2 for chroma).
    """

    file: str
    name: str
    channels: int = 1

    @property
    def signature(self) -> Signature:
        """What its file says of it."""
        return signatures(self.file)[self.name]


@dataclass(frozen=True, eq=False)
class Measure:
    """Percentiles of luma that a measured step is given, and how fast they follow changes.

    Attributes:
        of: the luma that is measured.
        percentages: which percentiles.
        time_constant: in seconds.
        step: layer and number of the step.
    """

    of: Node
    percentages: tuple[float, ...]
    time_constant: float
    step: tuple[str, int]


@dataclass(frozen=True, eq=False)
class Node:
    """One value at every pixel of a page.

    Attributes:
        kind: what the value is.
        shape: of the page; for chroma in samples of its own grid.
        function: what makes it; None for a plane of the source.
        inputs: the function's parameters that are values of the same pixel.
        around: the picture of which the function reads other pixels too, or None.
        radius: how many pixels around its own it reads there, where sizes are alike.
        values: the function's parameters that are the same for all pixels.
        options: the words that a parameter's number stands for, where it is a choice.
        measure: the numbers that it is given.
        grid: for chroma, step and siting of its samples upon luma; None for one at each pixel.
        page: for chroma with a grid, the size of the luma that it belongs to.
        is_wide: whether it goes so far beyond black and white that it has to be kept as float32.
    """

    kind: Kind
    shape: Shape
    function: Function | None = None
    inputs: dict[str, Node] = field(default_factory=dict)
    around: Node | None = None
    radius: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    options: dict[str, tuple[str, ...]] = field(default_factory=dict)
    measure: Measure | None = None
    grid: Encoding | None = None
    page: Shape | None = None
    is_wide: bool = False

    @property
    def is_plane(self) -> bool:
        """Whether it is a plane of the source."""
        return self.function is None

    @property
    def is_enlarged(self) -> bool:
        """Whether it is chroma brought from its own grid to every pixel, or a pixel's own choice."""
        if self.around is None:
            return False
        return self.around.kind == "choices" or (self.around.grid is not None and self.grid is None)

    @property
    def is_heavy(self) -> bool:
        """Whether it reads so much around a pixel that it is worth a pass, and computed only once."""
        return self.around is not None and not self.is_enlarged


@dataclass(frozen=True)
class PictureLayout:
    """What a picture is made of, without its samples: all that a plan depends on.

    Attributes:
        shape: height and width.
        planes: "gray", "chroma" (luma and chroma) or "color" (packed RGB).
    """

    encoding: Encoding
    shape: Shape
    planes: Literal["gray", "chroma", "color"]

    @classmethod
    def of(cls, picture: Picture) -> PictureLayout:
        """That of a picture."""
        planes: Literal["gray", "chroma", "color"] = "gray" if picture.chroma is None else "chroma"
        return cls(picture.encoding, picture.shape, planes if picture.color is None else "color")
