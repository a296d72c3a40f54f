"""The last sweep, whose nodes become the planes of the result."""

from __future__ import annotations

from concurrent.futures import Executor

from vidstyle.core.bands import in_bands
from vidstyle.core.convert import PictureAssembler
from vidstyle.core.picture import Picture
from vidstyle.core.planes import chroma_radius
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.style.nodes import LoweredStyle


def write_output(pool: Executor, lowered: LoweredStyle, frame: FrameExecutor, source: Picture) -> Picture:
    """The result in the target's encoding, or as packed RGB.

    Planes of the source that no step has touched are handed on as they are. Values are clipped to the range
    of the samples.
    """
    assembler = PictureAssembler(source, lowered.target, lowered.color is not None)
    if lowered.luma_untouched:
        assert source.luma is not None
        assembler.reuse_luma(source.luma)
    chroma = lowered.chroma
    if chroma is not None and chroma.grid is not None:
        assembler.reuse_chroma(frame.subsampled_chroma(chroma), chroma.grid)
    made = {node.kind: node for node in frame.output_nodes}
    above, below = chroma_radius(lowered.target) if "chroma" in made else (0, 0)

    def run(top: int, bottom: int) -> None:
        first = max(top - above, 0)
        values = frame.output_rows(first, min(bottom + below, source.shape[0]))
        if "color" in made:
            assembler.put_color(top, values[made["color"]])
        if "chroma" in made:
            assembler.put_chroma(top, bottom, top - first, values[made["chroma"]])
        if "luma" in made:
            assembler.put_luma(top, values[made["luma"]][top - first : bottom - first])

    if made:
        in_bands(pool, source.shape, frame.radius, run)
    return assembler.picture()
