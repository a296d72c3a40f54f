"""Random style files with odd values."""

from __future__ import annotations

import math
from random import Random
from typing import Any

import tomlkit
from random_styles import Chance

from tools.fuzzing.damage import ODD_VALUES, edit_text
from vidstyle.block import Control, Slider
from vidstyle.blocks import all_blocks
from vidstyle.style import LAYERS, table_from_style
from vidstyle.style.check import MAX_STEPS
from vidstyle.style.model import FIELDS, STEP_KEYS
from vidstyle.style.paths import steps_by_path


def style_case(random: Random) -> tuple[str, bytes]:
    """Return a style file of up to 256 steps; some values are out of range or of another type."""
    most = random.choice((1, 2, 2, 3, 8, MAX_STEPS // len(LAYERS)))
    chance = Chance(
        random.randrange(2**32), wild=True, learned=True, structure=True, max_steps=most, max_factor=math.inf
    )
    table = table_from_style(chance.style()) | random.choice(({}, {"height": random.uniform(16, 2000)}))
    share = random.choice((0, 0, 0.02, 0.3))
    for step in [table, *(step for layer in LAYERS for step in table.get(layer, []))]:
        parameters = all_blocks()[step["block"]].parameters if "block" in step else FIELDS
        step |= {
            name: _odd_value(random, parameters[name].control)
            for name in parameters
            if random.random() < share
        }
    values = {
        f"{path}.{name}": value
        for path, step in steps_by_path(table).items()
        for name, value in step.items()
        if name not in STEP_KEYS
    }
    table["variants"] = {"odd": {path: value for path, value in values.items() if random.random() < 0.02}}
    text = tomlkit.dumps(table)
    return ".toml", edit_text(random, text) if random.random() < 0.2 else text.encode()


def _odd_value(random: Random, control: Control) -> Any:
    odd = [*ODD_VALUES]
    if isinstance(control, Slider):
        ends = control.low, control.high
        odd = [*ends, *ends, *ends, *ends, control.low - 1, math.nextafter(control.high, math.inf), *odd]
    return random.choice(odd)
