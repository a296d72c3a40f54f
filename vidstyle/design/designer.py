"""What the designer has open: a style with its file, and a clip; knows nothing of the page."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

from vidstyle.assets import asset_folder
from vidstyle.design.document.document import Document
from vidstyle.design.document.state import state_of
from vidstyle.design.drafts import Drafts
from vidstyle.errors import UsageError
from vidstyle.preview.clip import Clip
from vidstyle.preview.places import checked_path, refuse_existing
from vidstyle.style import (
    Style,
    load_style,
    save_style,
    style_file,
    style_from_table,
    style_names,
    table_from_style,
)
from vidstyle.style.check import TEXTS
from vidstyle.style.files import read_style_text, style_from_text
from vidstyle.style.panel import panel


class Designer:
    """A style that is being built, for one user. Its methods are called one at a time.

    Attributes:
        clip: what is restyled.
        folder: where the user started; files are written there, and styles beside their own file.
        document: the style; None until one is opened or begun.
        file: where it is saved; None if nowhere yet.
        offered: the draft of an earlier run.
    """

    def __init__(self, clip: Clip, folder: Path, drafts: Drafts) -> None:
        self.clip, self.folder = clip, folder
        self.document: Document | None = None
        self.file: Path | None = None
        self._drafts = drafts
        self.offered = drafts.read()
        self._text: str | None = None
        self._start: Style | None = None

    @property
    def state(self) -> dict[str, Any] | None:
        """The document as plain data, see `state_of`; None while nothing is open."""
        if self.document is None:
            return None
        return state_of(self.document) | {"file": self.file.name if self.file else ""}

    @property
    def opened(self) -> Document:
        """The document.

        Raises:
            UsageError: nothing is open.
        """
        if self.document is None:
            raise UsageError("the designer", "has no style open", "open one or begin a new one")
        return self.document

    @property
    def draft_offer(self) -> dict[str, str] | None:
        """What the page shows of the draft of an earlier run."""
        draft = self.offered
        return None if draft is None else {"name": str(draft.table.get("name", "")), "when": draft.when}

    def new(self) -> None:
        """Begin an empty style."""
        self._open(Style("new"), None, None)

    def open(self, style: str) -> None:
        """Open a style of the list.

        Raises:
            UsageError: it is not in the list.
            StyleError: it has mistakes.
        """
        if style not in style_names():
            raise UsageError(style, "is not in the list of styles")
        self.open_style(style)

    def open_style(self, style: str) -> None:
        """Open a style as `load_style` names it: shipped, the user's own, or in a file."""
        path = style_file(style)
        text = read_style_text(path) if path else None
        is_own = path is not None and not path.resolve().is_relative_to(asset_folder("styles").resolve())
        self._open(load_style(style), text, path if is_own else None)
        self._start = self.opened.style

    def open_text(self, name: str, text: str) -> None:
        """Open the text of a style file, which may not name files of its own.

        Raises:
            StyleError: it has mistakes.
        """
        style = style_from_text(text, Path(name), None)
        printed = "".join(filter(str.isprintable, style.name))[: TEXTS["name"]]
        self._open(replace(style, name=printed), text, None)
        self.opened.mark_changed()

    def open_draft(self, accept: bool) -> None:
        """Go on with the draft of an earlier run, or drop it.

        Raises:
            UsageError: there is none.
            StyleError: it can no longer be used.
        """
        draft, self.offered = self.offered, None
        if draft is None:
            raise UsageError("the draft", "is not there any more")
        if not accept:
            self._drafts.remove()
            return
        file = Path(draft.file) if draft.file else None
        folder = file.absolute().parent if file else None
        self._open(style_from_table(draft.table, "draft", folder=folder), draft.text, file)
        self.opened.mark_changed()

    def save(self) -> None:
        """Write the style to its file, whose comments stay.

        Raises:
            UsageError: it has no file yet, or another program has changed it.
            StyleError: it has mistakes.
            OutputError: it cannot be written.
        """
        if self.file is None:
            raise UsageError("the style", "has no file yet", "save it under a name")
        if self.file.exists() and read_style_text(self.file) != self._text:
            raise UsageError(self.file.name, "has been changed by another program", "save under another name")
        self._write(self.file)

    def save_as(self, name: str, overwrite: bool) -> None:
        """Write the style to a file of this name, beside its own or where the user started; it is called so.

        Raises:
            UsageError: the name is none, or taken.
            StyleError: the style has mistakes.
            OutputError: it cannot be written.
        """
        path = checked_path(self.file.parent if self.file else self.folder, name, ".toml")
        refuse_existing(path, overwrite)
        document = self.opened
        document.valid_style()
        document.edit("rename", name=path.stem)
        self._write(path)

    def export(self, kind: str, name: str, overwrite: bool) -> str:
        """Write the style as a page or a hook where the user started; returns the file's name.

        Raises:
            UsageError: the name is none, or taken.
            StyleError: the style has mistakes.
            OutputError: it cannot be written.
        """
        from vidstyle.export.export_style import export_style

        path = checked_path(self.folder, name, f".{kind}")
        refuse_existing(path, overwrite)
        export_style(self.opened.valid_style(), path, self.file, overwrite)
        return path.name

    def command(self) -> str:
        """The command that does the same.

        Raises:
            UsageError: the style has more than other values, and is not saved.
            StyleError: it has mistakes.
        """
        style, source = self.opened.valid_style(), self.clip.source
        if self._start is not None and _structure(style) == _structure(self._start):
            start = replace(self._start, name=str(self.file)) if self.file else self._start
            text = panel(replace(style, name=start.name), start)["text"]
        elif self.file is not None and not self.opened.is_changed:
            text = f"--style {shlex.quote(str(self.file))}"
        else:
            raise UsageError("the command", "needs the style in a file", "save it first")
        if self.clip.live:
            return f"vidstyle live {shlex.quote(source)} {text}"
        return f"vidstyle render {shlex.quote(source)} output{Path(source).suffix} {text}"

    def keep_draft(self) -> None:
        """Keep what is not saved."""
        document = self.document
        if document is None or not document.is_changed:
            return
        self._drafts.write(table_from_style(document.style), self._text, self.file)

    def _open(self, style: Style, text: str | None, file: Path | None) -> None:
        # The paths of a style that is saved elsewhere would lead nowhere.
        style = style if file else replace(style, folder=None)
        self.document = Document(style, self.document.revision if self.document else 0)
        self._text, self.file, self._start = text, file, None

    def _write(self, path: Path) -> None:
        document = self.opened
        style = document.valid_style()
        if self._text is None or document.is_changed or not path.exists():
            save_style(style, path, self._text)
        self._text, self.file = read_style_text(path), path
        document.mark_saved(path.absolute().parent)
        self._start = document.style
        self._drafts.remove()


def _structure(style: Style) -> tuple[object, ...]:
    """All but values."""
    return tuple(
        (layer, tuple((step.block, step.save, step.source, step.mute) for step in steps))
        for layer, steps in style.layers.items()
    )
