"""Plans the GPU passes of a style for pictures of one layout, without calling OpenGL."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.errors import StyleError
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.passes import Pass, Result, partition
from vidstyle.gpu.compile.shader_graph import ShaderGraph
from vidstyle.gpu.compile.shader_nodes import Function, ShaderNode, ShaderPercentileRequest
from vidstyle.style import Style
from vidstyle.style.lower import Steps, lower
from vidstyle.style.nodes import LoweredStyle, ScaledSize, Shape, nodes_in_order
from vidstyle.style.resolve import resolve


@dataclass(frozen=True)
class Plan:
    """The passes that restyle pictures of one layout.

    Attributes:
        source: layout of the pictures.
        target: encoding of the planes of the result.
        rgb: whether the result is packed RGB.
        form: form of all passes.
        passes: the passes, in the order of execution.
        luma: whether luma is "made" by the passes or is the source's own plane, "untouched".
        chroma: the same, or "gray" without chroma.
        sizes: see `LoweredStyle`.
    """

    source: PictureLayout
    target: Encoding
    rgb: bool
    form: Form
    passes: tuple[Pass, ...]
    luma: Literal["made", "untouched"]
    chroma: Literal["made", "untouched", "gray"]
    sizes: Mapping[Shape, ScaledSize]

    def fits(self, source: PictureLayout, target: Encoding, rgb: bool) -> bool:
        """Whether the plan is valid for these arguments."""
        return (self.source, self.target, self.rgb) == (source, target, rgb)

    @property
    def measures(self) -> list[ShaderPercentileRequest]:
        """The measurements for each picture."""
        return [each.sampled for each in self.passes if each.sampled]

    @property
    def planes(self) -> list[ShaderNode]:
        """The planes of the source to upload."""
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
    """Plan the passes of a style.

    Args:
        style: the style, for its ink and paper.
        steps: the steps of the style, resolved for the size of the source.
        source: layout of the pictures.
        target: encoding of the planes of the result.
        rgb: whether to produce packed RGB of the target's depth instead.
        form: form of the passes.
        fused: False to make every call a separate pass, for comparison.

    Raises:
        StyleError: the style takes too much time or memory, or needs the CPU.
    """
    lowered = lower(style, steps, source, target, rgb)
    if any(node.op == "network" for node in nodes_in_order(lowered.outputs)):
        raise StyleError(style.name, ["network: runs on the CPU only; an exported style cannot have one"])
    graph = ShaderGraph(form)
    graph.add(lowered.outputs)
    results = _results(lowered, graph, form)
    return Plan(
        source,
        target,
        rgb,
        form,
        tuple(partition(results, fused)),
        "untouched" if lowered.luma_untouched else "made",
        "untouched" if lowered.chroma_untouched else "made" if rgb or lowered.chroma else "gray",
        lowered.sizes,
    )


def plan_for_video(style: Style, width: int, height: int, form: Form) -> Plan:
    """Plan a style for common video, 8-bit 4:2:0; in the form "es" for RGB, as decoded by a browser.

    Raises:
        StyleError: an asset of the style cannot be read.
    """
    if form == "es":
        return plan_for_rgb(style, width, height, 8)
    source = PictureLayout(Encoding(), (height, width), "chroma")
    return make_plan(style, resolve(style, height, width), source, source.encoding, False, form)


def plan_for_rgb(style: Style, width: int, height: int, depth: int) -> Plan:
    """Plan a style in the form "es" for RGB of this many bits as input and output; 0 for floats.

    Raises:
        StyleError: an asset of the style cannot be read.
    """
    source = PictureLayout(
        Encoding(full_range=True, depth=depth, subsampling=(1, 1)), (height, width), "color"
    )
    return make_plan(style, resolve(style, height, width), source, source.encoding, True, "es")


def _results(lowered: LoweredStyle, graph: ShaderGraph, form: Form) -> list[Result]:
    """Return the values that are written together.

    A compute pass averages chroma to the target's grid, as its invocations share values. Fragments do not
    share values, so that averaging is a separate pass.
    """
    shape, target = lowered.source.shape, lowered.target
    if lowered.color is not None:
        return [Result("color", (graph[lowered.color],), shape)]
    assert lowered.luma is not None
    luma = () if lowered.luma_untouched else (graph[lowered.luma],)
    alone = [Result("planes", luma, shape)] if luma else []
    node = lowered.chroma
    if node is None or lowered.chroma_untouched:
        return alone
    small = target.chroma_shape(*shape)
    chroma = graph.recoded(node) if node.op == "plane" and node.grid != target else graph[node]
    if target.subsampling == (1, 1):
        return [Result("planes", (*luma, chroma), shape)]
    if chroma.grid is not None:
        return [*alone, Result("chroma", (chroma,), small)]
    if form == "compute" and luma:
        return [Result("planes", (*luma, chroma), shape)]
    function = Function("frame/shrunk_chroma.glsl", "shrunk_chroma", 2)
    values = {"step": target.subsampling, "siting": target.siting}
    shrunk = ShaderNode("chroma", small, function, around=chroma, values=values)
    return [*alone, Result("chroma", (shrunk,), small)]
