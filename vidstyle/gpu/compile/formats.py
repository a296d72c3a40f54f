"""Texture formats, and the values that their numbers represent."""

from __future__ import annotations

from dataclasses import dataclass

from vidstyle.core.picture import Encoding
from vidstyle.gpu.compile.shader_nodes import ShaderKind, ShaderNode


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
        return self.components * {"f1": 1, "nu2": 2, "f4": 4}[self.dtype]

    @property
    def image(self) -> str:
        """Its name as a GLSL image layout."""
        return {1: "r", 2: "rg", 4: "rgba"}[self.components] + {"f1": "8", "nu2": "16", "f4": "32f"}[
            self.dtype
        ]

    @property
    def most(self) -> int:
        """The integer that stores the normalized 1."""
        return {"f1": 255, "nu2": 65535, "f4": 1}[self.dtype]


WORKING: dict[ShaderKind, Format] = {
    "luma": Format(1, "nu2", -0.5, 2.0),
    "chroma": Format(2, "nu2", -0.75, 1.5),
    "color": Format(4, "nu2", -1.0, 3.0),
    "choices": Format(4, "nu2"),
}
"""Textures between passes: normalized 16 bit, not half floats of the same size. Near white the error of a
half float is up to 1/4096, which a difference of Gaussians with a soft threshold multiplies by forty, to
three levels of 255; here it is 1/65000 of white in luma and 1/43000 in RGB. The range has headroom for
out-of-gamut RGB and for the overshoot of bicubic and Lanczos resampling, which at a sharp edge is almost half
of the step."""


WIDE = Format(1, "f4")
"""For luma far beyond black and white, such as a difference of Gaussians times twenty."""


def working_format(node: ShaderNode) -> Format:
    """The format in which a value is stored between passes."""
    return WIDE if node.is_wide else WORKING[node.kind]


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
