"""A plan for WebGL 2 as plain data, which `vidstyle/export/runner` runs without Python.

- `format`: the version of this description.
- `size`: width and height of the picture; the plan fits all pictures with a shorter side of the same length.
- `samples`: the maximum samples across and down of a measurement.
- `vertex`, `shaders`: the text of the vertex shader of all passes, and the texts of the fragment shaders.
- `pages`: for each size of passes, the number of the size that it is derived from; the first is the
  picture's. `borders`: the pixels that are then added on every side.
- `images`: the textures that passes write: `page`, `kind` ("working", "samples" or "result"), `components`.
- `passes`: in order: `shader`, `page`, `writes` (images), `reads` and `sizes` by uniform, `uniforms`; and
  `measures` if its output is measured.
- `measures`: for each measurement its step and the number of its percentiles.
- `values`: all numbers: factors of all pages except the first; uniforms, pass by pass; for each measurement
  its time constant in seconds and its percentages.
- `textures`: the assets by name: width, height and layers, `components`, `type` ("half" or "float"), base64;
  and `film` if the film's colours replace it, with the constants of `core.film_colors`.
- `server`: features of the style that this form cannot run, "steady" and "masks"; the
  masks are replaced by `fixed_mask_level`.

A plan is a structure and numbers, its `values`. Moving a slider only changes numbers, unless it changes the
passes: `EsPlan.key` answers whether two plans differ only in numbers.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vidstyle.core.sampling import MAX_SIDE_SAMPLES
from vidstyle.gpu.compile.asset_texture import AssetTexture, asset_texture
from vidstyle.gpu.compile.glsl import TRIANGLE_SHADER, Form, read_source
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan, plan_for_rgb
from vidstyle.gpu.compile.shader import DRIFT, ImageOf, SamplerInput, Shader
from vidstyle.gpu.compile.shader_nodes import Format, ShaderNode, ShaderPercentileRequest
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import Slots, TexturePool
from vidstyle.gpu.compile.tiles import jobs_of
from vidstyle.style import Style
from vidstyle.style.nodes import PercentileRequest, ScaledSize, Shape
from vidstyle.style.resolve import masks_read

FORMAT_VERSION = 1
COMPONENT_COUNTS = {"bool": 1, "int": 1, "float": 1, "ivec2": 2, "vec2": 2, "vec3": 3, "vec4": 4, "mat3": 9}
"""Number of components of each type of uniform."""

_SIZE_UNIFORM = re.compile(r"(page|old_size|new_size)_\d+")
"""Uniforms for the size of a picture, which the runner sets."""
_MAX_UNTILED_SIDE = 2**31


def es_plan(style: Style, width: int, height: int, depth: int = 8) -> dict[str, Any]:
    """Return the plan of a style as plain data; see `EsPlan.of`."""
    return EsPlan.of(style, width, height, depth).data


def vertex_shader(form: Form) -> str:
    """Return the vertex shader of fragment passes."""
    text = read_source(TRIANGLE_SHADER)
    return text.replace("#version 330", "#version 300 es") if form == "es" else text


@dataclass(eq=False)
class _Image:
    """A texture that passes write; `number`: its index in the description."""

    height: int
    width: int
    format: Format
    number: int


class EsPlan:
    """A plan in the form "es": a structure, and numbers.

    Args:
        plan: its passes.
        left: features of the style that this form cannot run.

    Attributes:
        values: all numbers.
    """

    @classmethod
    def of(cls, style: Style, width: int, height: int, depth: int = 8) -> EsPlan:
        """Return the plan of a style for pictures of this size.

        Args:
            depth: bits of a sample of the picture and the result; 0 for floats.

        Raises:
            StyleError: an asset of the style cannot be read, or the style exceeds a limit.
        """
        left = {"steady": style.steady, "masks": masks_read(style)}
        return cls(plan_for_rgb(style, width, height, depth), [name for name, used in left.items() if used])

    def __init__(self, plan: Plan, left: list[str]) -> None:
        self._plan = plan
        self._shaders = {each: write_shader(plan, each) for each in plan.passes}
        self._texts = {shader.text.digest: shader.text for shader in self._shaders.values()}
        self._images: list[_Image] = []
        self._slots = Slots(
            TexturePool(self._new_image), plan, jobs_of(plan, _MAX_UNTILED_SIDE), self._shaders
        )
        self._results: list[Any] = [
            self._slots.texture(each, number)
            for each, shader in self._shaders.items()
            for number, target in enumerate(shader.targets)
            if target.is_plane
        ]
        self._textures: dict[str, AssetTexture] = {}
        # A size of one pixel is its own half.
        self._sizes: dict[Shape, ScaledSize] = self._sizes_of_choices() | dict(plan.sizes)
        self._pages: dict[Shape, int] = {plan.source.shape: 0}
        self._factors: list[float] = []
        self._parents, self._borders = [0], [0]
        passes = [self._pass(each, shader) for each, shader in self._shaders.items()]
        images = [self._image(image) for image in self._images]
        self._structure: dict[str, Any] = {
            "format": FORMAT_VERSION,
            "size": list(plan.source.shape[::-1]),
            "samples": MAX_SIDE_SAMPLES,
            "pages": self._parents,
            "borders": self._borders,
            "images": images,
            "passes": passes,
            "measures": [
                {"step": f"{each.step[0]} {each.step[1]}", "count": len(each.percentages)}
                for each in plan.measures
            ],
            "server": left,
        }
        self.values = [_short(number) for number in self._values()]

    @cached_property
    def key(self) -> str:
        """A text that is the same for all plans that differ only in `values`."""
        text = json.dumps([self._structure, list(self._texts), list(self._textures)])
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    @cached_property
    def data(self) -> dict[str, Any]:
        """The plan as plain data, with the texts of shaders and the contents of textures."""
        return self._structure | {
            "vertex": vertex_shader(self._plan.form),
            "shaders": [text.assembly.text for text in self._texts.values()],
            "values": self.values,
            "textures": {name: texture.data for name, texture in self._textures.items()},
        }

    def _new_image(self, shape: Shape, coding: Format) -> Any:
        self._images.append(_Image(*shape, coding, len(self._images)))
        return self._images[-1]

    def _sizes_of_choices(self) -> dict[Shape, ScaledSize]:
        nodes = (node for each in self._plan.passes for node in each.nodes if node.kind == "choices")
        return {node.shape: ScaledSize(node.around.shape, 0.5) for node in nodes if node.around is not None}

    def _page(self, shape: Shape) -> int:
        """Return the number of a size."""
        if shape not in self._pages:
            made_of, factor, border = self._sizes[shape]
            parent = self._page(made_of)
            self._pages[shape] = len(self._parents)
            self._parents.append(parent)
            self._borders.append(border)
            self._factors.append(factor)
        return self._pages[shape]

    def _pass(self, each: Pass, shader: Shader) -> dict[str, Any]:
        writes: list[Any] = [self._slots.texture(each, number) for number in range(len(shader.targets))]
        sizes = {name: value for name, value in shader.uniforms.items() if _SIZE_UNIFORM.fullmatch(name)}
        found = {
            "shader": list(self._texts).index(shader.text.digest),
            "page": self._page(each.shape),
            "writes": [image.number for image in writes],
            "reads": {name: self._read(what) for name, what in shader.samplers.items()},
            "sizes": {name: self._page((size[1], size[0])) for name, size in sizes.items()},
            "uniforms": [[name, *shader.text.types[name]] for name in shader.uniforms if name not in sizes],
        }
        return found | ({"measures": self._plan.measures.index(each.sampled)} if each.sampled else {})

    def _read(self, what: SamplerInput) -> dict[str, Any]:
        if isinstance(what, PercentileRequest):
            return {"measure": self._plan.measures.index(what)}
        assert what != DRIFT  # no shader of this form reads it
        if not isinstance(what, ImageOf):
            return {"texture": self._texture(what)}
        nodes: dict[ShaderNode, Any] = self._slots.nodes
        return {"source": True} if what.node.is_plane else {"image": nodes[what.node].number}

    def _texture(self, arrays: tuple[np.ndarray, ...]) -> str:
        texture = asset_texture(arrays)
        self._textures[texture.name] = texture
        return texture.name

    def _image(self, image: _Image) -> dict[str, Any]:
        samples = {texture: measure.of.shape for measure, texture in self._sampled().items()}
        shape = samples.get(image, (image.height, image.width))
        kind = "samples" if image in samples else "result" if image in self._results else "working"
        return {"page": self._page(shape), "kind": kind, "components": image.format.components}

    def _sampled(self) -> dict[ShaderPercentileRequest, Any]:
        return dict(self._slots.samples)

    def _values(self) -> Iterator[float]:
        yield from self._factors
        for shader in self._shaders.values():
            for name, value in shader.uniforms.items():
                if not _SIZE_UNIFORM.fullmatch(name):
                    yield from numbers_of(value)
        for measure in self._plan.measures:
            yield from (measure.time_constant, *measure.percentages)


def numbers_of(value: Any) -> list[float]:
    """Return the numbers of a uniform in the order of GLSL, matrices column by column."""
    if isinstance(value, np.ndarray) and value.ndim == 2:
        value = value.T
    return [float(number) for number in np.asarray(value, np.float64).ravel()]


def _short(number: float) -> float | int:
    """Round a number to the fewest digits that identify it as float32."""
    short = float(f"{number:.9g}")
    return int(short) if short.is_integer() and abs(short) < 2**31 else short
