"""Export of a style as a .hook file for mpv, FFmpeg and other libplacebo players.

Each pass of a plan becomes a pass of the file, with its numbers as constants. The format has limits: a pass
has one output, so passes with several outputs are repeated; saved textures may be half floats; texture arrays
become 3D textures; and measurements of the picture are frozen.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import vidstyle
from vidstyle.blocks import all_blocks
from vidstyle.errors import counted
from vidstyle.export.adjust import MakePlan
from vidstyle.gpu.compile.es import COMPONENT_COUNTS, EsPlan
from vidstyle.style import Style

HEIGHT_PROBE_FACTOR = 1.02
"""Factor of the style height by which its effect is probed; small, so that the passes stay the same."""

FRAME_MS = 40
"""Assumed frame duration. libplacebo provides no time, only the number of hook passes so far."""

Factors = list[tuple[float, int]]
"""The factor of each pass size except the first, and the power of the height by which it scales."""
Frozen = Mapping[str, tuple[float, ...]]
"""The percentiles of each measured step, by its name in a plan."""

_UNIFORM_LINE = re.compile(r"^uniform (?P<type>\w+) (?P<names>[^;]+);$")
_STORE_FUNCTION = re.compile(r"^void store_(?P<number>\d+)\(ivec2 place, vec4 value\)")
_VALUE_CALL = re.compile(r"value_(?P<number>\d+) = (?:clamp\()?(?P<function>\w+)\(")
_MEASURED_FETCH = re.compile(r"texelFetch\((?P<name>measured_\d+), ivec2\(0\), 0\)")

_HOOK_HEAD = """\
// {name}: a style of vidstyle {version}, made for pictures of {width} x {height}.
// {note}
//
// mpv (vo=gpu-next):  mpv --vo=gpu-next --glsl-shader={name}.hook FILM
// FFmpeg:  ffmpeg -init_hw_device vulkan -i FILM -vf "format=rgba,hwupload,
//   libplacebo=dithering=none:custom_shader_path={name}.hook,hwdownload,format=rgba,format=yuv420p" OUT.mp4
//
{left_out}
"""


def height_powers(plan: EsPlan, make: MakePlan, style: Style) -> list[int]:
    """Return for each value of a plan the power of the picture height by which it scales.

    It is 1 for lengths, -1 for the working size of a bank that depends on a length, else 0.

    Args:
        make: makes a plan of another style for the same picture size.
    """
    if style.height is None:
        return [0] * len(plan.values)
    other = make(replace(style, height=style.height * HEIGHT_PROBE_FACTOR))
    if other.key != plan.key:
        return [0] * len(plan.values)
    now, then = (np.array(each.values, float) for each in (plan, other))
    grows, shrinks = (
        np.isclose(then * HEIGHT_PROBE_FACTOR**power, now, rtol=1e-4, atol=0) for power in (1, -1)
    )
    changed = ~np.isclose(then, now, rtol=1e-6, atol=0)
    return [int(number) for number in np.where(changed & grows, 1, np.where(changed & shrinks, -1, 0))]


def hook_of(style: Style, plan: dict[str, Any], powers: list[int], frozen: Frozen, measured_from: str) -> str:
    """The text of a .hook file.

    Args:
        plan: the plan of the style for float RGB input.
        powers: from `height_powers`.
        frozen: the percentiles of its measured steps.
        measured_from: the source of `frozen`, for the header of the file.
    """
    passes = _passes(style, plan, powers, frozen)
    return "\n".join([_head(style, plan, measured_from), *_textures(plan), *passes])


def _head(style: Style, plan: dict[str, Any], measured_from: str) -> str:
    left = []
    count = len(plan["measures"]) + sum("film" in each for each in plan["textures"].values())
    if count:
        left.append(f"// Frozen: {counted(count, 'measurement')} of {measured_from}.")
    if "steady" in plan["server"]:
        left.append("// Not included: temporal smoothing.")
    width, height = plan["size"]
    return _HOOK_HEAD.format(
        name=style.name,
        version=vidstyle.__version__,
        width=width,
        height=height,
        note=" ".join(style.note.split()),
        left_out="\n".join(left or ["// The style is complete."]),
    )


def _textures(plan: dict[str, Any]) -> Iterator[str]:
    for name, each in plan["textures"].items():
        kind = np.float16 if each["type"] == "half" else np.float32
        numbers = np.frombuffer(base64.b64decode(each["data"]), kind).astype("<f4")
        width, height, layers = each["size"]
        yield f"//!TEXTURE {_texture(name)}\n//!SIZE {width} {height} {layers}"
        yield f"//!FORMAT {'r32f' if each['components'] == 1 else 'rgba32f'}\n//!FILTER NEAREST"
        yield numbers.tobytes().hex() + "\n"


def _texture(name: str) -> str:
    return f"VIDSTYLE_{name[:8]}"


def _saved(image: int) -> str:
    return f"VIDSTYLE_{image}"


def _passes(style: Style, plan: dict[str, Any], powers: list[int], frozen: Frozen) -> Iterator[str]:
    at, made = len(plan["pages"]) - 1, 0
    count = sum(len(each["writes"]) for each in plan["passes"] if "measures" not in each)
    factors = list(zip(plan["values"][:at], powers[:at], strict=True))
    for number, each in enumerate(plan["passes"], 1):
        values: dict[str, list[float]] = {}
        lengths: dict[str, int] = {}
        for name, kind, length in each["uniforms"]:
            end = at + COMPONENT_COUNTS[kind] * max(length, 1)
            if end == at + 1 and powers[at]:
                lengths[name] = powers[at]
            values[name], at = plan["values"][at:end], end
        if "measures" in each:
            continue
        for target, image in enumerate(each["writes"]):
            title = f"{style.name} {number} of {len(plan['passes'])}"
            yield from _directives(plan, each, image, title, factors)
            made += 1
            frame = f"(max(frame - {made}, 0) / {count})"
            yield _Source(plan, each, values, lengths, frozen, factors, frame).text(target)


def _directives(
    plan: dict[str, Any], each: dict[str, Any], image: int, title: str, factors: Factors
) -> Iterator[str]:
    yield f"//!HOOK OUTPUT\n//!DESC vidstyle {title}\n//!BIND HOOKED"
    reads = [what for what in each["reads"].values() if "image" in what or "texture" in what]
    yield from dict.fromkeys(
        f"//!BIND {_saved(what['image']) if 'image' in what else _texture(what['texture'])}" for what in reads
    )
    described = plan["images"][image]
    if described["kind"] != "result":
        yield f"//!SAVE {_saved(image)}"
        # Luma is the sum of two half floats.
        yield f"//!COMPONENTS {2 if described['components'] == 1 else 4}"
    if each["page"]:
        for name, side in (("WIDTH", "w"), ("HEIGHT", "h")):
            yield f"//!{name} {_side(side, plan, each, factors)}"


def _side(side: str, plan: dict[str, Any], each: dict[str, Any], factors: Factors) -> str:
    """Return the length of a side in reverse Polish notation, rounded; long expressions are not allowed."""
    images = [what["image"] for what in each["reads"].values() if "image" in what]
    pages = {plan["images"][image]["page"]: f"{_saved(image)}.{side}" for image in images}
    pages[0] = f"HOOKED.{side}"
    page, scaled = each["page"], ""
    while page not in pages:
        factor, power = factors[page - 1]
        shorter, length = _shorter(plan)
        grown = f" {length} * HOOKED.{shorter} /" if power else ""
        border = f" {2 * plan['borders'][page]} +" if plan["borders"][page] else ""
        page, scaled = plan["pages"][page], f" {factor:.9f} *{grown}{border}{scaled}"
    return pages[page] + scaled


def _shorter(plan: dict[str, Any]) -> tuple[str, int]:
    """Return the shorter side of the pictures of a plan, and its length."""
    width, height = plan["size"]
    return ("w", width) if width < height else ("h", height)


class _Source:
    """Converts the shader of a pass to the source of a hook."""

    def __init__(
        self, plan: dict[str, Any], each: dict[str, Any], values: dict[str, Any], lengths: dict[str, int],
        frozen: Frozen, factors: Factors, frame: str,
    ) -> None:  # fmt: skip
        self._plan, self._pass, self._values, self._frozen = plan, each, values, frozen
        self._lengths = lengths
        text = plan["shaders"][each["shader"]]
        self._functions = {match["number"]: match["function"] for match in _VALUE_CALL.finditer(text)}
        self._body = text[: text.index("#if __VERSION__ < 430")].splitlines()
        self._factors, self._frame = factors, frame

    def text(self, target: int) -> str:
        """Return the source for one of the targets."""
        lines = [line for line in self._lines(target)]
        page = self._pass["page"]
        return "\n".join([
            "vec4 vidstyle_result;",
            *self._sizes(),
            *lines,
            "vec4 hook() {",
            f"    ivec2 place = ivec2(HOOKED_pos * vec2(vidstyle_page_{page}()));",
            "    evaluate(place, place, true);",
            "    return vidstyle_result;",
            "}\n",
        ])  # fmt: skip

    def _sizes(self) -> Iterator[str]:
        """Yield functions that return the sizes of passes."""
        side, length = _shorter(self._plan)
        yield f"#define vidstyle_growth (HOOKED_size.{'x' if side == 'w' else 'y'} / {length}.0)"
        yield "ivec2 vidstyle_page_0() { return ivec2(HOOKED_size + 0.5); }"
        sizes = zip(self._plan["pages"][1:], self._plan["borders"][1:], self._factors, strict=True)
        for page, (made_of, border, (factor, power)) in enumerate(sizes, 1):
            growth = " / vidstyle_growth" if power else ""
            scaled = f"vec2(vidstyle_page_{made_of}()) * {factor:.9f}{growth} + 0.5"
            added = f" + {2 * border}" if border else ""
            yield f"ivec2 vidstyle_page_{page}() {{ return max(ivec2({scaled}), 1){added}; }}"

    def _lines(self, target: int) -> Iterator[str]:
        for line in self._body:
            if line.startswith(("#version", "precision ", "layout(location")):
                continue
            if match := _STORE_FUNCTION.match(line):
                body = "vidstyle_result = value; " if int(match["number"]) == target else ""
                line = f"{match[0]} {{ {body}}}"
            elif match := _UNIFORM_LINE.match(line):
                yield from self._declared(match["type"], match["names"])
                continue
            line = _MEASURED_FETCH.sub(lambda found: self._measured(found["name"]), line)
            # textureGather reads one component, but luma has two here.
            line = line.replace("#ifdef GL_ARB_texture_gather", "#if 0")
            yield line.replace("sampler2DArray", "sampler3D")

    def _declared(self, kind: str, names: str) -> Iterator[str]:
        """Yield the declaration that replaces a uniform."""
        first = names.split("[")[0]
        if names == "halved":
            yield "const bool halved = true;"
        elif names == "moment":
            # A macro would also replace parameters of this name.
            yield f"uint moment = uint{self._frame} * {FRAME_MS}u;"
        elif names.startswith("origin,"):
            yield "const ivec2 origin = ivec2(0), stride = ivec2(1);"
        elif names.endswith("_last"):
            image = names.partition("_origin")[0]
            what = self._pass["reads"][image]
            page = self._plan["images"][what["image"]]["page"] if "image" in what else 0
            yield f"#define {image}_origin ivec2(0)\n#define {image}_last (vidstyle_page_{page}() - 1)"
        elif kind.startswith("sampler"):
            if "measure" not in (what := self._pass["reads"][names]):
                yield f"#define {names} {self._sampler(what)}"
        elif first in self._pass["sizes"]:
            yield f"#define {first} vidstyle_page_{self._pass['sizes'][first]}()"
        elif first in self._lengths:
            yield f"#define {first} {self._length(first)} {self._comment(first)}"
        else:
            yield f"const {kind} {names} = {self._literal(first)}; {self._comment(first)}"

    def _sampler(self, what: dict[str, Any]) -> str:
        if "texture" in what:
            return _texture(what["texture"])
        return f"{_saved(what['image'])}_raw" if "image" in what else "HOOKED_raw"

    def _measured(self, name: str) -> str:
        which = self._plan["measures"][self._pass["reads"][name]["measure"]]
        numbers = list(self._frozen[which["step"]])
        numbers += numbers[-1:] * (4 - len(numbers))
        return f"vec4({', '.join(_float(number) for number in numbers)})"

    def _literal(self, name: str) -> str:
        kind, length = next((kind, length) for each, kind, length in self._pass["uniforms"] if each == name)
        numbers, size = self._values[name], COMPONENT_COUNTS[kind]
        parts = [_constant(kind, numbers[start : start + size]) for start in range(0, len(numbers), size)]
        return f"{kind}[{length}]({', '.join(parts)})" if length else parts[0]

    def _length(self, name: str) -> str:
        """Return a value that scales with the picture as in `vidstyle.style.resolve`."""
        grown = f"{self._literal(name)} {'*' if self._lengths[name] == 1 else '/'} vidstyle_growth"
        if (declared := self._parameter(name)[1]) is None:
            return f"({grown})"
        low = _float(declared.control.least_scaled(self._values[name][0]))
        high = _float(declared.control.high)
        return f"max({grown}, {low})" if declared.control.unit == "px" else f"clamp({grown}, {low}, {high})"

    def _parameter(self, name: str) -> tuple[str, Any]:
        """Return the function of a constant, and its block parameter or None."""
        parameter, _, number = name.rpartition("_")
        function = self._functions.get(number, "")
        names = [block for block in all_blocks() if function == block or function.startswith(f"{block}_")]
        block = max(names, key=len, default="")
        declared = all_blocks()[block].parameters.get(parameter) if block else None
        return (f"{block}.{parameter}", declared) if declared else (function, None)

    def _comment(self, name: str) -> str:
        """Return a comment with the parameter of a constant and its range."""
        owner, declared = self._parameter(name)
        if declared is None:
            return f"// of {owner}"
        return f"// {owner}: {declared.control.help} ({declared.control.range_text})"


def _constant(kind: str, numbers: list[float]) -> str:
    if kind == "bool":
        return str(bool(numbers[0])).lower()
    if kind in ("int", "ivec2"):
        whole = ", ".join(str(int(number)) for number in numbers)
        return whole if kind == "int" else f"ivec2({whole})"
    floats = ", ".join(map(_float, numbers))
    return floats if kind == "float" else f"{kind}({floats})"


def _float(number: float) -> str:
    return repr(float(number))
