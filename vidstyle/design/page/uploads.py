"""Uploads of films, pictures and styles, received in chunks into a temporary folder."""

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
    """An upload in progress."""

    def __init__(self, page: PageConnection, id: int, name: str, size: int) -> None:
        """`id`: the id of the message that announced it; `size`: in bytes."""
        self._page, self._id, self._missing = page, id, size
        self._name = printable(name)
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._file: BinaryIO | None = None
        self._error: OutputError | None = None

    def open(self) -> None:
        """Create the temporary file, not under the name of the user, which is untrusted.

        Raises:
            OutputError: the file cannot be created, or the disk is full.
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
        """Write a chunk; open the file after the last one, and answer the upload.

        Raises:
            MessageError: the file is larger than announced.
        """
        assert self._file is not None
        if len(part) > self._missing:
            raise MessageError("upload: larger than announced")
        self._missing -= len(part)
        if self._error is None:  # the remaining chunks are already being sent
            try:
                await self._page.server.run(self._file.write, part)
            except OSError as error:
                self._error = output_error(self._name, error)
        if not self._missing:
            await self._page.answer(self._id, self._finish)

    def drop(self) -> None:
        """Cancel the upload and remove its file."""
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
            with self._with_user_name():
                path = Path(self._file.name)
                clip: Clip = await self._page.server.run(UploadedClip, path, self._name, folder)
        except BaseException:
            folder.cleanup()
            raise
        await self._page.server.change_clip(clip)

    @contextmanager
    def _with_user_name(self) -> Iterator[None]:
        """Report errors under the file name of the user instead of the temporary one."""
        assert self._file is not None
        try:
            yield
        except VidstyleError as error:
            if error.subject != printable(self._file.name):
                raise
            raise InputError(self._name, error.reason, error.remedy) from error

    async def _open_style(self, path: Path) -> None:
        """Open a style file."""
        server = self._page.server
        try:
            with self._with_user_name():
                text = await server.run(read_style_text, path)
            await server.run(server.designer.open_text, self._name, text)
        finally:
            self.drop()
        await server.changed()


class UploadedClip(FilmClip):
    """A clip that removes its file when it is closed."""

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
