"""The state of the designer: the open style with its file, and the clip. Independent of the page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from vidstyle.assets import asset_folder
from vidstyle.design.command_line import command_line, look_options
from vidstyle.design.document.document import Document
from vidstyle.design.document.state import state_of
from vidstyle.design.drafts import Drafts
from vidstyle.design.style_list import list_styles
from vidstyle.errors import UsageError
from vidstyle.preview.clip import Clip, DemoClip
from vidstyle.preview.outputs import output_path
from vidstyle.style import (
    Style,
    load_style,
    save_style,
    style_file,
    style_from_table,
    table_from_style,
)
from vidstyle.style.check import TEXTS
from vidstyle.style.files import read_style_text, style_from_text

CUE_FILE = "cues.toml"
"""The name under which the page saves the cues of a film."""


class Designer:
    """The open style and clip of one user. Not thread-safe: call one method at a time.

    Attributes:
        clip: the film or photograph to restyle.
        folder: the working folder, for all output but styles that already have a file.
        document: the style; None until one is opened or created.
        file: the file of the style, or None.
        drafts: of the open style, and of those before.
    """

    def __init__(self, clip: Clip, folder: Path, drafts: Drafts) -> None:
        self.clip, self.folder = clip, folder
        self.document: Document | None = None
        self.file: Path | None = None
        self.drafts = drafts
        self._text: str | None = None
        self._start: Style | None = None

    @property
    def state(self) -> dict[str, Any] | None:
        """The document as plain data, see `state_of`; None if no style is open."""
        if self.document is None:
            return None
        return state_of(self.document) | {"file": self.file.name if self.file else ""}

    @property
    def opened(self) -> Document:
        """The document.

        Raises:
            UsageError: no style is open.
        """
        if self.document is None:
            raise UsageError("the designer", "has no style open", "open one or begin a new one")
        return self.document

    def new(self) -> None:
        """Create an empty style."""
        self._open(Style("new"), None, None)

    def open(self, style: str) -> None:
        """Open a style of the list.

        Raises:
            UsageError: it is not in the list.
            StyleError: it has mistakes.
        """
        listed = list_styles(self.folder)
        if style not in listed:
            raise UsageError(style, "is not in the list of styles")
        self.open_style(listed[style])

    def open_style(self, style: str) -> None:
        """Open a style by name or file, see `load_style`."""
        path = style_file(style)
        text = read_style_text(path) if path else None
        is_own = path is not None and not path.resolve().is_relative_to(asset_folder("styles").resolve())
        self._open(load_style(style), text, path if is_own else None)
        self._start = self.opened.style

    def open_text(self, name: str, text: str) -> None:
        """Open the text of a style file, which must not refer to other files.

        Raises:
            StyleError: the style is invalid.
        """
        style = style_from_text(text, Path(name), None)
        printed = "".join(filter(str.isprintable, style.name))[: TEXTS["name"]]
        self._open(replace(style, name=printed), text, None)
        self.opened.mark_changed()

    def open_draft(self, accept: bool, place: int = 0) -> None:
        """Open a draft, or discard it.

        Args:
            place: among those that are offered.

        Raises:
            UsageError: there is no draft.
            StyleError: the draft is invalid.
        """
        draft = self.drafts.at(place)
        if not accept:
            self.drafts.discard(draft)
            return
        file = Path(draft.file) if draft.file else None
        folder = file.absolute().parent if file else None
        self._open(style_from_table(draft.table, "draft", folder=folder), draft.text, file)
        self.drafts.resume(draft)
        self.opened.mark_changed()

    def save(self) -> str:
        """Save the style to its file; comments are kept; return the path.

        Raises:
            UsageError: the style has no file, or another program has changed the file.
            StyleError: the style is invalid.
            OutputError: the file cannot be written.
        """
        if self.file is None:
            raise UsageError("the style", "has no file yet", "save it under a name")
        if self.file.exists() and read_style_text(self.file) != self._text:
            raise UsageError(self.file.name, "has been changed by another program", "save under another name")
        return self._write(self.file)

    def save_as(self, name: str, overwrite: bool) -> str:
        """Save the style under another name, in the folder of its file or in the working folder.

        Returns:
            The path.

        Raises:
            UsageError: the name is invalid, or the file exists.
            StyleError: the style is invalid.
            OutputError: the file cannot be written.
        """
        path = output_path(self.file.parent if self.file else self.folder, name, ".toml", overwrite)
        document = self.opened
        document.valid_style()
        document.rename(path.stem)
        return self._write(path)

    def export(self, kind: str, name: str, overwrite: bool) -> str:
        """Export the style to the working folder; return the path.

        Args:
            kind: of `EXPORT_TARGETS`.

        Raises:
            UsageError: the name is invalid, or the file exists.
            StyleError: the style is invalid.
            OutputError: the file cannot be written.
        """
        from vidstyle.export.export_style import export_style

        path = output_path(self.folder, name, f".{kind}", overwrite)
        export_style(self.opened.valid_style(), path, self.file, overwrite)
        return str(path)

    def command(self, name: str = "", frames: int | None = None, has_cues: bool = False) -> str:
        """Return the equivalent command line.

        Args:
            name: the file to write; empty for a default.
            frames: the number of frames to render; None or 0 for all.
            has_cues: whether the film has cues, which the page saves as `CUE_FILE`.

        Raises:
            UsageError: more than values have changed, and the style is not saved.
            StyleError: the style is invalid.
        """
        style = self.opened.valid_style()
        if has_cues:
            look = f"--cues {CUE_FILE}"
        else:
            look = look_options(style, self._start, self.file, not self.opened.is_changed)
        return command_line(self.clip, look, name, frames)

    def keep_draft(self) -> None:
        """Save unsaved changes as a draft; if there are none any more, remove it."""
        document = self.document
        if document is None or not document.is_changed:
            self.drafts.remove()
        else:
            picture = "" if isinstance(self.clip, DemoClip) else Path(self.clip.name).name
            self.drafts.write(table_from_style(document.style), self._text, self.file, picture)

    def _open(self, style: Style, text: str | None, file: Path | None) -> None:
        self.keep_draft()
        self.drafts.leave()
        # Relative paths would be wrong for a style that is saved elsewhere.
        style = style if file else replace(style, folder=None)
        self.document = Document(style, self.document.revision if self.document else 0)
        self._text, self.file, self._start = text, file, None

    def _write(self, path: Path) -> str:
        document = self.opened
        style = document.valid_style()
        if self._text is None or document.is_changed or not path.exists():
            save_style(style, path, self._text)
        self._text, self.file = read_style_text(path), path
        document.mark_saved(path.absolute().parent)
        self._start = document.style
        self.drafts.remove()
        return str(path)
