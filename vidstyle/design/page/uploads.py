"""What is dropped on the page, a film, a picture or a style: it comes in parts, into a folder of its own."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from vidstyle.errors import InputError, OutputError, VidstyleError, output_error, printable
from vidstyle.preview.clip import Clip, FilmClip
from vidstyle.style.files import read_style_text
from vidstyle.web.messages import MessageError

if TYPE_CHECKING:
    from vidstyle.design.page.page_connection import PageConnection

_SAFE_SUFFIX = re.compile(r"\.\w{1,8}")


class FileUpload:
    """A file on its way."""

    def __init__(self, page: PageConnection, id: int, name: str, size: int) -> None:
        """`id`: of the message that announced it; `size`: in bytes."""
        self._page, self._id, self._missing = page, id, size
        self._name = printable(name)
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._file: BinaryIO | None = None
        self._error: OutputError | None = None

    def open(self) -> None:
        """Make the file, under another name than the user's, which may be any.

        Raises:
            OutputError: it cannot be made, or there is no room for it.
        """
        folder = Path(tempfile.gettempdir())
        if shutil.disk_usage(folder).free < self._missing:
            raise OutputError(self._name, f"does not fit into {folder}", "name it on the command line")
        self._folder = tempfile.TemporaryDirectory(prefix="vidstyle-")
        ending = Path(self._name).suffix
        path = Path(self._folder.name) / ("dropped" + (ending if _SAFE_SUFFIX.fullmatch(ending) else ""))
        try:
            self._file = path.open("xb")
        except OSError as error:
            self.drop()
            raise output_error(path, error) from error

    async def take(self, part: bytes) -> None:
        """Take a part; with the last one the file becomes the clip, or the page is told why it cannot.

        Raises:
            MessageError: it is larger than was announced.
        """
        assert self._file is not None
        if len(part) > self._missing:
            raise MessageError("upload: more than was announced")
        self._missing -= len(part)
        if self._error is None:  # what comes after it is on its way already
            try:
                await self._page.server.run(self._file.write, part)
            except OSError as error:
                self._error = output_error(self._name, error)
        if not self._missing:
            await self._page.answer(self._id, self._finish)

    def drop(self) -> None:
        """Remove what has come."""
        self._page.upload = None
        if self._file is not None:
            self._file.close()
        if self._folder is not None:
            self._folder.cleanup()

    async def _finish(self) -> None:
        assert self._file is not None and self._folder is not None
        if self._error is not None:
            self.drop()
            raise self._error
        self._file.close()
        if self._name.lower().endswith(".toml"):
            await self._open_style(Path(self._file.name))
            return
        folder, self._page.upload = self._folder, None
        try:
            with self._under_its_name():
                path = Path(self._file.name)
                clip: Clip = await self._page.server.run(UploadedClip, path, self._name, folder)
        except BaseException:
            folder.cleanup()
            raise
        await self._page.server.change_clip(clip)

    @contextmanager
    def _under_its_name(self) -> Iterator[None]:
        """Within it, errors of the file here are told of the user's."""
        assert self._file is not None
        try:
            yield
        except VidstyleError as error:
            if error.subject != printable(self._file.name):
                raise
            raise InputError(self._name, error.reason, error.remedy) from error

    async def _open_style(self, path: Path) -> None:
        """Open a style, whose text may be longer than a message."""
        server = self._page.server
        try:
            with self._under_its_name():
                text = await server.run(read_style_text, path)
            await server.run(server.designer.open_text, self._name, text)
        finally:
            self.drop()
        await server.changed()


class UploadedClip(FilmClip):
    """A clip whose file is removed with it."""

    def __init__(self, path: Path, name: str, folder: tempfile.TemporaryDirectory[str]) -> None:
        super().__init__(path, name)
        self.source = name
        self._path, self._folder = path, folder

    def file(self) -> str:
        """See `Clip`."""
        return str(self._path)

    def close(self) -> None:
        """See `Clip`."""
        super().close()
        self._folder.cleanup()
