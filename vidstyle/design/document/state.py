"""The document as plain data for the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from vidstyle.block import Block, Parameter, distinct_labels
from vidstyle.design.document.content import Content, PlacedStep, ValueRef
from vidstyle.design.document.document import Document
from vidstyle.design.document.edit_values import label_of
from vidstyle.design.document.variant_choice import chosen_variant, variant_names, variant_values
from vidstyle.style import LAYERS, SOURCE, Step
from vidstyle.style.model import FIELDS, step_from_table
from vidstyle.style.panel import is_color
from vidstyle.style.wiring import WiredStep, main_path, wire_layers


def state_of(document: Document) -> dict[str, Any]:
    """All that the page shows of a document but its pictures."""
    content, history = document.content, document.history
    describe = _Describer(document)
    wired = {step.number: each for step, each in zip(_steps(content), _wire(content), strict=True)}
    path = _main_path(content)
    layers = {
        layer: [
            describe.node(step, wired[step.number]) | {"aside": step.number not in path}
            for step in content.layers[layer]
        ]
        for layer in LAYERS
    }
    fields = [describe.field(name) for name in FIELDS]
    nodes = [node for each in layers.values() for node in each]
    return {
        "revision": document.revision,
        "undo": history.undo_label,
        "redo": history.redo_label,
        "dirty": document.is_changed,
        "name": content.fields.get("name", ""),
        "note": content.fields.get("note", ""),
        "variants": [_swatch(content, name) for name in variant_names(content)],
        "variant": chosen_variant(content),
        "strength": content.fields.get("strength", FIELDS["strength"].default),
        "fields": fields,
        "knobs": _knobs(content, [*fields, *(entry for node in nodes for entry in node["entries"])]),
        "history": [{"entry": entry.number, "label": entry.label} for entry in history.entries],
        "present": history.present.number,
        "snapshots": list(document.snapshots),
        "layers": layers,
        "edges": list(_edges(content)),
        "errors": [each.text for each in document.mistakes if each.step is None],
    }


def _knobs(content: Content, entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the entries of the knobs, with distinct labels."""
    by_ref = {ValueRef(entry["step"], entry["name"]): entry for entry in entries}
    knobs = [by_ref[ref] for ref in content.knobs if ref in by_ref]
    labels = distinct_labels([entry["label"] for entry in knobs])
    return [entry | {"label": label} for entry, label in zip(knobs, labels, strict=True)]


class _Describer:
    """Describes steps and fields."""

    def __init__(self, document: Document) -> None:
        self._content, self._start = document.content, document.start
        self._path_of = self._content.paths()
        self._errors: dict[int | None, str] = {}
        for each in document.mistakes:
            self._errors.setdefault(each.step, each.text)

    def field(self, name: str) -> dict[str, Any]:
        """An entry for a field of the style."""
        parameter = FIELDS[name]
        value = self._content.fields.get(name, parameter.default)
        return parameter.describe([]) | self._values(None, parameter, value)

    def node(self, step: PlacedStep, wired: WiredStep) -> dict[str, Any]:
        """A step."""
        block = wired.wiring.block
        entries = [] if block is None else list(self._entries(step, block, list(wired.savers)))
        return {
            "step": step.number,
            "block": step.table.get("block", ""),
            "label": block.label if block else "",
            "kind": block.kind if block else "",
            "help": block.help if block else _help_without_block(wired.step),
            "main": self._main(entries),
            "muted": wired.step.mute,
            "save": wired.wiring.saved_output,
            "implied": wired.wiring.saved_input,
            "from": wired.step.source,
            "from_options": ["", *wired.savers],
            "recipe": block is not None and block.kind == "recipe",
            "entries": entries,
            "error": self._errors.get(step.number),
        }

    def _entries(self, step: PlacedStep, block: Block, saved: list[str]) -> Iterator[dict[str, Any]]:
        for name, parameter in block.parameters.items():
            value = step.table.get(name, parameter.default)
            control, picks = parameter.describe(saved), parameter.control.picks
            if picks and value not in control["options"]:
                control["options"].append(value)
            yield control | {"picks": picks} | self._values(step.number, parameter, value)

    def _values(self, step: int | None, parameter: Parameter, value: Any) -> dict[str, Any]:
        ref = ValueRef(step, parameter.name)
        declared = self._content.declared(ref, parameter)
        return {
            "label": declared.label,
            "help": declared.control.help,
            "step": step,
            "about": "" if step is None else label_of(self._content.place_of(step)[2]),
            "name": parameter.name,
            "path": self._path_of(ref),
            "value": value,
            "default": parameter.default,
            "start": self._start.value_of(ref, parameter),
            "knob": ref in self._content.knobs,
        }

    def _main(self, entries: list[dict[str, Any]]) -> str:
        """Return the value for the card of a step: a knob, else a changed value, else the first.

        Names of saved pictures say little there; wires show them.
        """
        entries = [entry for entry in entries if entry["picks"] != "picture"]
        ways: list[Callable[[dict[str, Any]], bool]] = [
            lambda entry: entry["knob"],
            lambda entry: entry["value"] != entry["default"],
            lambda entry: True,
        ]
        for way in ways:
            for entry in filter(way, entries):
                value = entry["value"]
                shown = f"{value:g}" if isinstance(value, float) else str(value).lower().replace("_", " ")
                return f"{entry['label']}: {shown}"
        return ""


def _help_without_block(step: Step) -> str:
    if step.source:
        return "Starts again from another picture."
    return "Saves the picture of this place, which later steps can read unchanged."


def _swatch(content: Content, name: str) -> dict[str, Any]:
    """Return the name of a variant, the colours of its ink and paper, and the other colours that it sets."""
    values = variant_values(content, name)
    others = [value for ref, value in values.items() if ref.step is not None and is_color(value)]
    varied = {**content.fields} | {ref.name: value for ref, value in values.items() if ref.step is None}
    return {"name": name, "colors": others} | {
        color: varied.get(color, FIELDS[color].default) for color in ("ink", "paper")
    }


def _edges(content: Content) -> Iterator[dict[str, Any]]:
    """Yield which saved pictures are read by which step."""
    numbers = [step.number for step in _steps(content)]
    for number, wired in zip(numbers, _wire(content), strict=True):
        for key, name in wired.wiring.reads.items():
            if name in wired.savers:
                saver = wired.savers[name]
                yield {
                    "from": SOURCE if saver is None else numbers[saver],
                    "to": number,
                    "name": name,
                    "as": key,
                }


def _steps(content: Content) -> list[PlacedStep]:
    return [step for _, _, step in content.steps]


def _wire(content: Content) -> Iterator[WiredStep]:
    return wire_layers(_layers(content), content.fields.get("masks", {}))


def _main_path(content: Content) -> set[int]:
    """Return the numbers of the steps whose picture becomes the result."""
    path = main_path(_layers(content), content.fields.get("masks", {}))
    return {step.number for index, step in enumerate(_steps(content)) if index in path}


def _layers(content: Content) -> dict[str, tuple[Step, ...]]:
    layers = content.layers.items()
    return {layer: tuple(step_from_table(step.table) for step in steps) for layer, steps in layers}
