"""Files that are written in one go: they are there whole, or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from vidstyle.errors import UsageError
from vidstyle.media.partial import PartialFile, is_plain_file, output_error


@contextmanager
def whole_file(
    target: Path, source: str | Path | None = None, overwrite: bool = False
) -> Iterator[Callable[[bytes], None]]:
    """Checks at its start that the target may be written; what is called within the block writes its content.

    The target has its name when the block ends; when it raises, nothing is left.

    Raises:
        UsageError: the target is the source, exists, or is no file.
        OutputError: it cannot be written.
    """
    if not is_plain_file(target):
        raise UsageError(target, "is a device or a pipe", "name a file")
    file = PartialFile(target, source, overwrite)

    def write(content: bytes) -> None:
        try:
            file.path.write_bytes(content)
            file.check_space()
            file.finish()
        except OSError as error:
            raise output_error(target, error) from error

    try:
        yield write
    finally:
        file.remove()
