"""The folder with the plan and the segments of a film: a batch uses and removes only folders of batches.

The names of these folders are known in advance, so anything may have one. A folder belongs to a batch if
its lock file has the right content; it gets its name together with this file.
"""

from __future__ import annotations

import os
import secrets
import shutil
import stat
from contextlib import suppress
from pathlib import Path

from vidstyle.core.file_checks import open_regular_file
from vidstyle.errors import OutputError, output_error
from vidstyle.media.write.temporary_files import TOKEN_BYTES, FileLock, create_file

LOCK_NAME = "lock"
OWNER = b"A folder of vidstyle batch, which removes it.\n"
"""The content of the lock file."""


def is_scratch(folder: Path) -> bool:
    """Whether a batch of this user has created a folder; a link to one does not count."""
    try:
        with open_regular_file(folder / LOCK_NAME, follows=False) as file:
            return _is_own(folder) and file.read(len(OWNER) + 1) == OWNER
    except (OSError, ValueError):
        return False


def lock_scratch(folder: Path) -> FileLock:
    """Lock a folder, which is created if there is none.

    Raises:
        BlockingIOError: another batch has it, or has just removed it.
        OutputError: the folder cannot be created, or something else has its name.
    """
    path = folder / LOCK_NAME
    try:
        if not os.path.lexists(folder):
            _create(folder)
        if not is_scratch(folder) and os.path.lexists(folder):
            raise OutputError(folder, "was not created by vidstyle batch for this user", "move it away")
        lock = FileLock(path)
    except OutputError:
        raise
    except (BlockingIOError, FileNotFoundError) as error:
        raise BlockingIOError from error
    except OSError as error:
        raise output_error(folder, error) from error
    if not lock.identity.is_at(path):
        lock.release()
        raise BlockingIOError
    return lock


def remove_folder(folder: Path) -> None:
    """Remove a folder that a batch has created and that no other batch has locked, as far as possible."""
    if not is_scratch(folder):
        return
    with suppress(OSError):
        for path in folder.iterdir():
            if path.name != LOCK_NAME:
                shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
        # Under another name, so that none sees it without its lock.
        folder.rename(place := _new_path(folder))
        shutil.rmtree(place, ignore_errors=True)


def _is_own(folder: Path) -> bool:
    """Whether it is a folder of this user, in which nobody else can have put segments."""
    status = folder.lstat()
    return stat.S_ISDIR(status.st_mode) and (not hasattr(os, "geteuid") or status.st_uid == os.geteuid())


def _create(folder: Path) -> None:
    """Create a folder with its lock file, unless something has its name."""
    place = _new_path(folder)
    place.mkdir()
    try:
        create_file(place / LOCK_NAME, OWNER)
        place.rename(folder)
    except OSError:
        shutil.rmtree(place, ignore_errors=True)
        if not os.path.lexists(folder):
            raise


def _new_path(folder: Path) -> Path:
    """Return a random path that begins like the path of a folder."""
    return folder.with_name(f"{folder.name}-{secrets.token_hex(TOKEN_BYTES)}")
