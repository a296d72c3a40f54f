"""Exceptions, which name their subject, the reason and the remedy if there is one; and the log of notices."""

from __future__ import annotations

import errno
import logging
import mmap
import re
from collections.abc import Iterable, Sequence

log = logging.getLogger("vidstyle")
"""Receives notices; the command line prints them."""


MAX_NAMES = 40
"""The most names in a list in a message."""
MAX_WORD = 200
"""Maximum length of a word for which similar names are suggested."""
_SENTENCE_PATTERN = re.compile(
    "(already|appeared|can|cannot|contains|does|exists|failed|fails|gave|has|holds|is|leaves|lies|needs|refuses"
    "|reports|took|was|wrote)\\b"
)
"""First words of reasons that form a sentence with the subject."""


_NO_MEMORY = re.compile(
    "cannot allocate memory|failed to map segment|can't (start new thread|allocate lock)|insufficient memory",
    re.I,
)
"""Messages of Python, the dynamic loader and OpenCV if memory is insufficient."""
_SPARE_BYTES = 1 << 28
"""Address space of a codec and its threads for a small picture: libx264 needs about 200 MB."""


class VidstyleError(Exception):
    """Base class of all errors; the text is one line: "subject: reason; remedy".

    A reason that begins with a verb makes a sentence with the subject, without a colon; one that names the
    subject in quotes stands without it in front.

    Attributes:
        subject: the file or parameter concerned, with control characters escaped.
        reason: the problem.
        remedy: what would be right, or empty.
        exit_code: exit status of the command line (docs/rules.md, exit codes).
    """

    exit_code = 1

    def __init__(self, subject: object, reason: str, remedy: str = "") -> None:
        self.subject = printable(subject)
        self.reason = printable(reason)
        self.remedy = printable(remedy)
        front = self.subject + (" " if _SENTENCE_PATTERN.match(self.reason) else ": ")
        if f"'{self.subject}'" in self.reason:
            front = ""
        super().__init__(f"{front}{self.reason}" + (f"; {self.remedy}" if remedy else ""))


class UsageError(VidstyleError, ValueError):
    """Invalid arguments, or a request that would damage the user's own files."""

    exit_code = 2


class InputError(VidstyleError, OSError):
    """The input cannot be used."""

    exit_code = 3


class StyleError(VidstyleError, ValueError):
    """A style cannot be used; `mistakes` holds one line for each mistake."""

    exit_code = 3

    def __init__(self, subject: object, mistakes: list[str]) -> None:
        self.mistakes = [printable(mistake) for mistake in mistakes]
        super().__init__(subject, "; ".join(self.mistakes))


class OutputError(VidstyleError, OSError):
    """The output cannot be written completely."""

    exit_code = 5


class DeviceError(VidstyleError, OSError):
    """A camera or a GPU is missing or has been lost."""

    exit_code = 6


def output_error(target: object, error: OSError, remedy: str = "") -> OutputError:
    """The error to report when the system refuses to write to a target."""
    reasons = {
        errno.ENOSPC: "the disk is full",
        errno.EDQUOT: "the disk quota is used up",
        errno.EFBIG: "the file size limit is reached",
        errno.EPIPE: "the reading program has closed the pipe",
        errno.EBADF: "it is closed",
        errno.EACCES: "no permission to write there",
        errno.EROFS: "the file system is read-only",
        errno.ENAMETOOLONG: "the name is too long",
    }
    reason = reasons.get(error.errno or 0) or error.strerror or str(error)
    return OutputError(target, f"cannot be written: {reason}", remedy)


def not_a_picture(given: object, wanted: str) -> UsageError:
    """The error for an argument of another type where a picture is taken."""
    remedy = f"give {wanted} (H x W x 3 or H x W x 4, RGB); vidstyle.render takes files"
    return UsageError("picture", f"{given!r:.60} is of type {type(given).__name__}", remedy)


def error_reason(error: Exception) -> str:
    """What the system or FFmpeg says about an error, without the name of the file."""
    return str(getattr(error, "strerror", None) or error)


def is_out_of_memory(error: BaseException | None) -> bool:
    """Whether an error, or one that it follows from, says that memory is lacking, also for a thread.

    >>> is_out_of_memory(RuntimeError("can't start new thread")), is_out_of_memory(RuntimeError("no"))
    (True, False)
    """
    while error is not None:
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        if not isinstance(error, VidstyleError) and _NO_MEMORY.search(str(error)):
            return True
        # Compiled libraries forget to say what failed.
        if isinstance(error, SystemError) and is_memory_short():
            return True
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    return False


def is_memory_short() -> bool:
    """Whether the system refuses this process another 256 MiB, as it does where `ulimit -v` is low."""
    try:
        mmap.mmap(-1, _SPARE_BYTES).close()
    except OSError:
        return True
    return False


def printable(value: object) -> str:
    r"""The value as one line of text, control characters escaped.

    >>> printable("a\nb\x1b[31m")
    'a\\nb\\x1b[31m'
    """
    return "".join(
        character
        if character.isprintable()
        else character.encode("unicode_escape", "surrogatepass").decode("ascii")
        for character in str(value)
    )


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural if it is not 1.

    >>> counted(1, "frame"), counted(0, "frame")
    ('1 frame', '0 frames')
    """
    return f"{number} {noun}{'s' * (number != 1)}"


def text_of_name(name: str) -> str:
    r"""Return a name from the command line or the file system as text that every document can hold.

    The bytes of a name count as UTF-8, also where the locale has made lone surrogates of them; U+FFFD stands
    for others.

    >>> ascii(text_of_name("\udcc3\udca4\udcff"))
    "'\\xe4\\ufffd'"
    """
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def suggest(word: str, names: Iterable[str]) -> str:
    """A suggestion for an unknown name: the most similar one, or else all of them.

    >>> suggest("levls", ["levels", "smooth"])
    "did you mean 'levels'?"
    >>> suggest("colour", ["levels", "smooth"])
    'there are levels, smooth'
    """
    from difflib import get_close_matches

    names = list(names)
    similar = get_close_matches(word.lower()[:MAX_WORD], names, n=1)
    if similar:
        return f"did you mean {similar[0]!r}?"
    return f"there are {join_names(names)}" if names else "there are none"


def join_names(names: Sequence[str], separator: str = ", ") -> str:
    """The names as a list in a message, shortened if there are many.

    >>> join_names(["a", "b"], " or ")
    'a or b'
    """
    rest = len(names) - MAX_NAMES
    return separator.join(names[:MAX_NAMES]) + (f" and {rest} more" if rest > 0 else "")
