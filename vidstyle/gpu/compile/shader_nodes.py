"""The graph of GLSL calls that the shaders of a style make at every pixel, and the formats of textures."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from vidstyle.core.picture import RANGES, Encoding
from vidstyle.gpu.compile.glsl import Form, Signature, signatures
from vidstyle.style.nodes import Measure, Shape

ShaderKind = Literal["luma", "chroma", "color", "direction", "choices"]
"""Kinds of values; "choices" are numbers of filters or angles of 2 x 2 pixels, "direction" is one of each."""

CHANNELS: dict[ShaderKind, int] = {"luma": 1, "chroma": 2, "color": 3, "direction": 2, "choices": 4}
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
        is_wide: whether its range, or what reads it, requires storing it as float32.
        limits: what its values are clipped to, or None.
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
    limits: tuple[float, float] | None = None

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


@dataclass(frozen=True)
class Format:
    """A texture format.

    Attributes:
        components: numbers in a texel.
        dtype: moderngl's name of their type: "f1" and "nu2" are normalized 8 and 16 bit, "f4" is float32.
        low, span: the value that the normalized 0 represents, and the distance to that of 1.
    """

    components: int
    dtype: str
    low: float = 0.0
    span: float = 1.0

    @property
    def bytes(self) -> int:
        """Bytes in a texel."""
        return self.components * int(self.dtype[-1])

    @property
    def image(self) -> str:
        """Its name as a GLSL image layout."""
        return "rgba"[: self.components] + {"f1": "8", "nu2": "16", "f4": "32f"}[self.dtype]

    @property
    def most(self) -> int:
        """The integer that stores the normalized 1."""
        return {"f1": 255, "nu2": 65535, "f4": 1}[self.dtype]


def _working_texture(kind: str, components: int) -> Format:
    low, high = RANGES[kind]
    return Format(components, "nu2", low, high - low)


WORKING: dict[ShaderKind, Format] = {
    "luma": _working_texture("luma", 1),
    "chroma": _working_texture("chroma", 2),
    "color": _working_texture("color", 4),
    "direction": Format(2, "nu2"),
    "choices": Format(4, "nu2"),
}
"""Textures between passes: normalized 16 bit, not half floats of the same size. Near white the error of a
half float is up to 1/4096, which a difference of Gaussians with a soft threshold multiplies by forty, to
three levels of 255; here it is 1/65000 of white in luma and 1/43000 in RGB."""


def working_format(node: ShaderNode, form: Form) -> Format:
    """The format in which a value is stored between passes.

    WebGL draws into floats everywhere, but into normalized 16 bit only by an extension that many lack. Where
    it has half floats only, luma takes two of them, and RGB is stored about 0, where they are more accurate.
    """
    if form == "es":
        return Format(WORKING[node.kind].components, "f4", low=0.5 if node.kind == "color" else 0.0)
    # Of luma far beyond black and white, such as a difference of Gaussians times twenty, and of directions.
    return Format(WORKING[node.kind].components, "f4") if node.is_wide else WORKING[node.kind]


def sample_format(form: Form) -> Format:
    """The format of samples of luma that are measured."""
    return Format(1, "f4") if form == "es" else WORKING["luma"]


def plane_format(depth: int, components: int = 1) -> Format:
    """The format for a plane of the source or of the result.

    Args:
        depth: bits of an integer sample, 0 for float32.
        components: 1, 3 or 4.
    """
    return Format(components, "f4" if depth == 0 else "f1" if depth <= 8 else "nu2")


def levels(encoding: Encoding, kind: ShaderKind) -> tuple[float, float]:
    """The codes of the values 0 and 1 in a plane; RGB always has the full range."""
    if kind == "chroma":
        neutral, span = encoding.chroma_levels
        return neutral, neutral + span
    if kind == "color" and encoding.depth:
        return 0.0, float(2**encoding.depth - 1)
    return encoding.luma_levels
