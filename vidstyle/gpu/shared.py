"""What a group of a compute pass keeps in shared memory, so that textures are read less often."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from vidstyle.gpu.nodes import CHANNELS, Node
from vidstyle.gpu.passes import Pass

TILE_BYTES = 16384
"""Shared memory for the pixels that a group reads. With chroma, and what a filter prepares, it must stay
below the 32 KiB that OpenGL promises; the less it is, the more groups share a processor. Filters that reach
further than fits read the texture, as in a fragment pass."""
PREPARED_REACH = 8
"""The widest reach of filters that prepare something in shared memory; wider ones read the texture too."""

Pair = tuple[int, int]


@dataclass(frozen=True)
class Sharing:
    """The pixels around a group's own that are read from a texture once for all its invocations.

    Attributes:
        image: the picture that is read.
        reach: how many pixels are read beyond the group's own, across and down.
        line: the direction in which all its filters read, (1, 0) or (0, 1); None if they read all around.
        prepares: the filter that prepares something for the whole group, or None.
    """

    image: Node
    reach: Pair
    line: Pair | None
    prepares: Node | None

    def fits(self, area: Pair) -> bool:
        """Whether there is room for all that a group reads that computes an area of pixels."""
        if self.prepares is not None:
            return self.reach[0] <= PREPARED_REACH
        sides = (side + 2 * reach for side, reach in zip(area, self.reach, strict=True))
        return prod(sides) <= self.room(area)

    def room(self, area: Pair) -> int:
        """How many pixels are kept at most, for a group that computes an area of pixels."""
        if self.prepares is None:
            return TILE_BYTES // (4 * CHANNELS[self.image.kind])
        return (area[0] + 2 * PREPARED_REACH) * (area[1] + 2 * PREPARED_REACH)

    def prepared_room(self, area: Pair) -> int:
        """How many values are prepared at most: for each column one between each two rows of pixels."""
        return area[0] * (area[1] + 2 * PREPARED_REACH - 1)


def sharing_of(each: Pass) -> Sharing | None:
    """What a compute pass reads through shared memory; None if it reads no neighbours, or few of many.

    The filters and kinds of values decide; of the values of sliders only whether the reach fits.
    """
    filters = [node for node in each.nodes if _reads_neighbours(node)]
    lines = {node.function.signature.line for node in filters if node.function}
    line = lines.pop() if len(lines) == 1 else None
    # Halftone, the one that reads RGB all around, looks at four pixels of it.
    if not filters or (line is None and filters[0].kind == "color"):
        return None
    image = filters[0].around
    assert image is not None
    reach = max(node.reach for node in filters)
    across, down = line or (1, 1)
    prepares = next((node for node in filters if node.function and node.function.signature.prepares), None)
    return Sharing(image, (reach * across, reach * down), line, prepares)


def _reads_neighbours(node: Node) -> bool:
    """Whether it is a filter: pictures of another size are resampled, which no reach describes."""
    return node.is_heavy and node.around is not None and node.around.shape == node.shape
