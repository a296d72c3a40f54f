"""Random edits of the designer's document, and a simple model of a style for comparison."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import tomlkit

from vidstyle.block import Asset, Choice, Color, SavedRef, Slider, Switch
from vidstyle.blocks import all_blocks
from vidstyle.core.file_checks import parse_toml
from vidstyle.design.document.document import Document
from vidstyle.design.document.state import state_of
from vidstyle.errors import StyleError, UsageError
from vidstyle.gpu.compile.es import es_plan
from vidstyle.style import LAYERS, Style, load_style, save_style, style_from_table
from vidstyle.style.files import read_style_text
from vidstyle.style.paths import find_value

Random = random.Random
Fields = dict[str, Any]
SIZE = (64, 36)


class Model:
    """A style as lists of dictionaries, with copies of all earlier states."""

    def __init__(self, document: Document) -> None:
        table = document.content.table()
        numbers = [step.number for _, _, step in document.content.steps]
        steps = iter(numbers)
        self.layers = {
            layer: [(next(steps), dict(step)) for step in table.get(layer, [])] for layer in LAYERS
        }
        self.fields = {
            key: value for key, value in table.items() if key not in (*LAYERS, "knobs", "labels", "variants")
        }
        self.knobs = [named(table, self.layers, path) for path in table.get("knobs", [])]
        self.labels = {
            named(table, self.layers, path): label for path, label in table.get("labels", {}).items()
        }
        self.past: list[Any] = []
        self.future: list[Any] = []
        self.gesture: object = None

    def state(self) -> Any:
        return copy.deepcopy((self.layers, self.fields, self.knobs, self.labels))

    def find(self, number: int) -> tuple[str, int, Fields]:
        return next(
            (layer, place, step)
            for layer in LAYERS
            for place, (each, step) in enumerate(self.layers[layer])
            if each == number
        )

    def drop_step(self, number: int) -> None:
        """Remove all references to a step."""
        self.knobs = [ref for ref in self.knobs if ref[0] != number]
        self.labels = {ref: text for ref, text in self.labels.items() if ref[0] != number}

    def numbers(self) -> list[int]:
        return [number for layer in LAYERS for number, _ in self.layers[layer]]

    def table(self) -> Fields:
        layers = {layer: [step for _, step in self.layers[layer]] for layer in LAYERS if self.layers[layer]}
        return {name: value for name, value in self.fields.items() if value is not None} | layers


def named(table: Fields, layers: dict[str, list[tuple[int, Fields]]], path: str) -> tuple[int | None, str]:
    """Return the step and the parameter of a path."""
    found = find_value(table, path)
    for layer in LAYERS:
        for place, step in enumerate(table.get(layer, [])):
            if step is found.table:
                return layers[layer][place][0], found.parameter.name
    return None, found.parameter.name


def a_step(model: Model, choose: Random) -> int:
    return choose.choice([*model.numbers(), 10**6])


def add(model: Model, choose: Random) -> Fields:
    layer, block = choose.choice(LAYERS), choose.choice(["", *all_blocks()])
    index = choose.randint(0, len(model.layers[layer]) + (choose.random() < 0.05))
    return {"layer": layer, "index": index, "block": block}


def move(model: Model, choose: Random) -> Fields:
    layer = choose.choice(LAYERS)
    return {
        "step": a_step(model, choose),
        "layer": layer,
        "index": choose.randint(0, len(model.layers[layer])),
    }


def step_alone(model: Model, choose: Random) -> Fields:
    return {"step": a_step(model, choose)}


def a_value(control: object, choose: Random, whole: bool) -> Any:
    match control:
        case Slider():
            value = choose.uniform(control.low - 0.1, control.high)
            return round(value) if whole else value
        case Switch():
            return choose.random() < 0.5
        case Choice():
            return choose.choice(control.options)
        case Color():
            return choose.choice(["#123456", "white", "no colour"])
        case SavedRef():
            return choose.choice(["source", "chroma", "kept"])
        case Asset():
            return choose.choice([*control.shipped(), "nowhere.npz"])
    raise AssertionError(control)


def paste(model: Model, choose: Random) -> Fields:
    layer = choose.choice(LAYERS)
    steps = [step for _, step in model.layers[choose.choice(LAYERS)]]
    texts = ["no steps", tomlkit.dumps({"lines": steps[:2]}), tomlkit.dumps({"base": steps[-1:]})]
    return {
        "layer": layer,
        "index": choose.randint(0, len(model.layers[layer])),
        "text": choose.choice(texts),
    }


def set_value(model: Model, choose: Random) -> Fields:
    step = a_step(model, choose)
    block = all_blocks().get(model.find(step)[2].get("block", "")) if step < 10**6 else None
    if block is None or not block.parameters:
        return {"step": step, "name": "sigma", "value": 1.0}
    parameter = choose.choice([*block.parameters.values()])
    return {
        "step": step,
        "name": parameter.name,
        "value": a_value(parameter.control, choose, parameter.is_integer),
    }


def set_field(model: Model, choose: Random) -> Fields:
    name = choose.choice(["ink", "paper", "steady", "strength", "height", "inks"])
    value = choose.choice(["#ff0000", "black", 0.5, 1, 720, None, "x"])
    return {"name": name, "value": value}


def refer(model: Model, choose: Random) -> Fields:
    return {
        "step": a_step(model, choose),
        "name": choose.choice(["from", "save"]),
        "value": choose.choice(["", "kept", "other", "source", "no name"]),
    }


def mute(model: Model, choose: Random) -> Fields:
    return {"step": a_step(model, choose), "on": choose.random() < 0.5}


def knob(model: Model, choose: Random) -> Fields:
    made = set_value(model, choose)
    return {"step": made["step"], "name": made["name"], "on": choose.random() < 0.7}


def label(model: Model, choose: Random) -> Fields:
    made = set_value(model, choose)
    texts = ["Solid ink", "", "Sun  and moon", "Tone: how dark it is", "x" * 41, "\x00"]
    return {"step": made["step"], "name": made["name"], "text": choose.choice(texts)}


def rename(model: Model, choose: Random) -> Fields:
    return {"name": choose.choice(["one", "two", "x" * 200])}


def note(model: Model, choose: Random) -> Fields:
    return {"text": choose.choice(["", "A note.", "In\ntwo lines.", "\x00"])}


MAKERS: dict[str, Callable[[Model, Random], Fields]] = {
    "add": add,
    "move": move,
    "remove": step_alone,
    "duplicate": step_alone,
    "paste": paste,
    "set": set_value,
    "field": set_field,
    "refer": refer,
    "mute": mute,
    "expand": step_alone,
    "knob": knob,
    "label": label,
    "rename": rename,
    "note": note,
}


def apply(model: Model, kind: str, new: int | None, fields: Fields) -> None:
    """Apply an edit to the model."""
    layers = model.layers
    if kind == "add":
        step = {"block": fields["block"]} if fields["block"] else {"from": "source"}
        layers[fields["layer"]].insert(fields["index"], (new or 0, step))
    elif kind == "paste":
        taken = {step.get("save") for step in model_steps(model)}
        pasted = [step for layer in LAYERS for step in parse_toml(fields["text"]).get(layer, [])]
        for place, step in enumerate(pasted):
            kept = {key: value for key, value in step.items() if key != "save" or value not in taken}
            layers[fields["layer"]].insert(
                fields["index"] + place, ((new or 0) + place, kept or {"from": "source"})
            )
    elif kind in ("rename", "note"):
        text = " ".join(fields.get("name", fields.get("text", "")).split())
        model.fields["name" if kind == "rename" else "note"] = text
    elif kind == "field":
        value = getattr(Style, fields["name"]) if fields["value"] is None else fields["value"]
        model.fields[fields["name"]] = "#000000" if value == "black" else value
    elif kind == "knob":
        ref = fields["step"], fields["name"]
        model.knobs = [each for each in model.knobs if each != ref] if not fields["on"] else model.knobs
        model.knobs += [ref] * (fields["on"] and ref not in model.knobs)
    elif kind == "label":
        _, colon, own_help = model.labels.pop((fields["step"], fields["name"]), "").partition(": ")
        if fields["text"]:
            text = " ".join(fields["text"].split())
            kept = colon + own_help if ": " not in text else ""
            model.labels[fields["step"], fields["name"]] = text + kept
    else:
        layer, place, step = model.find(fields["step"])
        if kind == "move":
            moved = layers[layer].pop(place)
            layers[fields["layer"]].insert(fields["index"], moved)
        elif kind == "remove":
            del layers[layer][place]
            model.drop_step(fields["step"])
        elif kind == "duplicate":
            copied = {key: value for key, value in step.items() if key != "save"}
            layers[layer].insert(place + 1, (new or 0, copied or {"from": "source"}))
        elif kind == "mute":
            step.pop("mute", None)
            step.update({"mute": True} if fields["on"] else {})
        elif kind == "set":
            value = fields["value"]
            step[fields["name"]] = {"white": "#ffffff"}.get(value, value) if isinstance(value, str) else value
        elif kind == "refer":
            old = step.pop(fields["name"], None)
            step.update({fields["name"]: fields["value"]} if fields["value"] else {})
            step.update({} if step else {"from": "source"})
            renamed = fields["name"] == "save" and old and fields["value"]
            if renamed and not any(each.get("save") == old for each in model_steps(model)):
                for each in model_steps(model):
                    block = all_blocks().get(each.get("block", ""))
                    for key in ("from", *(block.saved_refs if block else ())):
                        if each.get(key) == old:
                            each[key] = fields["value"]


def model_steps(model: Model) -> list[Fields]:
    return [step for layer in LAYERS for _, step in model.layers[layer]]


def without_defaults(table: Fields) -> Fields:
    """Return a table without optional values."""
    table = copy.deepcopy(table)
    for layer in LAYERS:
        for step in table.get(layer, []):
            block = all_blocks().get(step.get("block", ""))
            for parameter in block.parameters.values() if block else ():
                if parameter.name in step and step[parameter.name] == parameter.default:
                    del step[parameter.name]
    for name in ("note", "ink", "paper", "steady", "strength", "height"):
        if name in table and table[name] == getattr(Style, name):
            del table[name]
    return {key: value for key, value in table.items() if value != ""}


def check(document: Document, model: Model, file: Path | None) -> None:
    """Check that document, state of the page, model and file agree."""
    table = document.content.table()
    plain = {key: value for key, value in table.items() if key not in ("knobs", "labels", "variants")}
    assert without_defaults(plain) == without_defaults(model.table())
    assert [(ref.step, ref.name) for ref in document.content.knobs] == model.knobs
    assert [named(table, model.layers, path) for path in table.get("knobs", [])] == model.knobs
    assert {(ref.step, ref.name): text for ref, text in document.content.labels.items()} == model.labels
    paths = table.get("labels", {}).items()
    assert {named(table, model.layers, path): text for path, text in paths} == model.labels
    state = state_of(document)
    for layer in LAYERS:
        shown = [
            (node["step"], node["block"], node["muted"], node["save"]) for node in state["layers"][layer]
        ]
        assert shown == [
            (number, step.get("block", ""), bool(step.get("mute")), step.get("save", ""))
            for number, step in model.layers[layer]
        ]
        for node, (_, step) in zip(state["layers"][layer], model.layers[layer], strict=True):
            for entry in node["entries"]:
                assert entry["value"] == step.get(entry["name"], entry["default"])
    assert (state["undo"] is None) == (not model.past) and (state["redo"] is None) == (not model.future)
    try:
        style = style_from_table(table, "style", folder=document.folder)
    except StyleError as error:
        told = [node["error"] for nodes in state["layers"].values() for node in nodes if node["error"]]
        assert document.mistakes and (told or state["errors"])
        assert len(error.mistakes) == len(document.mistakes)
        return
    assert document.mistakes == [] and document.style == style
    if file is not None:
        save_style(style, file, read_style_text(file) if file.exists() else None)
        assert without_defaults(Document(load_style(file)).content.table()) == without_defaults(table)


def run(start: str, count: int, choose: Random, file: Path) -> int:
    """Make random edits and return their number."""
    document = Document(load_style(start))
    model = Model(document)
    made = 0
    for number in range(count):
        kind = choose.choice([*MAKERS, "add", "set", "set", "undo", "redo"])
        if document.mistakes and choose.random() < 0.6:  # most edits of a style with mistakes leave them
            kind = "undo"
        if kind == "undo" or kind == "redo":
            here, there = (model.past, model.future) if kind == "undo" else (model.future, model.past)
            getattr(document, kind)()
            if here:
                model.gesture = None
                there.append(model.state())
                model.layers, model.fields, model.knobs, model.labels = here.pop()
        else:
            before, gesture = model.state(), choose.randrange(3)
            fields = MAKERS[kind](model, choose)
            old = document.content
            try:
                new = document.edit(kind, gesture, **fields)
            except UsageError:
                assert document.content == old
                continue
            if document.content != old:
                made += 1
                if kind == "expand":
                    follow_expansion(document, model, fields["step"], old.table())
                else:
                    apply(model, kind, new, fields)
                if gesture != model.gesture or not model.past:
                    model.past.append(before)
                model.future, model.gesture = [], gesture
        check(document, model, file if number % 10 == 0 else None)
    return made


def follow_expansion(document: Document, model: Model, step: int, before: Fields) -> None:
    """Copy the steps of an expanded recipe to the model, if the picture is the same."""
    layer, place, _ = model.find(step)
    steps = document.content.layers[layer]
    more = len(steps) - len(model.layers[layer]) + 1
    assert more >= 1 and step not in [each.number for each in steps]
    model.layers[layer][place : place + 1] = [
        (each.number, dict(each.table)) for each in steps[place : place + more]
    ]
    model.drop_step(step)
    before = {key: value for key, value in before.items() if key not in ("knobs", "labels", "variants")}
    plans = [es_plan(style_from_table(each, "style"), *SIZE) for each in (before, model.table())]
    for plan in plans:
        plan["measures"] = [{**each, "step": ""} for each in plan["measures"]]
    assert plans[0] == plans[1]
