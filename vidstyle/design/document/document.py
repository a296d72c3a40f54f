"""The style that is being built, with all that has been done to it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Hashable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vidstyle.design.document.content import Content, content_of
from vidstyle.design.document.edits import EDITS
from vidstyle.design.document.history import History
from vidstyle.errors import StyleError, UsageError
from vidstyle.style import LAYERS, Style, style_from_table

SNAPSHOT_SLOTS = ("a", "b")
"""Snapshots: contents that are kept aside for comparison."""
_STEP_PREFIX = re.compile(rf"({'|'.join(LAYERS)}) step (\d+)(?: \(\w+\))?: ")


@dataclass(frozen=True)
class Mistake:
    """A mistake of the style; `step`: the number of the step that has it, or None."""

    text: str
    step: int | None


class Document:
    """A style, its history, and what is wrong with it.

    Attributes:
        style: the style as it was when it was last without mistakes.
        mistakes: of the present content.
        revision: counts every change.
        folder: to which the paths in the style are relative; None allows no paths.
    """

    def __init__(self, style: Style, revision: int = 0) -> None:
        """`revision`: of what was open before, so that no two states have the same."""
        self.folder = style.folder
        self._numbers = itertools.count(1)
        content = content_of(style, self._new_number)
        self._history = History("open" if content.steps else "new", content)
        self._saved = content.table()
        self._snapshots: dict[str, Content] = {}
        self.revision = revision
        self.style = style
        self.mistakes: list[Mistake] = []
        self._check()

    @property
    def content(self) -> Content:
        return self._history.present.state

    @property
    def history(self) -> History[Content]:
        """The states of the content, with labels."""
        return self._history

    @property
    def snapshots(self) -> tuple[str, ...]:
        """The slots that are in use."""
        return tuple(self._snapshots)

    @property
    def is_changed(self) -> bool:
        """Whether there is something to save."""
        return self.content.table() != self._saved

    def edit(self, kind: str, gesture: Hashable = None, **values: Any) -> int | None:
        """Make an edit; returns the number of the step that is new, if there is one.

        Args:
            kind: a name in `EDITS`.
            gesture: edits of the same gesture, one after another, are undone together.
            values: the arguments of the edit.

        Raises:
            UsageError: the edit cannot be made; nothing has changed.
        """
        edited = EDITS[kind](self.content, self._new_number, **values)
        if edited.content != self.content:
            self._history.record(edited.content, edited.label, gesture)
            self._check()
        return edited.step

    def undo(self) -> None:
        """Take the last gesture back, if there is one."""
        self._moved(self._history.step(-1))

    def redo(self) -> None:
        """Do what was undone last, if anything was."""
        self._moved(self._history.step(1))

    def jump(self, entry: int) -> None:
        """Go to an entry of the history.

        Raises:
            UsageError: there is none of this number any more.
        """
        if not self._moved(self._history.jump(entry)):
            raise UsageError(f"entry {entry}", "is not in the history any more")

    def snapshot(self, slot: str) -> None:
        """Keep the present content aside."""
        self._snapshots[_known_slot(slot)] = self.content
        self.revision += 1

    def restore(self, slot: str) -> None:
        """Make a snapshot the present content, which can be undone.

        Raises:
            UsageError: there is no such snapshot.
        """
        if _known_slot(slot) not in self._snapshots:
            raise UsageError(f"snapshot {slot}", "has not been taken")
        self._history.record(self._snapshots[slot], f"snapshot {slot}")
        self._check()

    def valid_style(self) -> Style:
        """The style of the present content.

        Raises:
            StyleError: it has mistakes.
        """
        if self.mistakes:
            raise StyleError(self.content.fields.get("name", "style"), [each.text for each in self.mistakes])
        return self.style

    def mark_saved(self, folder: Path | None) -> None:
        """The present content is what the file holds, which lies in this folder."""
        self._saved = self.content.table()
        self.folder = folder
        self._check()

    def mark_changed(self) -> None:
        """No file holds the present content."""
        self._saved = {}

    def _new_number(self) -> int:
        return next(self._numbers)

    def _moved(self, content: Content | None) -> bool:
        if content is not None:
            self._check()
        return content is not None

    def _check(self) -> None:
        self.revision += 1
        table = self.content.table()
        self.mistakes = []
        try:
            self.style = style_from_table(table, "style", folder=self.folder)
        except StyleError as error:
            self.mistakes = list(map(self._mistake, error.mistakes))

    def _mistake(self, text: str) -> Mistake:
        found = _STEP_PREFIX.match(text)
        if not found:
            return Mistake(text, None)
        step = self.content.layers[found[1]][int(found[2]) - 1]
        return Mistake(text[found.end() :], step.number)


def _known_slot(slot: str) -> str:
    if slot not in SNAPSHOT_SLOTS:
        raise UsageError(slot, "is not a snapshot", f"there are {' and '.join(SNAPSHOT_SLOTS)}")
    return slot
