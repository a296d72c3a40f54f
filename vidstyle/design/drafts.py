"""Drafts of unsaved styles, offered when the designer starts again."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.machine.user_cache import user_cache
from vidstyle.errors import UsageError, error_reason, log
from vidstyle.media.write.atomic import atomic_file

MAX_DRAFT_BYTES = 1 << 20
MAX_DRAFTS = 50
"""Drafts that are kept; a further one replaces the oldest."""


@dataclass(frozen=True)
class Draft:
    """An unsaved style.

    Attributes:
        path: the file of the draft.
        table: the style as the table of a style file.
        text: the text of its original file, for the comments; or None.
        file: the file to save the style to, or "".
        when: the time of the draft, ISO 8601.
        picture: the file name of the film or photograph that was open, or "".
        place: the working folder of the run, or "".
    """

    path: Path
    table: dict[str, Any]
    text: str | None
    file: str
    when: str
    picture: str = ""
    place: str = ""

    @property
    def is_here(self) -> bool:
        """Whether it was made in the present working folder."""
        return bool(self.place) and self.place == _working_folder()


class Drafts:
    """Stores drafts in files that are replaced atomically, at most `MAX_DRAFTS`.

    Attributes:
        offered: the drafts of earlier runs, and of styles that were open, newest first; without those that
            are unreadable.
    """

    def __init__(self, path: Path | None = None) -> None:
        """`path`: the first file; further ones get a number. None: in the user's cache folder."""
        first = path or user_cache() / "design-draft.json"
        self._paths = [first, *(first.with_stem(f"{first.stem}-{n}") for n in range(2, MAX_DRAFTS + 1))]
        self._own: Path | None = None
        self.offered: list[Draft] = []
        for draft in filter(None, map(_read_draft, self._paths)):
            self._offer(draft)

    def describe(self) -> dict[str, Any]:
        """Return the message that lists the drafts on the page."""
        return {"drafts": [_describe(draft) for draft in self.offered]}

    def at(self, place: int) -> Draft:
        """Return a draft by its place among those that are offered.

        Raises:
            UsageError: there is none.
        """
        if not 0 <= place < len(self.offered):
            raise UsageError("the draft", "no longer exists")
        return self.offered[place]

    def write(self, table: dict[str, Any], text: str | None, file: Path | None, picture: str = "") -> None:
        """Replace the draft of the open style; log a warning if that fails.

        Args:
            picture: see `Draft`.
        """
        when = datetime.now().astimezone().isoformat(timespec="milliseconds")
        facts = {"when": when, "picture": picture, "place": _working_folder()}
        content = json.dumps({"table": table, "text": text, "file": str(file or ""), **facts})
        try:
            path = self._own or self._free_path()
            path.parent.mkdir(0o700, parents=True, exist_ok=True)
            with atomic_file(path, overwrite=True) as write_file:
                write_file(content.encode())
            self._own = path
            self._withdraw(path)
        except (OSError, UsageError) as error:
            log.warning("the draft of the style cannot be saved: %s", error_reason(error))

    def _free_path(self) -> Path:
        free = next((path for path in self._paths if not path.exists()), None)
        return free or min(self._paths, key=lambda path: path.stat().st_mtime)

    def resume(self, draft: Draft) -> None:
        """Continue a draft that was offered as the draft of the open style."""
        self._own = draft.path
        self._withdraw(draft.path)

    def leave(self) -> None:
        """Offer the draft of the open style, if there is one."""
        own, self._own = self._own, None
        draft = _read_draft(own) if own else None
        if draft is not None:
            self._offer(draft)

    def remove(self) -> None:
        """Remove the draft of the open style, if there is one."""
        if self._own is not None:
            _remove_file(self._own)
        self._own = None

    def discard(self, draft: Draft) -> None:
        """Remove a draft that was offered."""
        _remove_file(draft.path)
        self._withdraw(draft.path)

    def _offer(self, draft: Draft) -> None:
        self.offered = sorted([*self.offered, draft], key=lambda each: each.when, reverse=True)

    def _withdraw(self, path: Path) -> None:
        self.offered = [draft for draft in self.offered if draft.path != path]


def _describe(draft: Draft) -> dict[str, Any]:
    facts = {"when": draft.when, "picture": draft.picture, "here": draft.is_here}
    return {"name": str(draft.table.get("name", "")), "folder": Path(draft.place).name} | facts


def _working_folder() -> str:
    """Return the working folder; "" if it was removed."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def _read_draft(path: Path) -> Draft | None:
    """Return a draft, or None if it is missing or unreadable."""
    try:
        draft = Draft(path, **json.loads(read_regular_file(path, MAX_DRAFT_BYTES)))
    except (OSError, ValueError, TypeError, RecursionError):
        return None
    texts = draft.text or "", draft.file, draft.when, draft.picture, draft.place
    return draft if isinstance(draft.table, dict) and all(isinstance(text, str) for text in texts) else None


def _remove_file(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        log.warning("the draft of the style cannot be removed: %s", error.strerror)
