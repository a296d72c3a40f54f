"""The immutable content of a style during editing, with permanent numbers for its steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from vidstyle.block import Parameter
from vidstyle.errors import UsageError
from vidstyle.style import LAYERS, Style, table_from_style
from vidstyle.style.knobs import split_label
from vidstyle.style.paths import find_value, steps_by_path


@dataclass(frozen=True)
class PlacedStep:
    """A step with a permanent number; `table`: the step as in a style file."""

    number: int
    table: Mapping[str, Any]


@dataclass(frozen=True)
class ValueRef:
    """A reference to a value by step number; paths change when steps are added or removed.

    Attributes:
        step: the number of its step; None for a field of the style.
        name: the name of the parameter or field.
        path: its path when the file was last written.
    """

    step: int | None
    name: str
    path: str = field(default="", compare=False)


@dataclass(frozen=True)
class Content:
    """The content of a style file.

    Attributes:
        fields: name, note and fields that differ from their defaults.
        layers: the steps of each layer.
        knobs: the values pinned to the style panel.
        labels: what values do in this style, in plain words.
        variants: the values that each variant sets, by name.
        standard: the values, as the style was opened, that any variant sets.
    """

    fields: Mapping[str, Any]
    layers: Mapping[str, tuple[PlacedStep, ...]]
    knobs: tuple[ValueRef, ...] = ()
    labels: Mapping[ValueRef, str] = field(default_factory=dict)
    variants: Mapping[str, tuple[tuple[ValueRef, Any], ...]] = field(default_factory=dict)
    standard: Mapping[ValueRef, Any] = field(default_factory=dict)

    @property
    def steps(self) -> Iterator[tuple[str, int, PlacedStep]]:
        """Yield layer, index and step, in the order in which they run."""
        for layer in LAYERS:
            for place, step in enumerate(self.layers[layer]):
                yield layer, place, step

    def place_of(self, number: int) -> tuple[str, int, PlacedStep]:
        """Return layer, index and step for a step number.

        Raises:
            UsageError: there is no such step.
        """
        for found in self.steps:
            if found[2].number == number:
                return found
        raise UsageError(f"step {number}", "no longer exists")

    def label_of(self, ref: ValueRef, parameter: Parameter) -> str:
        """Return the label of a value in this style."""
        return self.declared(ref, parameter).label

    def declared(self, ref: ValueRef, parameter: Parameter) -> Parameter:
        """Return the parameter of a value with its label and help in this style."""
        return parameter.named(*split_label(self.labels[ref])) if ref in self.labels else parameter

    def value_of(self, ref: ValueRef, parameter: Parameter) -> Any:
        """Return a value: its default if it is not set, or if there is no such step."""
        tables = {step.number: step.table for _, _, step in self.steps}
        table = self.fields if ref.step is None else tables.get(ref.step, {})
        return table.get(ref.name, parameter.default)

    def with_layer(self, layer: str, steps: tuple[PlacedStep, ...]) -> Content:
        """Return the content with a layer replaced and references to removed steps deleted."""
        layers = {**self.layers, layer: steps}
        there = {None, *(step.number for each in layers.values() for step in each)}
        variants = {
            name: tuple((ref, value) for ref, value in values if ref.step in there)
            for name, values in self.variants.items()
        }
        knobs = tuple(ref for ref in self.knobs if ref.step in there)
        labels = {ref: label for ref, label in self.labels.items() if ref.step in there}
        standard = {ref: value for ref, value in self.standard.items() if ref.step in there}
        return replace(self, layers=layers, knobs=knobs, labels=labels, variants=variants, standard=standard)

    def with_step(self, number: int, table: Mapping[str, Any]) -> Content:
        """Return the content with the table of a step replaced."""
        layer, place, step = self.place_of(number)
        steps = list(self.layers[layer])
        steps[place] = replace(step, table=table)
        return replace(self, layers={**self.layers, layer: tuple(steps)})

    def table(self) -> dict[str, Any]:
        """Return the content as the table of a style file, valid or not."""
        layers = {
            layer: [dict(step.table) for step in steps] for layer, steps in self.layers.items() if steps
        }
        table = {"format": 1, **self.fields, **layers}
        path_of = self._paths(table)
        if self.knobs:
            table["knobs"] = [path_of(ref) for ref in self.knobs]
        if self.labels:
            table["labels"] = {path_of(ref): label for ref, label in self.labels.items()}
        if self.variants:
            table["variants"] = {
                name: {path_of(ref): value for ref, value in values} for name, values in self.variants.items()
            }
        return table

    def paths(self) -> Callable[[ValueRef], str]:
        """Return a function that maps a reference to a path."""
        return self._paths(self.table())

    def _paths(self, table: Mapping[str, Any]) -> Callable[[ValueRef], str]:
        table = dict(table)
        numbers = {id(table[layer][place]): step.number for layer, place, step in self.steps}
        shortest = {numbers[id(step)]: path for path, step in steps_by_path(table).items()}

        def path_of(ref: ValueRef) -> str:
            try:
                found = find_value(table, ref.path)
            except ValueError:
                found = None
            if found and (numbers.get(id(found.table)), found.parameter.name) == (ref.step, ref.name):
                return ref.path
            return ref.name if ref.step is None else f"{shortest[ref.step]}.{ref.name}"

        return path_of


def content_of(style: Style, new_number: Callable[[], int]) -> Content:
    """Return the content of a style with numbered steps."""
    table = table_from_style(style)
    layers = {
        layer: tuple(PlacedStep(new_number(), step) for step in table.get(layer, [])) for layer in LAYERS
    }
    numbers = {id(step.table): step.number for steps in layers.values() for step in steps}

    def ref(path: str) -> ValueRef:
        found = find_value(table, path)
        return ValueRef(numbers.get(id(found.table)), found.parameter.name, path)

    def standard(path: str) -> Any:
        found = find_value(table, path)
        return found.table.get(found.parameter.name, found.parameter.default)

    others = ("format", "knobs", "labels", "variants", *LAYERS)
    return Content(
        fields={name: value for name, value in table.items() if name not in others},
        layers=layers,
        knobs=tuple(map(ref, style.knobs)),
        labels={ref(path): label for path, label in style.labels.items()},
        variants={
            name: tuple((ref(path), value) for path, value in values.items())
            for name, values in style.variants.items()
        },
        standard={ref(path): standard(path) for values in style.variants.values() for path in values},
    )
