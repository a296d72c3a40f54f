"""The document as plain data for the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from vidstyle.block import Asset, Block, SavedRef
from vidstyle.blocks import all_blocks
from vidstyle.design.document.content import Content, PlacedStep, ValueRef
from vidstyle.design.document.document import Document
from vidstyle.design.document.edits import name_of
from vidstyle.style import LAYERS, SOURCE
from vidstyle.style.model import FIELDS
from vidstyle.style.panel import control_of


def state_of(document: Document) -> dict[str, Any]:
    """All that the page shows of a document but its pictures."""
    content, history = document.content, document.history
    describe = _Describer(document)
    layers = {layer: [describe.node(step) for step in content.layers[layer]] for layer in LAYERS}
    fields = [describe.field(name) for name in FIELDS]
    entries = {(entry["step"], entry["name"]): entry for entry in fields}
    for nodes in layers.values():
        entries |= {(entry["step"], entry["name"]): entry for node in nodes for entry in node["entries"]}
    return {
        "revision": document.revision,
        "undo": history.undo_label,
        "redo": history.redo_label,
        "dirty": document.is_changed,
        "name": content.fields.get("name", ""),
        "note": content.fields.get("note", ""),
        "variants": list(content.variants),
        "variant": next((name for name in content.variants if _is_chosen(content, name)), ""),
        "strength": content.fields.get("strength", FIELDS["strength"].default),
        "fields": fields,
        "knobs": [entries[ref.step, ref.name] for ref in content.knobs if (ref.step, ref.name) in entries],
        "history": [{"entry": entry.number, "label": entry.label} for entry in history.entries],
        "present": history.present.number,
        "snapshots": list(document.snapshots),
        "layers": layers,
        "edges": list(_edges(content)),
        "errors": [each.text for each in document.mistakes if each.step is None],
    }


class _Describer:
    """Describes steps, in the order in which they run: it remembers which pictures are saved."""

    def __init__(self, document: Document) -> None:
        self._content = document.content
        self._path_of = self._content.paths()
        self._errors: dict[int | None, str] = {}
        for each in document.mistakes:
            self._errors.setdefault(each.step, each.text)
        self._saved = {SOURCE: None}

    def field(self, name: str) -> dict[str, Any]:
        """An entry for a field of the style."""
        parameter = FIELDS[name]
        value = self._content.fields.get(name, parameter.default)
        return control_of(parameter, []) | self._values(None, name, value, parameter.default)

    def node(self, step: PlacedStep) -> dict[str, Any]:
        """A step."""
        block = all_blocks().get(str(step.table.get("block")))
        entries = [] if block is None else list(self._entries(step, block))
        node = {
            "step": step.number,
            "block": step.table.get("block", ""),
            "kind": block.kind if block else "",
            "help": block.help if block else "Starts from another picture, or saves the present one.",
            "main": self._main(entries),
            "muted": bool(step.table.get("mute")),
            "save": step.table.get("save", ""),
            "implied": block.saves if block else "",
            "from": step.table.get("from", ""),
            "from_options": ["", *self._saved],
            "recipe": block is not None and block.kind == "recipe",
            "entries": entries,
            "error": self._errors.get(step.number),
        }
        saves = filter(None, [block.saves if block else "", node["save"]])
        self._saved |= dict.fromkeys(saves)
        return node

    def _entries(self, step: PlacedStep, block: Block) -> Iterator[dict[str, Any]]:
        for name, parameter in block.parameters.items():
            value = step.table.get(name, parameter.default)
            control = control_of(parameter, list(self._saved))
            picks = "picture" if isinstance(parameter.control, SavedRef) else ""
            picks = "file" if isinstance(parameter.control, Asset) else picks
            if picks and value not in control["options"]:
                control["options"].append(value)
            yield control | {"picks": picks} | self._values(step.number, name, value, parameter.default)

    def _values(self, step: int | None, name: str, value: Any, default: Any) -> dict[str, Any]:
        ref = ValueRef(step, name)
        return {
            "step": step,
            "about": "" if step is None else name_of(self._content.place_of(step)[2]),
            "name": name,
            "path": self._path_of(ref),
            "value": value,
            "default": default,
            "knob": ref in self._content.knobs,
        }

    def _main(self, entries: list[dict[str, Any]]) -> str:
        """The value that the card of a step shows: a knob, else what was changed, else the first."""
        ways: list[Callable[[dict[str, Any]], bool]] = [
            lambda entry: entry["knob"],
            lambda entry: entry["value"] != entry["default"],
            lambda entry: True,
        ]
        for way in ways:
            for entry in filter(way, entries):
                value = entry["value"]
                shown = f"{value:g}" if isinstance(value, float) else str(value).lower()
                return f"{entry['name']} {shown}"
        return ""


def _is_chosen(content: Content, name: str) -> bool:
    """Whether the style has all values of a variant."""
    tables = {step.number: step.table for _, _, step in content.steps}
    for ref, value in content.variants[name]:
        if ref.step is None:
            present = content.fields.get(ref.name, FIELDS[ref.name].default)
        else:
            table = tables[ref.step]
            present = table.get(ref.name, all_blocks()[table["block"]].parameters[ref.name].default)
        if present != value:
            return False
    return bool(content.variants[name])


def _edges(content: Content) -> Iterator[dict[str, Any]]:
    """Which saved pictures are used where."""
    savers: dict[str, int | str] = {SOURCE: SOURCE}
    for _, _, step in content.steps:
        block = all_blocks().get(str(step.table.get("block")))
        used = {"from": step.table.get("from", "")}
        for name in block.saved_refs if block else ():
            used[name] = step.table.get(name, block.parameters[name].default if block else "")
        for name, saved in used.items():
            if saved in savers:
                yield {"from": savers[saved], "to": step.number, "name": saved, "as": name}
        for saved in filter(None, [block.saves if block else "", step.table.get("save", "")]):
            savers[str(saved)] = step.number
