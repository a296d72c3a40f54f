"""Search for blocks and values by the words that people use for them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from vidstyle.block import CATEGORIES, Block, Parameter
from vidstyle.errors import suggest

SPELLINGS = {"b&w": "black and white", "&": "and", "colour": "color", "grey": "gray", "-": " ", "_": " "}
"""Spellings that are the same in a search."""
FILLERS = frozenset("a an and by in it less like look make more much of on the to very with".split())
"""Words that say nothing about a block, unless there is no other word."""
ENDINGS = re.compile(r"(?:ness|(?<=[sc]h)es|s|ier|ing|ish|er|ed|ly|y)$")
"""Endings that a search ignores."""
MIN_STEM_LENGTH = 3
BEST_NAME_COUNT = 3
"""Number of texts that count most: label, name and the first alias."""
MAX_NAME_RANK = 4
"""The last rank of a match in the label, name or aliases of a block."""


def find_blocks(text: str, blocks: Mapping[str, Block]) -> list[str]:
    """Return the names of the blocks that a text describes, best match first; all for an empty text.

    >>> from vidstyle.blocks import all_blocks
    >>> find_blocks("outline", all_blocks())[0], find_blocks("Grey scale", all_blocks())
    ('flow_xdog', ['to_gray'])
    """
    return _ranked(text, {name: tuple(_texts_of_block(block)) for name, block in blocks.items()})


def find_values(text: str, values: Mapping[str, Parameter]) -> list[str]:
    """Return the names of the values that a text describes, best match first.

    >>> from vidstyle.style.model import FIELDS
    >>> find_values("flicker", FIELDS)
    ['steady']
    """
    return _ranked(text, {name: tuple(_texts_of_value(value)) for name, value in values.items()})


def is_named(text: str, blocks: Mapping[str, Block], values: Mapping[str, Parameter]) -> bool:
    """Return whether a label, name or alias has all words of a text; otherwise results are only similar.

    >>> from vidstyle.blocks import all_blocks
    >>> is_named("sharpen", all_blocks(), {}), is_named("velvet", all_blocks(), {})
    (True, False)
    """
    asked = _normal(text).strip()
    texts = [*map(_texts_of_block, blocks.values()), *map(_texts_of_value, values.values())]
    labels = (value.label for block in blocks.values() for value in block.parameters.values())
    return any(_rank(asked, [names]) is not None for names in (*map(next, texts), *labels))


def is_value_name(value: Parameter, text: str, block: Block | None) -> bool:
    """Whether a text is a name of this value, and not of the block that it describes best.

    >>> from vidstyle.blocks import all_blocks
    >>> from vidstyle.style.model import FIELDS
    >>> [is_value_name(FIELDS["paper"], text, all_blocks()["noise"]) for text in ("paper", "noise", "canvas")]
    [True, False, False]
    """
    names = (value.label, value.name, *value.control.aliases)
    return is_described_by(text, names) and not (block and _is_name(text, block))


def suggest_block(name: str, blocks: Mapping[str, Block]) -> str:
    """Return a suggestion for an unknown block: the most similar name, or what the word describes.

    >>> from vidstyle.blocks import all_blocks
    >>> suggest_block("grayscale", all_blocks()), suggest_block("halftoon", all_blocks())
    ("did you mean 'to_gray'?", "did you mean 'halftone'?")
    >>> suggest_block("xyz", all_blocks())
    '`vidstyle blocks` lists all'
    """
    found = find_blocks(name, blocks) if name.strip() else []
    similar = suggest(name, blocks)
    if similar.startswith("did") and not (found and _is_name(name, blocks[found[0]])):
        return similar
    return f"did you mean {found[0]!r}?" if found else "`vidstyle blocks` lists all"


def is_described_by(text: str, names: Sequence[str]) -> bool:
    """Whether a text is one of these names, in any spelling and without filler words."""
    return any(_is_same(_without_fillers(text), _without_fillers(name)) for name in names)


def _without_fillers(text: str) -> str:
    return " ".join(word for word in _normal(text).split() if word not in FILLERS)


def _is_name(text: str, block: Block) -> bool:
    return any(_is_same(_normal(text), _normal(name)) for name in (block.label, *block.aliases))


def _texts_of_block(block: Block) -> Iterator[str]:
    """Yield the texts to search, most important first: names, then each kind of description."""
    yield "\n".join((block.label, block.name, *block.aliases))
    yield "\n".join(parameter.label for parameter in block.parameters.values())
    yield f"{block.help}\n{CATEGORIES[block.category]}"


def _texts_of_value(value: Parameter) -> Iterator[str]:
    yield "\n".join((value.label, value.name, *value.control.aliases))
    yield value.control.help


def _ranked(text: str, texts: dict[str, tuple[str, ...]]) -> list[str]:
    asked = _normal(text).strip()
    ranks = {name: _rank(asked, each) for name, each in texts.items()}
    found = {name: rank for name, rank in ranks.items() if rank is not None}
    if min(found.values(), default=MAX_NAME_RANK + 1) > MAX_NAME_RANK:
        found = _ranked_by_word(asked, texts) | found
    return sorted(found, key=lambda name: (found[name], name))


def _ranked_by_word(asked: str, texts: Mapping[str, Sequence[str]]) -> dict[str, float]:
    """Rank the names whose texts have any of the words, or words of the same stem: most words first."""
    words = [word for word in asked.split() if word not in FILLERS] or asked.split()
    stems = [stem for stem in map(_stem, words) if len(stem) >= MIN_STEM_LENGTH]
    counts = {name: sum(_rank(stem, each) is not None for stem in stems) for name, each in texts.items()}
    return {name: MAX_NAME_RANK + 1 - count for name, count in counts.items() if count}


def _stem(word: str) -> str:
    """Return a word without its ending.

    >>> [_stem(word) for word in ("smoothing", "brighter", "blurry", "brushes", "lines", "ink")]
    ['smooth', 'bright', 'blur', 'brush', 'line', 'ink']
    """
    stem = ENDINGS.sub("", word)
    if len(stem) < MIN_STEM_LENGTH:
        return word
    return stem[:-1] if stem != word and stem[-1] == stem[-2] else stem


def _rank(asked: str, texts: Sequence[str]) -> float | None:
    """Return how well texts match, 0 for best, or None: names that are, begin with or contain all words.

    The first text holds label, name and aliases, one per line, the most fitting first.
    """
    names = _normal(texts[0]).split("\n")
    if _is_same(asked, names[0]):
        return 0
    same = [place for place, name in enumerate(names) if _is_same(asked, name)]
    if same and same[0] < BEST_NAME_COUNT:
        return 1 + (same[0] - 1) / len(names)
    if same:
        return 2 + same[0] / len(names)
    if f"{names[0]} ".startswith(f"{asked} "):
        return 1.9
    if names[0].startswith(asked):
        return 3
    wanted = [_singular(word) for word in asked.split()]
    for place, text in enumerate(texts):
        words = re.findall(r"\w+", _normal(text))
        if all(any(word.startswith(each) for word in words) for each in wanted):
            return 4 + place
    return None


def _is_same(asked: str, name: str) -> bool:
    return (
        asked == name
        or _singular(asked) == _singular(name)
        or asked.replace(" ", "") == name.replace(" ", "")
    )


def _singular(word: str) -> str:
    return word[:-1] if len(word) > 3 and word.endswith("s") else word


def _normal(text: str) -> str:
    text = text.lower()
    for spelling, same in SPELLINGS.items():
        text = text.replace(spelling, same)
    return text
