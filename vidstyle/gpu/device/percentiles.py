"""Percentiles measured and remembered on the GPU, so that no frame waits for numbers to come back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vidstyle.assets import asset_folder

if TYPE_CHECKING:
    import moderngl

_BINS = 256
"""The histogram has as many rows and columns: one bin for each 16-bit value."""


class Percentiles:
    """The percentiles that one step measures; whoever calls it owns the context.

    An exact histogram: each sample is drawn as a point on its bin and blending counts them, which
    OpenGL 3.3 can, and floats count exactly up to 16 million. Then a pass sums the rows of bins, another
    finds the samples next to each percentile, the last interpolates and smooths over time.

    Args:
        low, span: the samples' values lie from low to low + span.
    """

    def __init__(self, context: moderngl.Context, low: float, span: float) -> None:
        self._context = context
        self._bins = _Target(context, (_BINS, _BINS), 1, context.BLEND)
        self._rows = _Target(context, (_BINS, 1), 1)
        self._ordered = _Target(context, (4, 2), 1)
        self._numbers = [_Target(context, (1, 1), 4) for _ in range(2)]
        self._into_bins = _shader(context, "bin_vertex", "bin_fragment")
        self._into_rows = _shader(context, "whole_vertex", "row_fragment")
        self._order = _shader(context, "whole_vertex", "order_fragment", bins=0, rows=1)
        self._smooth = _shader(
            context, "whole_vertex", "smooth_fragment", ordered=0, remembered=1, low=low, span=span
        )
        self._fresh = True

    def follow(
        self, samples: moderngl.Texture, size: tuple[int, int], percentages: Sequence[float], weight: float
    ) -> moderngl.Texture:
        """The remembered numbers, moved towards the percentiles of these samples.

        Percentiles between two samples are interpolated as by `numpy.percentile`.

        Args:
            samples: one component, 16-bit normalized; 0 is `low` and 1 is `low + span`.
            size: width and height of the part that counts, from the first row and column; together no
                more than 2^24 samples.
            percentages: one to four, 0 to 100.
            weight: how far to move, 0 to 1; the first time they are taken as they are.

        Returns:
            A 1 x 1 texture of four floats, the last percentile repeated where there are fewer; good
            until the next but one call.
        """
        places = [percentage / 100 * (size[0] * size[1] - 1) for percentage in percentages]
        places += places[-1:] * (4 - len(places))
        # Split here, in double precision: between black and white a fraction must be good to 2^-16.
        self._order.program["ranks"] = tuple(float(int(place)) for place in places)
        self._smooth.program["fractions"] = tuple(place % 1 for place in places)
        self._smooth.program["weight"] = 1.0 if self._fresh else weight
        self._fresh = False
        self._count(samples, size)
        self._rows.draw(self._into_rows, self._bins.texture)
        self._ordered.draw(self._order, self._bins.texture, self._rows.texture)
        self._numbers.reverse()
        now, before = self._numbers
        now.draw(self._smooth, self._ordered.texture, before.texture)
        return now.texture

    def _count(self, samples: moderngl.Texture, size: tuple[int, int]) -> None:
        context = self._context
        self._bins.framebuffer.clear()
        self._into_bins.program["width"] = size[0]
        context.blend_func = context.ONE, context.ONE
        self._bins.draw(self._into_bins, samples, mode=context.POINTS, vertices=size[0] * size[1])
        # The function that a context begins with; moderngl does not tell which one is set.
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA

    def release(self) -> None:
        """Let go of all that it holds on the GPU."""
        for shader in (self._into_bins, self._into_rows, self._order, self._smooth):
            shader.program.release()
            shader.release()
        for target in (self._bins, self._rows, self._ordered, *self._numbers):
            target.release()


class _Target:
    """A texture of floats to draw into, and with what enabled; what was in use before is so again after."""

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
        """Draw with these textures in the units from 0 on; one triangle if nothing else is said."""
        for unit, source in enumerate(sources):
            source.use(unit)
        # Made each time, as it remembers what was in use when it was made.
        scope = self._context.scope(self.framebuffer, self._enabled)
        with scope:
            shader.render(mode, vertices)
        scope.release()

    def release(self) -> None:
        self.framebuffer.release()
        self.texture.release()


def _shader(context: moderngl.Context, vertex: str, fragment: str, **uniforms: float) -> moderngl.VertexArray:
    folder = asset_folder("shaders") / "measure"
    vertex_text, fragment_text = ((folder / f"{name}.glsl").read_text("utf-8") for name in (vertex, fragment))
    program = context.program(vertex_text, fragment_text)
    for name, value in uniforms.items():
        program[name] = value
    return context.vertex_array(program, [])
