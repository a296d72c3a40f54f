"""Messages to the page about the exploration: the clip, and the current screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.explore.choosing.tile_screen import CHOSEN_KIND, Tile
from vidstyle.explore.naming.wording import name_blocks, name_step_changes, names_of_changes, names_of_look
from vidstyle.explore.page.exploration import Exploration
from vidstyle.export.export_targets import describe_targets
from vidstyle.style import user_styles

CHANGED_KINDS = ("values", "step")
"""Kinds of tiles that are named by how they differ from the chosen one."""


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
        "stars": [_describe(exploration, tile, _look_names(exploration, tile)[0]) for tile in chooser.stars],
    }


def _describe_tiles(exploration: Exploration, tiles: tuple[Tile, ...]) -> list[dict[str, Any]]:
    """Describe the tiles of a screen; no two have the same caption."""
    chosen, captions = _chosen(tiles), list[str]()
    for tile in tiles:
        names = _names(exploration, tile, chosen)
        numbered = (f"{names[-1]} ({number})" for number in range(2, len(tiles) + 2))
        captions.append(next(name for name in (*names, *numbered) if name not in captions))
    return [
        _describe(exploration, tile, caption, chosen) for tile, caption in zip(tiles, captions, strict=True)
    ]


def _names(exploration: Exploration, tile: Tile, chosen: Tile | None) -> list[str]:
    """Return what a tile may be called, the best first: how it differs from the chosen one, or what it is."""
    if tile is chosen:
        return ["Your choice"]
    if chosen is not None and tile.kind in CHANGED_KINDS:
        return [*names_of_changes(tile.look.picture, chosen.look.picture), "Nearly the same"]
    return _look_names(exploration, tile)


def _look_names(exploration: Exploration, tile: Tile) -> list[str]:
    return names_of_look(tile.look.picture, exploration.marks.get(exploration.number(tile), ()))


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
        "caption": caption,
        "look": _look_names(exploration, tile)[0],
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
