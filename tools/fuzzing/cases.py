"""Make the file of a case: the same kind, seed and number give the same bytes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple

from tools.fuzzing.arrays import array_case
from tools.fuzzing.banks import bank_case, network_case, people_case
from tools.fuzzing.damage import damage
from tools.fuzzing.film_times import TIMED, concatenate, shift_times
from tools.fuzzing.formats import FAMILIES
from tools.fuzzing.metadata import PLACERS, add_metadata
from tools.fuzzing.pages import config_case, cue_case, page_case
from tools.fuzzing.restructure import restructure
from tools.fuzzing.styles import style_case
from tools.fuzzing.subtitles import subtitle_case


class Case(NamedTuple):
    """The kind, seed and number that determine a file."""

    kind: str
    seed: int
    number: int


def make_file(kind: str, seed: int, number: int, whole: dict[str, list[Path]]) -> tuple[str, bytes]:
    """Return the file ending and the content of a case.

    Args:
        kind, seed, number: see `Case`.
        whole: undamaged films and pictures by kind.
    """
    random = Random(f"{kind} {seed} {number}")
    make = KINDS[kind]
    return make(random, whole[kind]) if kind in whole else make(random)


def film_case(random: Random, originals: Sequence[Path]) -> tuple[str, bytes]:
    """Return a film: half have damaged bytes, the others changed structure, times or streams."""
    path = random.choice(originals)
    content, suffix = path.read_bytes(), path.suffix
    if random.random() < 0.5:
        return suffix, damage(random, content)
    alike = [each.read_bytes() for each in originals if each.suffix == suffix]
    changes: list[Callable[[], bytes]] = [lambda: concatenate(random, alike)]
    if suffix in FAMILIES:
        donor = random.choice(alike)
        changes += [lambda: restructure(random, content, FAMILIES[suffix], donor)] * 3
    if suffix in TIMED:
        changes += [lambda: shift_times(random, content, suffix)] * 2
    content = random.choice(changes)()
    return suffix, damage(random, content) if random.random() < 0.2 else content


def picture_case(random: Random, originals: Sequence[Path]) -> tuple[str, bytes]:
    """Return a picture: half have damaged bytes only, the others metadata or changed structure."""
    path = random.choice(originals)
    content, suffix = path.read_bytes(), path.suffix
    is_new = random.random() < 0.6 and suffix in FAMILIES
    if is_new and suffix in PLACERS:
        content = add_metadata(random, content, suffix)
    if is_new and random.random() < 0.5:
        donor = random.choice([each for each in originals if each.suffix == suffix]).read_bytes()
        content = restructure(random, content, FAMILIES[suffix], donor)
    return suffix, content if is_new and random.random() < 0.8 else damage(random, content)


def cache_case(random: Random) -> tuple[str, bytes]:
    """Return the seed of damage to a kernel cache, whose files differ between machines."""
    return ".cache", str(random.randrange(2**32)).encode()


KINDS: dict[str, Callable[..., tuple[str, bytes]]] = {
    "film": film_case,
    "picture": picture_case,
    "array": array_case,
    "style": style_case,
    "bank": bank_case,
    "subtitle": subtitle_case,
    "page": page_case,
    "cue": cue_case,
    "network": network_case,
    "people": people_case,
    "config": config_case,
    "cache": cache_case,
}
"""Functions that make a file of a kind."""
