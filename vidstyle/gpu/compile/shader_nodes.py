"""The graph that the shaders of a style compute at every pixel: calls of GLSL functions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from vidstyle.core.picture import Encoding
from vidstyle.gpu.compile.glsl import Signature, signatures
from vidstyle.style.nodes import Measure, Shape

ShaderKind = Literal["luma", "chroma", "color", "choices"]
"""Kinds of values; "choices" are the numbers of the filters that 2 x 2 pixels choose."""

CHANNELS: dict[ShaderKind, int] = {"luma": 1, "chroma": 2, "color": 3, "choices": 4}
"""Number of channels of each kind of value."""


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
        """Its declaration in the file."""
        return signatures(self.file)[self.name]


@dataclass(frozen=True, eq=False)
class ShaderNode:
    """One value at every pixel, made by one call of a GLSL function.

    Attributes:
        kind: what the value is.
        shape: of the picture that it belongs to; for chroma with a grid, in samples of that grid.
        function: the function that computes it; None for a plane of the source.
        inputs: the function's parameters that are values at the same pixel.
        around: the picture that the function reads at other pixels, too, or None.
        radius: pixels around its own that it reads there, if the sizes are equal.
        values: the function's parameters that are the same for all pixels.
        options: the words of parameters that are choices.
        measure: the percentiles that it receives.
        grid: for subsampled chroma, step and siting of its samples; None for chroma at every pixel.
        page: for subsampled chroma, the shape of the luma that it belongs to.
        is_wide: whether its range requires storing it as float32.
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
        """Whether it is upsampled: chroma of a subsampled grid, or the choice of a filter."""
        if self.around is None:
            return False
        return self.around.kind == "choices" or (self.around.grid is not None and self.grid is None)

    @property
    def is_heavy(self) -> bool:
        """Whether it reads a neighbourhood large enough for a pass of its own, and is computed only once."""
        return self.around is not None and not self.is_enlarged


ShaderMeasure = Measure[ShaderNode]
"""Percentiles of luma that a shader takes."""
