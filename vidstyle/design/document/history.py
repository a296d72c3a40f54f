"""Undo and redo: one state of a document per gesture."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

S = TypeVar("S")
MAX_ENTRIES = 200


@dataclass(frozen=True)
class Entry(Generic[S]):
    """A state with its label.

    Attributes:
        number: a permanent number.
        gesture: consecutive changes with the same gesture share an entry; None shares with none.
    """

    number: int
    label: str
    state: S
    gesture: Hashable = None


class History(Generic[S]):
    """The states in chronological order, and the index of the current one.

    >>> history = History("opened", "a")
    >>> history.record("b", "typed", 1), history.record("c", "typed", 1), history.record("d", "cut", 2)
    (None, None, None)
    >>> history.step(-1), history.step(-1), history.step(-1), history.step(1)
    ('c', 'a', None, 'c')
    """

    def __init__(self, label: str, state: S) -> None:
        self.entries = [Entry(0, label, state)]
        self._place = self._number = 0

    @property
    def present(self) -> Entry[S]:
        return self.entries[self._place]

    @property
    def undo_label(self) -> str | None:
        """The label of the change that undo reverts, or None."""
        return self.present.label if self._place else None

    @property
    def redo_label(self) -> str | None:
        """The label of the change that redo applies, or None."""
        later = self.entries[self._place + 1 :]
        return later[0].label if later else None

    def record(self, state: S, label: str, gesture: Hashable = None) -> None:
        """Add a state; discard undone states, and the oldest above `MAX_ENTRIES`."""
        is_same = gesture is not None and gesture == self.present.gesture
        del self.entries[self._place + (0 if is_same else 1) :]
        self._number += 1
        self.entries.append(Entry(self._number, label, state, gesture))
        del self.entries[: max(0, len(self.entries) - MAX_ENTRIES)]
        self._place = len(self.entries) - 1

    def change_all(self, change: Callable[[S], S]) -> None:
        """Change the states of all entries; the current one, undo and redo stay."""
        self.entries = [replace(entry, state=change(entry.state)) for entry in self.entries]

    def step(self, by: int) -> S | None:
        """Undo (-1) or redo (1); return the new state, or None at the end."""
        if not 0 <= self._place + by < len(self.entries):
            return None
        return self._go(self._place + by)

    def jump(self, number: int) -> S | None:
        """Go to an entry by number; return its state, or None if it does not exist."""
        places = [place for place, entry in enumerate(self.entries) if entry.number == number]
        return self._go(places[0]) if places else None

    def _go(self, place: int) -> S:
        # Later changes start a new entry, even with the same gesture number.
        for each in (self._place, place):
            entry = self.entries[each]
            self.entries[each] = Entry(entry.number, entry.label, entry.state)
        self._place = place
        return self.present.state
