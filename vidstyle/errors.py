"""What can go wrong, as exceptions: each names the thing, the reason and the remedy."""

from __future__ import annotations


class VidstyleError(Exception):
    """The base of all our errors; its text is one line: "thing: reason; remedy".

    Attributes:
        thing: what is concerned, a file or a parameter, with control characters escaped.
        reason: what is wrong with it.
        remedy: what would be right, or empty.
        exit_code: what the command line ends with (design, section 6).
    """

    exit_code = 1

    def __init__(self, thing: object, reason: str, remedy: str = "") -> None:
        self.thing = printable(thing)
        self.reason = printable(reason)
        self.remedy = printable(remedy)
        super().__init__(f"{self.thing}: {self.reason}" + (f"; {self.remedy}" if remedy else ""))


class UsageError(VidstyleError, ValueError):
    """What was asked for makes no sense, or would harm the user's own files."""

    exit_code = 2


class InputError(VidstyleError, OSError):
    """The input cannot be used."""

    exit_code = 3


class StyleError(VidstyleError, ValueError):
    """A style cannot be used; `mistakes` holds one line for each thing wrong with it."""

    exit_code = 3

    def __init__(self, thing: object, mistakes: list[str]) -> None:
        self.mistakes = [printable(mistake) for mistake in mistakes]
        super().__init__(thing, "; ".join(self.mistakes))


class OutputError(VidstyleError, OSError):
    """The output cannot be written, or not to its end."""

    exit_code = 5


class DeviceError(VidstyleError, OSError):
    """A camera or a GPU is missing or has been lost."""

    exit_code = 6


def printable(thing: object) -> str:
    r"""The thing as one line of text that cannot play tricks on a terminal.

    >>> printable("a\nb\x1b[31m")
    'a\\nb\\x1b[31m'
    """
    return "".join(
        character
        if character.isprintable()
        else character.encode("unicode_escape", "surrogatepass").decode("ascii")
        for character in str(thing)
    )
