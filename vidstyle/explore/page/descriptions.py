"""Messages to the page about the exploration: the clip, and the current screen."""

from __future__ import annotations

from collections.abc import Collection
from itertools import chain, count
from pathlib import Path
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.explore.choosing.tile_screen import CHOSEN_KIND, Tile
from vidstyle.explore.naming.wording import name_blocks, name_step_changes, names_of_changes, names_of_look
from vidstyle.explore.page.exploration import Exploration
from vidstyle.export.export_targets import describe_targets
from vidstyle.style import user_styles

CHANGED_KINDS = ("values", "step")
"""Kinds of tiles that are described by how they differ from the chosen one."""


def describe_clip(exploration: Exploration, has_designer: bool, can_reveal: bool) -> dict[str, Any]:
    """Return the message that describes the clip and available actions."""
    return {
        "name": Path(exploration.clip.name).name,
        "size": exploration.clip.size,
        "frames": list(exploration.frames),
        "rate": exploration.rate,
        "fps": float(exploration.clip.fps),
        "count": exploration.clip.count,
        "render": not exploration.clip.live,
        "design": has_designer,
        "reveal": can_reveal,
        "folder": str(user_styles()),
        "output": str(Path.cwd()),
        "targets": describe_targets(),
    }


def describe_state(exploration: Exploration) -> dict[str, Any]:
    """Return the message that describes the current state."""
    chooser = exploration.chooser
    if not chooser.screens:
        return {"tiles": []}
    screen = chooser.screen
    return {
        "at": chooser.at,
        "tiles": _describe_tiles(exploration, screen.tiles),
        "taken": screen.taken,
        "back": screen.before is not None,
        "forward": screen.after is not None,
        "near": chooser.near,
        "locks": sorted(chooser.locks),
        "history": [_face(exploration, each.tiles) for each in chooser.screens],
        "reference": len(exploration.references),
        "stars": [_describe(exploration, tile, _name(exploration, tile, [])) for tile in chooser.stars],
    }


def _describe_tiles(exploration: Exploration, tiles: tuple[Tile, ...]) -> list[dict[str, Any]]:
    """Describe the tiles of a screen; no two have the same caption."""
    chosen, captions = _chosen(tiles), dict[int, str]()
    for tile in sorted(tiles, key=lambda each: each is not chosen):
        captions[id(tile)] = _name(exploration, tile, captions.values())
    return [_describe(exploration, tile, captions[id(tile)], chosen) for tile in tiles]


def _name(exploration: Exploration, tile: Tile, others: Collection[str]) -> str:
    """Return the name of a look: what one sees of it, unlike `others`. It stays the same on all screens."""
    known = exploration.names.get(repr(tile.style))
    if known is not None and known not in others:
        return known
    names = names_of_look(tile.look.picture, exploration.marks.get(exploration.number(tile), ()))
    numbered = (f"{names[0]} ({number})" for number in count(2))
    name = next(each for each in chain(names, numbered) if each not in others)
    exploration.names[repr(tile.style)] = name
    return name


def _change(tile: Tile, chosen: Tile | None) -> str:
    """Return how a tile differs from the chosen one; "" if it is not derived from it."""
    if chosen is None or tile.kind not in CHANGED_KINDS:
        return ""
    return next(iter(names_of_changes(tile.look.picture, chosen.look.picture)), "Nearly the same")


def _describe(
    exploration: Exploration, tile: Tile, caption: str, chosen: Tile | None = None
) -> dict[str, Any]:
    layers = {
        layer: [all_blocks()[step.block].label for step in steps if step.block]
        for layer, steps in tile.style.layers.items()
    }
    return {
        "tile": exploration.number(tile),
        "name": tile.style.name,
        "kind": tile.kind,
        "parents": tile.parents,
        "likeness": tile.likeness,
        "verdict": tile.look.verdict,
        "fault": tile.look.fault,
        "caption": caption,
        "change": _change(tile, chosen),
        "blocks": name_blocks(tile.style),
        "steps": name_step_changes(tile.style, chosen.style) if chosen else "",
        "layers": {layer: blocks for layer, blocks in layers.items() if blocks},
        "ink": tile.style.ink,
        "paper": tile.style.paper,
    }


def _chosen(tiles: tuple[Tile, ...]) -> Tile | None:
    """Return the tile in the middle if the others are derived from it."""
    middle = tiles[len(tiles) // 2]
    return middle if middle.kind == CHOSEN_KIND else None


def _face(exploration: Exploration, tiles: tuple[Tile, ...]) -> list[int]:
    """Return the tiles that represent a screen: the chosen one, or four of a first screen."""
    chosen = _chosen(tiles)
    shown = (chosen,) if chosen else tiles[:4]
    return [exploration.number(tile) for tile in shown]
