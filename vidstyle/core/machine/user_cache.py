"""The user's cache folder, and a check whether other users could change its files."""

from __future__ import annotations

import atexit
import functools
import os
import shutil
import stat
import sys
import tempfile
from pathlib import Path

from vidstyle.errors import log


def user_cache() -> Path:
    """Return the user's cache folder of vidstyle; it is not created here, and perhaps not writable.

    Relative paths in the environment are ignored, as the XDG specification demands. A user without a home
    folder gets a temporary one.
    """
    chosen = (os.environ.get(each, "") for each in ("XDG_CACHE_HOME", "LOCALAPPDATA"))
    if folder := next(filter(os.path.isabs, chosen), ""):
        return Path(folder) / "vidstyle"
    home = os.path.expanduser("~")
    if not os.path.isabs(home):
        return _cache_without_home()
    return Path(home) / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "vidstyle"


@functools.cache
def temporary_cache() -> Path:
    """Return a folder that only this user may enter, removed when the program ends."""
    try:
        folder = Path(tempfile.mkdtemp(prefix="vidstyle-"))
    except OSError:
        return Path(os.devnull)  # nothing can be written there
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.cache
def _cache_without_home() -> Path:
    log.warning(
        "this user has no home folder, so the cache is removed at exit; "
        "set XDG_CACHE_HOME to a folder to keep it"
    )
    return temporary_cache()


def exposure_of(folder: Path) -> str:
    """Return why other users could put files into a folder, or an empty string.

    Every parent folder counts: a user who may change one of them can replace the next. Missing folders
    do not count, nor does Windows, where the user's profile is closed to others.
    """
    if not hasattr(os, "geteuid"):
        return ""
    ways = dict.fromkeys((folder, Path(os.path.realpath(folder))))
    return next(filter(None, map(_exposure_on_the_way, ways)), "")


def _exposure_on_the_way(folder: Path) -> str:
    user = os.geteuid()
    administrators = {0, os.stat("/").st_uid}  # in some containers, root has another number
    for each in [*reversed(folder.parents), folder]:
        try:
            status = each.stat()
        except OSError:
            return ""
        if status.st_uid != user and (each == folder or status.st_uid not in administrators):
            return f"{each} belongs to another user"
        keeps_entries = status.st_mode & stat.S_ISVTX and each != folder
        if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and not keeps_entries:
            return f"{each} is writable by other users"
        if status.st_uid == user and not status.st_mode & (stat.S_IXGRP | stat.S_IXOTH):
            return ""  # nobody else gets any further
    return ""
