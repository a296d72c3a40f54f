"""What a group of a compute pass keeps in shared memory, so that textures are read less often."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.shader_nodes import CHANNELS, ShaderNode

MAX_BYTES = 32768
"""Shared memory for each group that OpenGL promises. Filters that read more than fits read the texture."""
STEP_BYTES = 4096
"""Room for what a filter prepares is made in such steps."""
MIN_BYTES = 8192
"""Room for pixels is made in powers of two from here on, so that a slider that changes a radius seldom needs
another shader; with less, threads and not memory limit how many groups share a processor."""
BYTES = {1: 4, 2: 8, 3: 16}
"""What so many numbers take in shared memory: some drivers keep three as four."""

Pair = tuple[int, int]


@dataclass(frozen=True)
class Sharing:
    """The pixels around a group's own that are read from a texture once for all its invocations.

    Attributes:
        image: the picture that is read.
        radius: how many pixels are read beyond the group's own, across and down.
        line: the direction in which all its filters read, (1, 0) or (0, 1); None if they read all around.
        prepares: the filter that prepares something for the whole group, or None.
    """

    image: ShaderNode
    radius: Pair
    line: Pair | None
    prepares: ShaderNode | None

    def capacities(self, area: Pair, used: int) -> tuple[int, int] | None:
        """How many pixels, and how many values that a filter prepares, a group keeps.

        Args:
            area: how many pixels it computes, across and down.
            used: bytes of shared memory that it needs for other things.

        Returns:
            None where shared memory is too small for all that it reads.
        """
        size = BYTES[CHANNELS[self.image.kind]]
        needed = size * prod(side + 2 * radius for side, radius in zip(area, self.radius, strict=True))
        prepared = -(-BYTES[3] * self._lines(area) // STEP_BYTES) * STEP_BYTES
        grown = max(MIN_BYTES, 1 << (needed - 1).bit_length())
        available = min(grown, MAX_BYTES - used - prepared)
        return (available // size, prepared // BYTES[3]) if needed <= available else None

    def _lines(self, area: Pair) -> int:
        """How many values are prepared: for each column one between each two rows of pixels that are read."""
        return 0 if self.prepares is None else area[0] * (area[1] + 2 * self.prepares.radius - 1)


def sharing_of(each: Pass) -> Sharing | None:
    """What a compute pass reads through shared memory; None if it reads no neighbours, or few of many.

    The filters and kinds of values decide; the values of sliders only decide how much memory it takes.
    """
    filters = [node for node in each.nodes if _reads_neighbours(node)]
    lines = {node.function.signature.line for node in filters if node.function}
    line = lines.pop() if len(lines) == 1 else None
    # Halftone, the one that reads RGB all around, looks at four pixels of it.
    if not filters or (line is None and filters[0].kind == "color"):
        return None
    image = filters[0].around
    assert image is not None
    radius = max(node.radius for node in filters)
    across, down = line or (1, 1)
    prepares = next((node for node in filters if node.function and node.function.signature.prepares), None)
    return Sharing(image, (radius * across, radius * down), line, prepares)


def _reads_neighbours(node: ShaderNode) -> bool:
    """Whether it is a filter: pictures of another size are resampled, which have no radius.

    So is chroma that is brought to its own grid, even where one pixel is a page of both.
    """
    resamples = node.function is not None and node.function.name in ("resampled", "shrunk_chroma")
    return node.is_heavy and not resamples and node.around is not None and node.around.shape == node.shape
