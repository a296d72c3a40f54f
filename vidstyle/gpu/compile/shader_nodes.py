"""The graph of GLSL calls that the shaders of a style run at every pixel, and the formats of textures."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from vidstyle.core.picture import RANGES, Encoding
from vidstyle.gpu.compile.glsl import Form, Signature, signatures
from vidstyle.style.nodes import PercentileRequest, Shape

ShaderKind = Literal["luma", "chroma", "color", "direction", "choices"]
"""Kinds of values; "choices" are numbers of filters or angles of 2 x 2 pixels, "direction" is one of each."""

CHANNEL_COUNTS: dict[ShaderKind, int] = {"luma": 1, "chroma": 2, "color": 3, "direction": 2, "choices": 4}
"""Number of channels of each kind of value."""


@dataclass(frozen=True)
class Function:
    """A GLSL function.

    Attributes:
        file: its path in shaders/.
        name: its name there.
        channels: the number of channels that the word `channels` in the file stands for: 1 or 3 (2 for
            chroma).
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
    """One value at every pixel, computed by one call of a GLSL function.

    Attributes:
        kind: kind of the value.
        shape: shape of the picture that it belongs to; for chroma with a grid, in samples of the grid.
        function: the function that computes it; None for a plane or a mask of the source.
        inputs: parameters of the function that are values at the same pixel.
        around: the picture that the function also reads at other pixels, or None.
        radius: number of pixels on each side that it reads in this picture, if the sizes are equal.
        values: parameters of the function that are the same for all pixels.
        options: words of parameters that are choices.
        measure: the percentiles that it receives.
        grid: for subsampled chroma, step and siting of its samples; None for chroma at every pixel.
        page: for subsampled chroma, the shape of its luma.
        is_wide: whether its range, or the nodes that read it, require storing it as float32.
        limits: the range that its values are clipped to, or None.
        mask: the name of a mask of the source, or empty.
        moves: whether its marks move with a film, see `core.drift`.
    """

    kind: ShaderKind
    shape: Shape
    function: Function | None = None
    inputs: dict[str, ShaderNode] = field(default_factory=dict)
    around: ShaderNode | None = None
    radius: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    options: dict[str, tuple[str, ...]] = field(default_factory=dict)
    measure: PercentileRequest[ShaderNode] | None = None
    grid: Encoding | None = None
    page: Shape | None = None
    is_wide: bool = False
    limits: tuple[float, float] | None = None
    mask: str = ""
    moves: bool = False

    @property
    def is_plane(self) -> bool:
        """Whether it is a plane or a mask of the source."""
        return self.function is None

    @property
    def is_enlarged(self) -> bool:
        """Whether it is upsampled: chroma of a subsampled grid, or the number of a filter."""
        if self.around is None:
            return False
        return self.around.kind == "choices" or (self.around.grid is not None and self.grid is None)

    @property
    def is_heavy(self) -> bool:
        """Whether it reads a neighbourhood large enough for a separate pass, and is computed only once."""
        return self.around is not None and not self.is_enlarged


ShaderPercentileRequest = PercentileRequest[ShaderNode]
"""Percentiles of luma that a shader receives."""


@dataclass(frozen=True)
class Format:
    """A texture format.

    Attributes:
        components: number of components of a texel.
        dtype: moderngl's name of their type: "f1" and "nu2" are normalized 8 and 16 bit, "f4" is float32.
        low, span: the value that the normalized 0 represents, and the distance to the value of 1.
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


WORKING_FORMATS: dict[ShaderKind, Format] = {
    "luma": _working_texture("luma", 1),
    "chroma": _working_texture("chroma", 2),
    "color": _working_texture("color", 4),
    "direction": Format(2, "nu2"),
    "choices": Format(4, "nu2"),
}
"""Textures between passes: normalized 16 bit, which are more accurate than half floats of the same size. Near
white the error of a half float is up to 1/4096, which a difference of Gaussians with a soft threshold
multiplies by forty, to three levels of 255; here it is 1/65000 of white in luma and 1/43000 in RGB."""


def working_format(node: ShaderNode, form: Form) -> Format:
    """Return the format in which a value is stored between passes.

    WebGL can always draw into floats, but into normalized 16 bit only with an extension that many devices
    lack. If it only has half floats, luma is stored in two of them, and RGB is stored around 0, where they
    are more accurate.
    """
    if form == "es":
        return Format(WORKING_FORMATS[node.kind].components, "f4", low=0.5 if node.kind == "color" else 0.0)
    # For directions, and for luma far outside 0..1, such as a difference of Gaussians times twenty.
    return Format(WORKING_FORMATS[node.kind].components, "f4") if node.is_wide else WORKING_FORMATS[node.kind]


def sample_format(form: Form) -> Format:
    """Return the format of samples of luma to measure."""
    return Format(1, "f4") if form == "es" else WORKING_FORMATS["luma"]


def plane_format(depth: int, components: int = 1) -> Format:
    """Return the format of a plane of the source or the result.

    Args:
        depth: bits of an integer sample, 0 for float32.
        components: 1, 3 or 4.
    """
    return Format(components, "f4" if depth == 0 else "f1" if depth <= 8 else "nu2")


def levels(encoding: Encoding, kind: ShaderKind) -> tuple[float, float]:
    """Return the codes of the values 0 and 1 in a plane; RGB always has the full range."""
    if kind == "chroma":
        neutral, span = encoding.chroma_levels
        return neutral, neutral + span
    if kind == "color" and encoding.depth:
        return 0.0, float(2**encoding.depth - 1)
    return encoding.luma_levels
