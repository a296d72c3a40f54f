"""From the steps of a style to the graph of what is computed at every pixel.

It takes the same decisions as the CPU's `Band` and `Work`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from vidstyle.blade.features import window_reach
from vidstyle.blade.run import BankRun
from vidstyle.block import Block, Choice, LumaWeights, Saved
from vidstyle.gpu.learned import choice_values, filter_values
from vidstyle.gpu.looks import Look, Looks
from vidstyle.gpu.nodes import CHANNELS, Function, Layout, Measure, Node
from vidstyle.gpu.signature import functions_of_block
from vidstyle.style import SOURCE
from vidstyle.style.resolve import PreparedStep


class Graph(Looks):
    """Follows the steps of a style.

    Attributes:
        measures: all that the steps want to know of the whole picture, in the order of the steps.
    """

    def __init__(self, source: Layout, form: str) -> None:
        super().__init__(source)
        self._form = form
        self.measures: list[Measure] = []
        self._saved = {SOURCE: self.planes}

    def run_layer(self, layer: str, steps: tuple[PreparedStep, ...], look: Look) -> Look:
        """The picture after all steps of a layer."""
        for number, step in enumerate(steps):
            look = self._saved[step.source] if step.source else look
            if step.block is not None:
                look = self._run_step(step, step.block, look, (layer, number))
            if step.save:
                self._saved[step.save] = look
        return look

    def _run_step(self, step: PreparedStep, block: Block, look: Look, number: tuple[str, int]) -> Look:
        if block.saves:
            self._saved[block.saves] = look
        if block.kind == "resize":
            size = block.function(look.shape, **step.values)
            return replace(self.at_size(look, size, step.values["method"]), back=step.values["back"])
        if block.kind == "learned":
            return self._run_learned(block, block.function(**step.values), look)
        measure = None
        if block.kind == "measured":
            percentages = block.percentages(step.values)
            measure = Measure(self.luma(look), percentages, step.values.get("settle", 0.0), number)
            self.measures.append(measure)
        pictures = {
            name: self.at_size(self._saved[saved], look.shape, "bilinear")
            for name, saved in step.pictures.items()
        }
        return self._run_block(step, block, look, pictures, measure)

    def _run_learned(self, block: Block, run: BankRun, look: Look) -> Look:
        chroma = self.chroma(look) if look.color is not None else look.chroma
        luma = self.luma(look)
        if run.scale != 1:
            luma = self.resized(luma, run.shape_at_scale(luma.shape), "area")
            # Exact: a filter chosen otherwise for one of few pixels would show in many.
            luma = self.node(replace(luma, is_wide=True))
        luma = self.resized(self._filtered(luma, run), look.shape, "bicubic")
        return Look(luma, None if block.chroma == "dropped" else chroma, back=look.back)

    def _filtered(self, luma: Node, run: BankRun) -> Node:
        """Luma after all passes of a bank."""
        chosen: Node | None = None
        for _ in range(run.passes):
            if chosen is None or run.reselect:
                chosen = self._chosen(luma, run)
            filters = Function("blade/filtered.glsl", "filtered")
            luma = self.node(
                Node(
                    "luma",
                    luma.shape,
                    filters,
                    {"chosen": chosen},
                    around=luma,
                    reach=run.bank.size // 2,
                    values=filter_values(run),
                    is_wide=run.is_wide,
                )
            )
        return luma

    def _chosen(self, luma: Node, run: BankRun) -> Node:
        """The number of each pixel's filter.

        A compute group shares what it reads; fragments do not, so there one chooses for 2 x 2 pixels, in a
        pass of its own.
        """
        reach, values = window_reach(run.window), choice_values(run)
        if self._form == "compute":
            function = Function("blade/chosen_filter.glsl", "chosen_filter")
            return self.node(Node("luma", luma.shape, function, around=luma, reach=reach, values=values))
        height, width = luma.shape
        half = (height + 1) // 2, (width + 1) // 2
        function = Function("blade/chosen_filters.glsl", "chosen_filters")
        four = self.node(Node("choices", half, function, around=luma, reach=reach, values=values))
        return self.node(
            Node("luma", luma.shape, Function("blade/own_choice.glsl", "IMAGE_own_choice"), around=four)
        )

    def _run_block(
        self,
        step: PreparedStep,
        block: Block,
        look: Look,
        pictures: dict[str, Look],
        measure: Measure | None,
    ) -> Look:
        if step.on == "color" or (step.on == "channels" and not look.is_gray):
            inputs = self._inputs(block, pictures, color=True)
            color = self._call_block(step, block, self.color(look), inputs, measure)
            return Look(color=color, back=look.back)
        inputs = self._inputs(block, pictures, color=False)
        luma = self._call_block(step, block, self.luma(look), inputs, measure)
        chroma = None if block.chroma == "dropped" else look.chroma
        if look.color is not None and block.chroma == "kept":
            chroma = self.chroma(look)
        for name, picture in pictures.items():
            if _wants(block, name) == "chroma":
                chroma = self.chroma(picture) if picture.color is not None else picture.chroma
        return Look(luma, chroma, back=look.back)

    def _inputs(self, block: Block, pictures: dict[str, Look], color: bool) -> dict[str, Node]:
        wanted = {name: look for name, look in pictures.items() if _wants(block, name) != "chroma"}
        return {
            name: self.color(look) if color and _wants(block, name) == "same" else self.luma(look)
            for name, look in wanted.items()
        }

    def _call_block(
        self,
        step: PreparedStep,
        block: Block,
        picture: Node,
        inputs: dict[str, Node],
        measure: Measure | None,
    ) -> Node:
        values, options = _numbered(block, step.values)
        values |= {name: self.encoding.weights for name, kind in block.given.items() if kind is LumaWeights}
        for signature in functions_of_block(block.name):
            if signature.is_identity:  # to_gray and to_color do all they do by choosing the chroma
                continue
            function = Function(signature.file, signature.name, CHANNELS[picture.kind])
            node = Node(
                picture.kind, picture.shape, function, dict(inputs), None, 0, values, options, measure
            )
            if block.kind == "filter":
                picture = replace(node, around=picture, reach=block.rows_around(step.values))
            else:
                picture = replace(node, inputs={signature.parameters[0].name: picture, **inputs})
            picture = self.node(picture)
        return picture


def _numbered(block: Block, values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, tuple[str, ...]]]:
    """The values with the number of each chosen word in its place, and the words."""
    controls = {name: block.parameters[name].control for name in values}
    options = {name: control.options for name, control in controls.items() if isinstance(control, Choice)}
    numbered = {
        name: options[name].index(value) if name in options else value for name, value in values.items()
    }
    return numbered, options


def _wants(block: Block, name: str) -> str:
    control = block.parameters[name].control
    assert isinstance(control, Saved)
    return control.on
