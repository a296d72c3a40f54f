"""Drafts of unsaved styles, offered when the designer starts again."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.machine.user_cache import user_cache
from vidstyle.errors import UsageError, error_reason, log
from vidstyle.media.write.atomic import atomic_file

MAX_DRAFT_BYTES = 1 << 20


@dataclass(frozen=True)
class Draft:
    """An unsaved style.

    Attributes:
        table: the style as the table of a style file.
        text: the text of its original file, for the comments; or None.
        file: the file to save to, or "".
        when: the time of the draft, ISO 8601.
    """

    table: dict[str, Any]
    text: str | None
    file: str
    when: str


class Drafts:
    """Stores a draft in a file, which is replaced atomically."""

    def __init__(self, path: Path | None = None) -> None:
        """`path`: the file; None: in the user's cache folder."""
        self._path = path or user_cache() / "design-draft.json"

    def read(self) -> Draft | None:
        """Return the draft of an earlier run, or None if it is missing or unreadable."""
        try:
            draft = Draft(**json.loads(read_regular_file(self._path, MAX_DRAFT_BYTES)))
        except (OSError, ValueError, TypeError, RecursionError):
            return None
        fields = (draft.table, dict), (draft.text or "", str), (draft.file, str), (draft.when, str)
        return draft if all(isinstance(value, kind) for value, kind in fields) else None

    def write(self, table: dict[str, Any], text: str | None, file: Path | None) -> None:
        """Replace the draft; log a warning if that fails."""
        when = datetime.now().astimezone().isoformat(timespec="seconds")
        content = json.dumps(asdict(Draft(table, text, str(file or ""), when)))
        try:
            self._path.parent.mkdir(0o700, parents=True, exist_ok=True)
            with atomic_file(self._path, overwrite=True) as write_file:
                write_file(content.encode())
        except (OSError, UsageError) as error:
            log.warning("the draft of the style cannot be saved: %s", error_reason(error))

    def remove(self) -> None:
        """Remove the draft."""
        try:
            self._path.unlink(missing_ok=True)
        except OSError as error:
            log.warning("the draft of the style cannot be removed: %s", error.strerror)
