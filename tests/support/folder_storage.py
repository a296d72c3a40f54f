"""Storage in a folder for all processes of a test; an entry point of fsspec registers it as `s3://`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from fsspec.implementations.dirfs import DirFileSystem
from fsspec.implementations.local import LocalFileSystem

ROOT, PERIOD = "TEST_STORAGE", "TEST_STORAGE_PERIOD"
"""Environment variables: the folder, and N to refuse every Nth write (0: none)."""


class FolderStorage(DirFileSystem):
    """A file system in a folder."""

    protocol = "s3"

    def __init__(self, **options: Any) -> None:
        super().__init__(path=os.environ[ROOT], fs=LocalFileSystem(), **options)

    def put_file(self, lpath: str, rpath: str, *rest: Any, mode: str = "overwrite", **options: Any) -> None:
        """Copy a local file to the storage, or raise ConnectionError for every Nth write."""
        log, period = Path(os.environ[ROOT] + ".writes"), int(os.environ[PERIOD])
        with log.open("a", encoding="utf-8") as file:
            print(rpath, file=file)
        if period and len(log.read_text(encoding="utf-8").splitlines()) % period == 0:
            raise ConnectionError("503 Slow Down")
        if mode == "create" and self.exists(rpath):
            raise FileExistsError(rpath)
        self.makedirs(str(Path(rpath).parent), exist_ok=True)
        super().put_file(lpath, rpath)


def install(folder: Path, root: Path, period: int = 0) -> dict[str, str]:
    """Return environment variables for processes with the storage in `root`; write metadata to `folder`."""
    about = folder / "folder_storage-1.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: folder-storage\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[fsspec.specs]\ns3 = folder_storage:FolderStorage\n")
    paths = os.pathsep.join([str(folder), str(Path(__file__).parent)])
    return {**os.environ, "PYTHONPATH": paths, ROOT: str(root), PERIOD: str(period)}
