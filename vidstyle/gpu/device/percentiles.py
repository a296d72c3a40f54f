"""Percentiles that are measured and smoothed on the GPU, so that no frame waits for a readback."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.gpu.compile.glsl import TRIANGLE_SHADER, read_source

if TYPE_CHECKING:
    import moderngl

_SIDE_BINS = 256
"""Rows and columns of the histogram: one bin for each 16-bit value."""


class GpuPercentiles:
    """The percentiles of one measured step. The caller owns the context.

    It uses an exact histogram: each sample is drawn as a point on its bin, and blending counts the points,
    which OpenGL 3.3 supports; floats count exactly up to 2^24. Further passes sum the rows of bins, find the
    samples next to each percentile, interpolate, and smooth over time.

    Args:
        low, span: the range of the samples' values, from low to low + span.
    """

    def __init__(self, context: moderngl.Context, low: float, span: float) -> None:
        self._context = context
        self._bins = _Target(context, (_SIDE_BINS, _SIDE_BINS), 1, context.BLEND)
        self._rows = _Target(context, (_SIDE_BINS, 1), 1)
        self._ordered = _Target(context, (4, 2), 1)
        self._smoothed = [_Target(context, (1, 1), 4) for _ in range(2)]
        self._into_bins = _shader(context, "measure/bin_vertex.glsl", "bin_fragment")
        self._into_rows = _shader(context, TRIANGLE_SHADER, "row_fragment")
        self._order = _shader(context, TRIANGLE_SHADER, "order_fragment", bins=0, rows=1)
        self._smoothing = _shader(
            context, TRIANGLE_SHADER, "smooth_fragment", ordered=0, remembered=1, low=low, span=span
        )
        self._first = True

    def measure(
        self, samples: moderngl.Texture, size: tuple[int, int], percentages: Sequence[float], weight: float
    ) -> moderngl.Texture:
        """Measure percentiles of these samples and return the smoothed percentiles.

        Percentiles between two samples are interpolated as by `numpy.percentile`.

        Args:
            samples: one component, 16-bit normalized; 0 is `low` and 1 is `low + span`.
            size: width and height of the part to measure, from the first row and column; at most 2^24
                samples.
            percentages: one to four, 0 to 100.
            weight: weight of the new percentiles, 0 to 1; the first percentiles are not smoothed.

        Returns:
            A 1 x 1 texture of four floats, the last percentile repeated if there are fewer than four; valid
            until the second next call.
        """
        ranks = [percentage / 100 * (size[0] * size[1] - 1) for percentage in percentages]
        ranks += ranks[-1:] * (4 - len(ranks))
        # Split in double precision: the fraction must be accurate to 2^-16 of the range from black to white.
        self._order.program["ranks"] = tuple(float(int(rank)) for rank in ranks)
        self._smoothing.program["fractions"] = tuple(rank % 1 for rank in ranks)
        self._smoothing.program["weight"] = 1.0 if self._first else weight
        self._first = False
        self._count(samples, size)
        self._rows.draw(self._into_rows, self._bins.texture)
        self._ordered.draw(self._order, self._bins.texture, self._rows.texture)
        self._smoothed.reverse()
        now, before = self._smoothed
        now.draw(self._smoothing, self._ordered.texture, before.texture)
        return now.texture

    def numbers(self) -> np.ndarray:
        """Return the last percentiles, four float32; waits for the GPU."""
        return np.frombuffer(self._smoothed[0].texture.read(), np.float32)

    def replace(self, numbers: np.ndarray) -> None:
        """Use one to four other percentiles instead of the last ones."""
        four = np.append(numbers, [numbers[-1]] * (4 - len(numbers))).astype(np.float32)
        self._smoothed[0].texture.write(four.tobytes())

    def restart(self) -> None:
        """Forget the percentiles so far: the next ones are not smoothed."""
        self._first = True

    def _count(self, samples: moderngl.Texture, size: tuple[int, int]) -> None:
        context = self._context
        self._bins.framebuffer.clear()
        self._into_bins.program["width"] = size[0]
        context.blend_func = context.ONE, context.ONE
        self._bins.draw(self._into_bins, samples, mode=context.POINTS, vertices=size[0] * size[1])
        # The default of a context; moderngl cannot read the current value.
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA

    def release(self) -> None:
        """Release all objects on the GPU."""
        for shader in (self._into_bins, self._into_rows, self._order, self._smoothing):
            shader.program.release()
            shader.release()
        for target in (self._bins, self._rows, self._ordered, *self._smoothed):
            target.release()


class _Target:
    """A texture of floats to draw into; restores the previous framebuffer and flags."""

    def __init__(
        self, context: moderngl.Context, size: tuple[int, int], components: int, enabled: int = 0
    ) -> None:
        self.texture = context.texture(size, components, dtype="f4")
        self.texture.filter = context.NEAREST, context.NEAREST
        self.framebuffer = context.framebuffer([self.texture])
        self._context = context
        self._enabled = enabled

    def draw(
        self,
        shader: moderngl.VertexArray,
        *sources: moderngl.Texture,
        mode: int | None = None,
        vertices: int = 3,
    ) -> None:
        """Draw with these textures in the units from 0 on; by default one triangle."""
        for unit, source in enumerate(sources):
            source.use(unit)
        # Created for each draw, as it restores the state at its creation.
        scope = self._context.scope(self.framebuffer, self._enabled)
        with scope:
            shader.render(mode, vertices)
        scope.release()

    def release(self) -> None:
        self.framebuffer.release()
        self.texture.release()


def _shader(context: moderngl.Context, vertex: str, fragment: str, **uniforms: float) -> moderngl.VertexArray:
    program = context.program(read_source(vertex), read_source(f"measure/{fragment}.glsl"))
    for name, value in uniforms.items():
        program[name] = value
    return context.vertex_array(program, [])
