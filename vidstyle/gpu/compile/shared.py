"""Shared memory of compute passes: the neighbourhood of a work group is read from textures only once."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.shader_nodes import CHANNELS, ShaderNode

MAX_BYTES = 32768
"""Shared memory of a work group that OpenGL guarantees. Filters that need more read the texture directly."""
STEP_BYTES = 4096
"""The size of the memory that a filter prepares is rounded up to a multiple of this."""
MIN_BYTES = 8192
"""The size of the memory for pixels is rounded up to a power of two, at least this, so that a slider that
changes a radius seldom needs another shader. With less, occupancy is limited by threads, not by memory."""
BYTES = {1: 4, 2: 8, 3: 16}
"""Bytes of a value in shared memory by its number of channels; some drivers pad three to four."""

Pair = tuple[int, int]


@dataclass(frozen=True)
class Sharing:
    """The neighbourhood of a work group, which is read from a texture once for all its invocations.

    Attributes:
        image: the picture that is read.
        radius: pixels that are read beyond those of the group, across and down.
        line: the direction in which all its filters read, (1, 0) or (0, 1); None for both.
        prepares: the filter that prepares data for the whole group, or None.
    """

    image: ShaderNode
    radius: Pair
    line: Pair | None
    prepares: ShaderNode | None

    def capacities(self, area: Pair, used: int) -> tuple[int, int] | None:
        """Number of pixels, and of values prepared by a filter, in the shared memory of a group.

        Args:
            area: pixels that the group computes, across and down.
            used: bytes of shared memory that are needed otherwise.

        Returns:
            None if shared memory is too small.
        """
        size = BYTES[CHANNELS[self.image.kind]]
        needed = size * prod(side + 2 * radius for side, radius in zip(area, self.radius, strict=True))
        prepared = -(-BYTES[3] * self._lines(area) // STEP_BYTES) * STEP_BYTES
        grown = max(MIN_BYTES, 1 << (needed - 1).bit_length())
        available = min(grown, MAX_BYTES - used - prepared)
        return (available // size, prepared // BYTES[3]) if needed <= available else None

    def _lines(self, area: Pair) -> int:
        """Number of values prepared: for each column, one between each two rows of pixels that are read."""
        return 0 if self.prepares is None else area[0] * (area[1] + 2 * self.prepares.radius - 1)


def sharing_of(each: Pass) -> Sharing | None:
    """What a compute pass reads through shared memory; None if it reads no neighbours, or only few.

    This depends on the filters and the kinds of values; sliders only change the amount of memory.
    """
    filters = [node for node in each.nodes if _reads_neighbours(node)]
    lines = {node.function.signature.line for node in filters if node.function}
    line = lines.pop() if len(lines) == 1 else None
    # Halftone, the only filter that reads RGB in both directions, reads just four pixels.
    if not filters or (line is None and filters[0].kind == "color"):
        return None
    image = filters[0].around
    assert image is not None
    radius = max(node.radius for node in filters)
    across, down = line or (1, 1)
    prepares = next((node for node in filters if node.function and node.function.signature.prepares), None)
    return Sharing(image, (radius * across, radius * down), line, prepares)


def _reads_neighbours(node: ShaderNode) -> bool:
    """Whether it is a filter. Resampling from another size is not, as it has no radius.

    Nor is chroma resampled to another grid, or a choice for 2 x 2 pixels, even if both are a single pixel.
    """
    resamples = node.function is not None and node.function.name in ("resampled", "shrunk_chroma")
    resamples = resamples or node.kind == "choices"
    return node.is_heavy and not resamples and node.around is not None and node.around.shape == node.shape
