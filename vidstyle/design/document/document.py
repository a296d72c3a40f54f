"""The open style with its history and mistakes."""

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
"""Slots for snapshots, which are kept for comparison."""
_STEP_PREFIX = re.compile(rf"({'|'.join(LAYERS)}) step (\d+)(?: \(\w+\))?: ")


@dataclass(frozen=True)
class Mistake:
    """A mistake in the style; `step`: the number of its step, or None."""

    text: str
    step: int | None


class Document:
    """A style, its history and its mistakes.

    Attributes:
        style: the last valid state of the style.
        opened_style: the style as opened.
        mistakes: the mistakes in the current content.
        start: the content as opened or saved.
        revision: the number of changes.
        folder: the base folder of relative paths; None forbids paths.
    """

    def __init__(self, style: Style, revision: int = 0) -> None:
        """`revision`: the revision of the document opened before, so that revisions stay unique."""
        self.folder = style.folder
        self._numbers = itertools.count(1)
        content = content_of(style, self._new_number)
        self._history = History("open" if content.steps else "new", content)
        self.start = content
        self._saved = content.table()
        self._snapshots: dict[str, Content] = {}
        self.revision = revision
        self.style = self.opened_style = style
        self.mistakes: list[Mistake] = []
        self._check()

    @property
    def content(self) -> Content:
        return self._history.present.state

    @property
    def history(self) -> History[Content]:
        """The labelled states of the content."""
        return self._history

    @property
    def snapshots(self) -> tuple[str, ...]:
        """The slots that are in use."""
        return tuple(self._snapshots)

    @property
    def is_changed(self) -> bool:
        """Whether there are unsaved changes."""
        return self.content.table() != self._saved

    def edit(self, kind: str, gesture: Hashable = None, **values: Any) -> int | None:
        """Make an edit; return the number of a new step, or None.

        Args:
            kind: a name in `EDITS`.
            gesture: consecutive edits with the same gesture are undone together.
            values: the arguments of the edit.

        Raises:
            UsageError: the edit is invalid; nothing has changed.
        """
        edited = EDITS[kind](self.content, self._new_number, **values)
        if edited.content != self.content:
            self._history.record(edited.content, edited.label, gesture)
            self._check()
        return edited.step

    def rename(self, name: str) -> None:
        """Give the style this name in all states: neither undo nor redo bring back another one.

        Raises:
            UsageError: the name is not a line of text.
        """
        self._history.change_all(
            lambda content: EDITS["rename"](content, self._new_number, name=name).content
        )
        self._check()

    def undo(self) -> None:
        """Undo the last gesture, if any."""
        self._check_after(self._history.step(-1))

    def redo(self) -> None:
        """Redo the last undone gesture, if any."""
        self._check_after(self._history.step(1))

    def jump(self, entry: int) -> None:
        """Go to an entry of the history.

        Raises:
            UsageError: the entry no longer exists.
        """
        if not self._check_after(self._history.jump(entry)):
            raise UsageError(f"entry {entry}", "is no longer in the history")

    def snapshot(self, slot: str) -> None:
        """Store the current content in a slot."""
        self._snapshots[_check_slot(slot)] = self.content
        self.revision += 1

    def restore(self, slot: str) -> None:
        """Restore a snapshot; this can be undone.

        Raises:
            UsageError: there is no such snapshot.
        """
        if _check_slot(slot) not in self._snapshots:
            raise UsageError(f"snapshot {slot}", "has not been taken")
        self._history.record(self._snapshots[slot], f"snapshot {slot}")
        self._check()

    def valid_style(self) -> Style:
        """Return the style of the current content.

        Raises:
            StyleError: the style is invalid.
        """
        if self.mistakes:
            raise StyleError(self.content.fields.get("name", "style"), [each.text for each in self.mistakes])
        return self.style

    def mark_saved(self, folder: Path | None) -> None:
        """Mark the current content as saved to a file in `folder`."""
        self.start = self.content
        self._saved = self.content.table()
        self.folder = folder
        self._check()

    def mark_changed(self) -> None:
        """Mark the current content as unsaved."""
        self._saved = {}

    def _new_number(self) -> int:
        return next(self._numbers)

    def _check_after(self, content: Content | None) -> bool:
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


def _check_slot(slot: str) -> str:
    if slot not in SNAPSHOT_SLOTS:
        raise UsageError(slot, "is not a snapshot", f"there are {' and '.join(SNAPSHOT_SLOTS)}")
    return slot
