"""Models that find people, with odd names, shapes and weights, or damaged as files."""

from __future__ import annotations

from random import Random

from face_network import red_people, remembering_people

from tools.fuzzing.damage import damaged
from vidstyle.regions.chosen_files import people_model

SIDES = 0, 1, 31, 32, 144, 256, 4097, 2**31, 2**63
"""Sizes that models may declare."""
NAMES = "r1i", "r1o", "r2i", "state_in", "state_out", "src", "pha", "", "i", "o" * 300, "past", "present"
"""Names of inputs and outputs, of which some belong together."""


def people_case(random: Random) -> tuple[str, bytes]:
    """A model of one input or with a state, or the installed model; two thirds damaged as files."""
    installed = people_model()
    if installed is not None and random.random() < 0.3:
        return ".people.tflite", damaged(random, installed.read_bytes())
    model = red_people() if random.random() < 0.3 else remembering_people(**_odd_state(random))
    return ".people.onnx", damaged(random, model) if random.random() < 0.6 else model


def _odd_state(random: Random) -> dict[str, object]:
    """Return arguments of `remembering_people`, half of them usual."""
    odd: dict[str, object] = {
        "state": (random.choice(NAMES), random.choice(NAMES)),
        "result": random.choice(NAMES),
        "size": (random.choice(SIDES[1:6]), random.choice(SIDES[1:6])),
        "state_shape": [random.choice(SIDES) for _ in range(random.choice((0, 1, 4, 4, 5)))],
    }
    return {name: value for name, value in odd.items() if random.random() < 0.4}
