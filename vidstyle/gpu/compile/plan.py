"""A style as GPU passes for pictures of one layout: pure Python, no GL."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import Encoding
from vidstyle.gpu.compile.builder import GraphBuilder, ImageValue
from vidstyle.gpu.compile.nodes import Function, Measure, Node, PictureLayout, Shape
from vidstyle.gpu.compile.passes import Pass, Result, cut
from vidstyle.style import Style
from vidstyle.style.resolve import ResolvedStep

Form = Literal["compute", "fragment"]
"""How a pass runs: as a compute shader (OpenGL 4.3) or as a fragment shader (3.3)."""

Steps = Mapping[str, tuple[ResolvedStep, ...]]
"""The prepared steps of each layer."""


@dataclass(frozen=True)
class Plan:
    """What the GPU does for each picture of one layout.

    Attributes:
        source: what comes in.
        target: how the planes of the result are encoded.
        rgb: whether the result is packed RGB.
        form: of all its passes.
        passes: in the order in which they run.
        luma: whether luma is "made" by the passes or is the source's own plane, "untouched".
        chroma: the same, or "gray" where there is none.
    """

    source: PictureLayout
    target: Encoding
    rgb: bool
    form: Form
    passes: tuple[Pass, ...]
    luma: Literal["made", "untouched"]
    chroma: Literal["made", "untouched", "gray"]

    def fits(self, source: PictureLayout, target: Encoding, rgb: bool) -> bool:
        """Whether it is for such pictures and such results."""
        return (self.source, self.target, self.rgb) == (source, target, rgb)

    @property
    def measures(self) -> list[Measure]:
        """What has to be measured of each picture."""
        return [each.sampled for each in self.passes if each.sampled]

    @property
    def planes(self) -> list[Node]:
        """The planes of the source that have to be on the GPU."""
        images = (image for each in self.passes for image in each.images)
        return list(dict.fromkeys(image for image in images if image.is_plane))


def make_plan(
    style: Style,
    steps: Steps,
    source: PictureLayout,
    target: Encoding,
    rgb: bool,
    form: Form,
    fused: bool = True,
) -> Plan:
    """The plan of a style.

    Args:
        style: for its ink and paper.
        steps: the style's, prepared for pictures of the source's size.
        source: what comes in.
        target: how the planes of the result are encoded.
        rgb: whether packed RGB of the target's depth is wanted instead.
        form: how the passes are to run.
        fused: False makes a pass of every call, to compare with.
    """
    graph = GraphBuilder(source, form)
    look = _page(graph, style, steps)
    if rgb:
        results = [Result("color", (graph.color(look),), source.shape)]
        return Plan(source, target, rgb, form, tuple(cut(results, fused)), "made", "made")
    look = graph.in_matrix(look, target.matrix)
    same = source.encoding == target
    luma = graph.luma(look)
    chroma = graph.chroma_on_grid(look, target) or graph.chroma(look)
    luma_untouched = same and luma is graph.planes.luma
    chroma_untouched = same and look.chroma is not None and look.chroma is graph.planes.chroma
    results = _results(
        None if luma_untouched else luma, None if chroma_untouched else chroma, source.shape, target, form
    )
    return Plan(
        source,
        target,
        rgb,
        form,
        tuple(cut(results, fused)),
        "untouched" if luma_untouched else "made",
        "untouched" if chroma_untouched else "made" if chroma else "gray",
    )


def _page(graph: GraphBuilder, style: Style, steps: Steps) -> ImageValue:
    """base, then background and lines from where it ended, and one laid over the other."""
    base = graph.run_layer("base", steps["base"], graph.planes)
    background = lines = None
    if steps["background"] or not steps["lines"]:
        background = graph.run_layer("background", steps["background"], base)
        background = graph.at_size(background, graph.source.shape, background.back)
    if steps["lines"]:
        lines = graph.run_layer("lines", steps["lines"], base)
        lines = graph.at_size(lines, graph.source.shape, lines.back)
    return _with_lines(graph, style, _on_paper(graph, style, background), lines)


def _on_paper(graph: GraphBuilder, style: Style, background: ImageValue | None) -> ImageValue:
    """The background printed on the paper, or the paper alone."""
    paper = rgb_from_text(style.paper)
    if background is None:
        level, *tint = graph.encoding.yuv_from_color(paper)
        chroma = graph.call("chroma", "plain_chroma", {}, tint=tuple(tint)) if any(tint) else None
        return ImageValue(graph.call("luma", "plain_luma", {}, level=level), chroma)
    if paper == (1.0, 1.0, 1.0):
        return background
    return ImageValue(color=graph.call("color", "on_paper", {"color": graph.color(background)}, paper=paper))


def _with_lines(graph: GraphBuilder, style: Style, under: ImageValue, lines: ImageValue | None) -> ImageValue:
    """Ink where the lines are dark; mixing is linear, so luma and chroma serve, which come next."""
    if lines is None:
        return under
    level, *tint = graph.encoding.yuv_from_color(rgb_from_text(style.ink))
    cover = graph.luma(lines)
    luma = graph.call("luma", "inked_luma", {"under": graph.luma(under), "lines": cover}, ink=level)
    chroma = graph.chroma(under)
    if chroma is None and any(tint):
        chroma = graph.call("chroma", "plain_chroma", {}, tint=(0.0, 0.0))
    if chroma is not None:
        chroma = graph.call("chroma", "inked_chroma", {"under": chroma, "lines": cover}, ink=tuple(tint))
    return ImageValue(luma, chroma)


def _results(
    luma: Node | None, chroma: Node | None, shape: Shape, target: Encoding, form: Form
) -> list[Result]:
    """What leaves together.

    A compute pass averages chroma to the target's grid by itself, because its invocations see what their
    neighbours have computed; fragments do not, so the average is a pass of its own.
    """
    if chroma is None:
        return [Result("planes", (luma,), shape)] if luma else []
    small = target.chroma_shape(*shape)
    if target.step == (1, 1):
        return [Result("planes", (luma, chroma) if luma else (chroma,), shape)]
    if chroma.grid is not None:
        return [*([Result("planes", (luma,), shape)] if luma else []), Result("chroma", (chroma,), small)]
    if form == "compute" and luma is not None:
        return [Result("planes", (luma, chroma), shape)]
    function = Function("frame/shrunk_chroma.glsl", "shrunk_chroma", 2)
    values = {"step": target.step, "siting": target.siting}
    shrunk = Node("chroma", small, function, around=chroma, values=values)
    return [*([Result("planes", (luma,), shape)] if luma else []), Result("chroma", (shrunk,), small)]
