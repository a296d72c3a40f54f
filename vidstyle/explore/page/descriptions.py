"""Messages to the page about the exploration: the clip, and the current screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.explore.choosing.tile_screen import CHOSEN_KIND, Tile
from vidstyle.explore.page.exploration import Exploration
from vidstyle.explore.wording import name_blocks, name_look, name_step_changes, name_visible_changes
from vidstyle.export.export_targets import describe_targets


def describe_clip(exploration: Exploration, has_designer: bool) -> dict[str, Any]:
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
        "tiles": [_describe(exploration, tile, _chosen(screen.tiles)) for tile in screen.tiles],
        "taken": screen.taken,
        "back": screen.before is not None,
        "forward": screen.after is not None,
        "near": chooser.near,
        "locks": sorted(chooser.locks),
        "history": [_face(exploration, each.tiles) for each in chooser.screens],
        "reference": len(exploration.references),
        "stars": [_describe(exploration, tile) for tile in chooser.stars],
    }


def _describe(exploration: Exploration, tile: Tile, chosen: Tile | None = None) -> dict[str, Any]:
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
        "look": name_look(tile.style, tile.look.picture),
        "blocks": name_blocks(tile.style),
        **_differences(tile, chosen),
        "layers": {layer: blocks for layer, blocks in layers.items() if blocks},
        "ink": tile.style.ink,
        "paper": tile.style.paper,
    }


def _chosen(tiles: tuple[Tile, ...]) -> Tile | None:
    """Return the tile in the middle if the others are derived from it."""
    middle = tiles[len(tiles) // 2]
    return middle if middle.kind == CHOSEN_KIND else None


def _differences(tile: Tile, chosen: Tile | None) -> dict[str, str]:
    """Return in words what distinguishes a tile from the one that it is derived from."""
    if chosen is None or tile is chosen:
        return {"steps": "", "changes": ""}
    return {
        "steps": name_step_changes(tile.style, chosen.style),
        "changes": name_visible_changes(tile.look.picture, chosen.look.picture),
    }


def _face(exploration: Exploration, tiles: tuple[Tile, ...]) -> list[int]:
    """Return the tiles that represent a screen: the chosen one, or four of a first screen."""
    chosen = _chosen(tiles)
    shown = (chosen,) if chosen else tiles[:4]
    return [exploration.number(tile) for tile in shown]
