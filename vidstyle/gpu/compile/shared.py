"""Shared memory of compute passes: each work group reads its neighbourhood from textures only once."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.shader_nodes import CHANNEL_COUNTS, ShaderNode

MAX_SHARED_BYTES = 32768
"""Shared memory per work group that OpenGL guarantees. Filters that need more read the texture directly."""
STEP_BYTES = 4096
"""The size of the memory for data that a filter prepares is rounded up to a multiple of this."""
MIN_PIXEL_BYTES = 8192
"""The size of the memory for pixels is rounded up to a power of two, at least this, so that a slider that
changes a radius rarely needs another shader. Below this size, occupancy is limited by threads, not by
memory."""
VALUE_BYTES = {1: 4, 2: 8, 3: 16}
"""Bytes of a value in shared memory by number of channels; some drivers pad three channels to four."""

Pair = tuple[int, int]


@dataclass(frozen=True)
class Sharing:
    """The neighbourhood of a work group, which is read from a texture once for all its invocations.

    Attributes:
        image: the picture that is read.
        radius: pixels that are read outside of the group, across and down.
        line: the direction in which all its filters read, (1, 0) or (0, 1); None for both.
        prepares: the filter that prepares data for the whole group, or None.
    """

    image: ShaderNode
    radius: Pair
    line: Pair | None
    prepares: ShaderNode | None

    def capacities(self, area: Pair, used: int) -> tuple[int, int] | None:
        """Return the numbers of pixels and of values prepared by a filter in the shared memory of a group.

        Args:
            area: pixels that the group computes, across and down.
            used: bytes of shared memory for other purposes.

        Returns:
            None if shared memory is too small.
        """
        size = VALUE_BYTES[CHANNEL_COUNTS[self.image.kind]]
        needed = size * prod(side + 2 * radius for side, radius in zip(area, self.radius, strict=True))
        prepared = -(-VALUE_BYTES[3] * self._lines(area) // STEP_BYTES) * STEP_BYTES
        grown = max(MIN_PIXEL_BYTES, 1 << (needed - 1).bit_length())
        available = min(grown, MAX_SHARED_BYTES - used - prepared)
        return (available // size, prepared // VALUE_BYTES[3]) if needed <= available else None

    def _lines(self, area: Pair) -> int:
        """Return the number of prepared values: for each column, one between each two rows of pixels read."""
        return 0 if self.prepares is None else area[0] * (area[1] + 2 * self.prepares.radius - 1)


def sharing_of(each: Pass) -> Sharing | None:
    """Return what a compute pass reads through shared memory; None if it reads no or few neighbours.

    The result depends on the filters and the kinds of values; sliders only change the amount of memory.
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
    """Whether a node is a filter. Resampling from another size is not, as it has no radius.

    Chroma resampled to another grid and a selection for 2 x 2 pixels are not, even if both are a single
    pixel.
    """
    resamples = node.function is not None and node.function.name in ("resampled", "shrunk_chroma")
    resamples = resamples or node.kind == "choices"
    return node.is_heavy and not resamples and node.around is not None and node.around.shape == node.shape
