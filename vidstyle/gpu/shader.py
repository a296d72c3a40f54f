"""The shader of a pass: its text, and what has to be bound before it runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from vidstyle.gpu.includes import Assembly
from vidstyle.gpu.nodes import Measure, Node
from vidstyle.gpu.shared import Pair
from vidstyle.gpu.signature import Parameter
from vidstyle.gpu.targets import Target

GROUPS: dict[Pair | None, Pair] = {None: (16, 16), (1, 0): (32, 8), (0, 1): (8, 32)}
"""Invocations across and down in a group of a compute pass: more in the direction in which its filters read,
because neighbours in that direction read the same pixels."""


@dataclass(frozen=True)
class ImageOf:
    """A picture that a sampler reads; `part` is 1 for the second plane, red difference."""

    node: Node
    part: int = 0


@dataclass
class Shader:
    """The text of a pass and what has to be bound before it runs.

    Attributes:
        assembly: the text, and the files that it comes from.
        targets: what it writes, in the order of the bindings.
        uniforms: values by the names of uniforms.
        samplers: what each reads: a picture, the numbers of a measure, or an asset's arrays.
        groups: pixels across and down for each group of a compute pass.
    """

    assembly: Assembly
    targets: list[Target] = field(default_factory=list)
    uniforms: dict[str, Any] = field(default_factory=dict)
    samplers: dict[str, ImageOf | Measure | tuple] = field(default_factory=dict)
    groups: Pair = GROUPS[None]

    def add_sampler(self, name: str, kind: str, what: ImageOf | Measure | tuple) -> None:
        """Declare a sampler, and keep what it reads."""
        self.assembly.add(f"uniform {kind} {name};")
        self.samplers[name] = what

    def add_uniform(self, name: str, parameter: Parameter, value: Any) -> str:
        """Declare a uniform unless it is there, keep its value, and return its name."""
        count = f"[{parameter.count}]" if parameter.count else ""
        if name not in self.uniforms:
            self.assembly.add(f"uniform {parameter.type} {name}{count};")
        self.uniforms[name] = value
        return name
