"""What the shaders of a style compute at every pixel: calls of GLSL functions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from vidstyle.core.picture import Encoding
from vidstyle.gpu.compile.glsl import Signature, signatures
from vidstyle.style.nodes import Measure, Shape

ShaderKind = Literal["luma", "chroma", "color", "choices"]
"""Kinds of values; "choices" are the numbers of the filters that 2 x 2 pixels choose."""

CHANNELS: dict[ShaderKind, int] = {"luma": 1, "chroma": 2, "color": 3, "choices": 4}
"""How many numbers a value of each kind has."""


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
class ShaderNode:
    """One value at every pixel, made by one call of a GLSL function.

    Attributes:
        kind: what the value is.
        shape: of the picture that it belongs to; for chroma with a grid, in samples of that grid.
        function: what makes it; None for a plane of the source.
        inputs: the function's parameters that are values of the same pixel.
        around: the picture of which the function reads other pixels too, or None.
        radius: how many pixels around its own it reads there, where sizes are alike.
        values: the function's parameters that are the same for all pixels.
        options: the words that a parameter's number stands for, where it is a choice.
        measure: the numbers that it is given.
        grid: for subsampled chroma, step and siting of its samples; None for chroma at every pixel.
        page: for subsampled chroma, the shape of the luma that it belongs to.
        is_wide: whether it goes so far beyond black and white that it has to be stored as float32.
    """

    kind: ShaderKind
    shape: Shape
    function: Function | None = None
    inputs: dict[str, ShaderNode] = field(default_factory=dict)
    around: ShaderNode | None = None
    radius: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    options: dict[str, tuple[str, ...]] = field(default_factory=dict)
    measure: Measure[ShaderNode] | None = None
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


ShaderMeasure = Measure[ShaderNode]
"""Percentiles of luma that a shader takes."""
