"""Uploads of films, pictures and styles, received in chunks into a temporary folder."""

from __future__ import annotations

import asyncio
import mimetypes
import re
import shutil
import sys
import tempfile
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from vidstyle.errors import InputError, OutputError, VidstyleError, output_error, printable
from vidstyle.gallery.preview import read_still
from vidstyle.preview.clip import Clip, FilmClip
from vidstyle.style.files import read_style_text
from vidstyle.web.messages import MessageError

_SAFE_SUFFIX = re.compile(r"\.\w{1,8}")
_UNSAFE_CHARACTERS = re.compile(r"[^\w-]+")
MAX_NAME_CHARACTERS = 50
"""Length of the temporary file's name, which comics have as their title."""


class FileUpload:
    """An upload in progress.

    Attributes:
        id: the number of the message that announced it.
        is_complete: whether all chunks have arrived.
    """

    def __init__(self, id: int, name: str, size: int) -> None:
        """Create the temporary file, under the letters and digits of the user's name, which is untrusted.

        Args:
            size: in bytes.

        Raises:
            OutputError: the file cannot be created, or the disk is full.
        """
        self.id, self._missing = id, size
        self._name = printable(name)
        self._error: OutputError | None = None
        folder = Path(tempfile.gettempdir())
        if shutil.disk_usage(folder).free < size:
            raise OutputError(self._name, f"does not fit into {folder}", "name it on the command line")
        self._folder = tempfile.TemporaryDirectory(prefix="vidstyle-")
        given = Path(_storable(self._name))
        stem = _UNSAFE_CHARACTERS.sub("-", given.stem)[:MAX_NAME_CHARACTERS].strip("-") or "dropped"
        ending = given.suffix if _SAFE_SUFFIX.fullmatch(given.suffix) else ""
        self._path = Path(self._folder.name) / f"{stem}{ending}"
        try:
            self._file = self._path.open("xb")
        except OSError as error:
            self._folder.cleanup()
            raise output_error(self._path, error) from error

    @property
    def is_complete(self) -> bool:
        return not self._missing

    def write(self, part: bytes) -> None:
        """Write a chunk.

        Raises:
            MessageError: the file is larger than announced.
        """
        if len(part) > self._missing:
            raise MessageError("upload: larger than announced")
        self._missing -= len(part)
        if self._error is not None:  # the remaining chunks are already being sent
            return
        try:
            self._file.write(part)
        except OSError as error:
            self._error = output_error(self._name, error)

    def drop(self) -> None:
        """Close and remove the file."""
        self._file.close()
        self._folder.cleanup()

    def open(self) -> Clip | tuple[str, str]:
        """Open the complete file: return the clip, or name and text of a style file.

        Raises:
            VidstyleError: the file could not be written, or is invalid. It has been removed.
        """
        with self._finished():
            if not self._name.lower().endswith(".toml"):
                return UploadedClip(self._path, self._name, self._folder)
            text = read_style_text(self._path)
        self.drop()
        return self._name, text

    def read_picture(self) -> np.ndarray:
        """Return the complete file as a picture, H x W x 3 uint8, of a film a frame of its middle; remove it.

        Raises:
            VidstyleError: the file could not be written, or is invalid. It has been removed.
        """
        with self._finished():
            picture = read_still(self._path)
        self.drop()
        return picture

    @contextmanager
    def _finished(self) -> Iterator[None]:
        """Close the file; on errors, remove it and name the file of the user instead of the temporary one."""
        try:
            if self._error is not None:
                raise self._error
            self._file.close()
            yield
        except BaseException as error:
            self.drop()
            if isinstance(error, VidstyleError) and error.subject == printable(self._path):
                raise InputError(self._name, *_explained(self._name, error)) from error
            raise


def _explained(name: str, error: VidstyleError) -> tuple[str, str]:
    """Return reason and remedy; if the ending is of another kind of file, the reason names that kind."""
    kind = (mimetypes.guess_type(name)[0] or "").partition("/")[0]
    if not error.reason.startswith("not a readable") or kind in ("", "video", "image", "audio"):
        return error.reason, error.remedy
    return "neither a film nor a photograph", "open a video, a picture or a style file (.toml)"


def _storable(name: str) -> str:
    """Return a name with "?" for letters that the file system cannot store; é is one letter."""
    encoding = sys.getfilesystemencoding()
    return unicodedata.normalize("NFC", name).encode(encoding, "replace").decode(encoding)


class UploadReceiver:
    """Receives the uploads of one browser, one after another."""

    def __init__(self) -> None:
        self._upload: FileUpload | None = None

    def announce(self, id: int, name: str, size: int) -> None:
        """Expect a file, which follows in chunks; arguments as for `FileUpload`.

        Raises:
            MessageError: another upload is in progress.
            OutputError: the file cannot be created, or the disk is full.
        """
        if self._upload is not None:
            raise MessageError("upload: another upload is in progress")
        self._upload = FileUpload(id, name, size)

    async def take(self, chunk: bytes) -> FileUpload | None:
        """Write a chunk; return the upload once it is complete.

        Raises:
            MessageError: no file was announced, or it is larger than announced.
        """
        upload = self._upload
        if upload is None:
            raise MessageError("a chunk without an upload")
        await asyncio.to_thread(upload.write, chunk)
        if not upload.is_complete:
            return None
        self._upload = None
        return upload

    def drop(self) -> None:
        """Remove what has arrived of an incomplete file."""
        if self._upload is not None:
            self._upload.drop()


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
