"""Plain English: documents, comments, docstrings and messages avoid phrases that stop a reader."""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

BETTER_WORDS = {
    r"\banew\b": "again",
    r"\b(?:is|are|was|were|be|been) told\b": "reported",
    r"\bsays? so\b": "reports it",
    r"\bis said\b": "is documented",
    r"\bthrow[ns]? out\b": "discarded",
    r"\btaken over\b": "reused",
    r"\b(?:hands?|handed) (?:on|over|back)\b": "passes, returns",
    r"\bgoes on\b": "continues",
    r"\bat hand\b": "available",
    r"\bso many\b": "N, that many",
    r"\bby as much\b": "by the same amount",
    r"\bwhat leaves\b": "the output of",
    r"\bstands? (?:in|on|beside|there)\b": "is in",
    r"\blies? beside\b": "is next to",
    r"\bas it was meant\b": "as intended",
    r"\b(?:its|their) kin\b": "similar ones",
    r"\bthe same of\b": "the same for",
    r"\bthat of (?:it|them)\b": "name the noun",
    r"\bwho(?:m)?ever\b|\bwhatever\b": "the caller, anyone who, every",
    r"\bof (?:its|their|our) own\b": "separate",
    r"\bmend(?:ed|s)?\b": "fix",
    r"\bwhere there (?:is|are) none\b": "if there is none",
}
"""Regular expressions of phrases to avoid, and the common words to write instead."""
ANY_PHRASE = re.compile("|".join(BETTER_WORDS), re.IGNORECASE)

FOLDERS = ("vidstyle", "tools", "tests", ".ci", "examples")
"""Folders with Python files."""
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def python_texts(source: str) -> Iterator[tuple[int, str]]:
    """Yield line number and text of comments and of strings that contain a space."""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and " " in token.string):
            yield token.start[0], token.string
    # From Python 3.12 on, tokens split f-strings.
    for node in ast.walk(ast.parse(source)) if sys.version_info >= (3, 12) else ():
        if isinstance(node, ast.JoinedStr):
            yield (
                node.lineno,
                "".join(str(each.value) for each in node.values if isinstance(each, ast.Constant)),
            )


def phrases(text: str) -> list[str]:
    """Return the phrases to avoid in a text whose lines may break anywhere, with the better words."""
    joined = " ".join(text.split())
    if not ANY_PHRASE.search(joined):
        return []
    found = ((match[0], words) for pattern, words in BETTER_WORDS.items()
             for match in re.finditer(pattern, joined, re.IGNORECASE))  # fmt: skip
    return [f"{phrase!r}: write {words!r}" for phrase, words in found]


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_a_document_has_no_phrase_to_avoid(path: Path) -> None:
    assert phrases(path.read_text(encoding="utf-8")) == []


def test_comments_docstrings_and_messages_have_no_phrase_to_avoid() -> None:
    files = sorted(path for name in FOLDERS for path in (ROOT / name).rglob("*.py") if path != Path(__file__))
    found = [
        f"{path.relative_to(ROOT)}:{line}: {phrase}"
        for path in files
        for line, text in python_texts(path.read_text(encoding="utf-8"))
        for phrase in phrases(text)
    ]
    assert files and found == []


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("Draw it anew.", 1),
        ("A notice\n    says so.", 1),
        ("The menu of a renewed canewood chair", 0),
        ("Anyone who reads this page continues.", 0),
    ],
)
def test_phrases_are_found_as_whole_words(text: str, count: int) -> None:
    assert len(phrases(text)) == count


def test_texts_of_python_files_are_comments_and_strings() -> None:
    source = 'anew = f"{1} is told" + "x y"  # thrown out\n'
    texts = " ".join(text for _, text in python_texts(source))
    assert len(phrases(texts)) >= 2 and "anew" not in texts
