"""Reads files from untrusted sources: regular files of limited size, and TOML (styles, comics, options).

Limits of TOML are checked before tomllib sees the text: it recurses for nested values, and takes quadratic
time and memory for dotted keys.
"""

from __future__ import annotations

import os
import re
import stat
import tomllib
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Any, Literal

from vidstyle.errors import error_reason

MAX_NESTING = 16
"""Maximum number of arrays and inline tables around a value, and of dots in a key."""

_TOKEN = re.compile(
    r'''
    """ [^"\\]* (?: (?: \\. | "(?!"") ) [^"\\]* )* (?: "{3,5} | \\?\Z )
    | \'\'\' [^']* (?: '(?!'') [^']* )* (?: '{3,5} | \Z )
    | " [^"\\\n]* (?: \\[^\n]? [^"\\\n]* )* "?
    | ' [^'\n]* '?
    | \# [^\n]*
    | (?P<open> [\[{] )
    | (?P<close> [\]}] )
    | (?P<dot> \. )
    | (?P<end> [=,\n] )
    | (?P<integer> (?<![\w.+-]) [+-]?
        (?: 0x\w{17} | 0o\w{23} | 0b\w{65} | \d(?:_?\d){19,}+ (?! \.\d | [eE][+-]?\d ) ) )
    ''',
    re.DOTALL | re.VERBOSE,
)
"""Parts of a TOML text that count towards a limit; strings and comments, which do not, have no name.

Every alternative for strings matches to the end of the text if need be, so that the scan takes linear time.
"""


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """Return the content of a file; pipes and devices, which may never end, are refused.

    Raises:
        ValueError: it is no regular file, or larger than `max_bytes`.
        OSError: it cannot be read.
    """
    with open_regular_file(path) as file:
        content = file.read(max_bytes + 1)
    if len(content) > max_bytes:
        raise ValueError(f"is larger than {max_bytes >> 10} KiB")
    return content


def open_regular_file(
    path: Path, mode: Literal["rb", "ab"] = "rb", follows: bool = True
) -> FileIO | BufferedReader:
    """Open a file that is no pipe and no device, which may never end.

    Args:
        follows: whether it may be a link.

    Raises:
        ValueError: it is no regular file.
        OSError: it cannot be opened, or is a link and must not be.
    """

    def opener(path: str, flags: int) -> int:
        # Otherwise opening a pipe would wait for its other end.
        flags |= getattr(os, "O_NONBLOCK", 0) | (0 if follows else getattr(os, "O_NOFOLLOW", 0))
        return os.open(path, flags, 0o666)

    file: FileIO | BufferedReader
    file = open(path, "ab", buffering=0, opener=opener) if mode == "ab" else open(path, "rb", opener=opener)
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise ValueError("is not a file")
    return file


def read_toml_text(path: Path, max_bytes: int) -> str:
    """Return the text of a file.

    Raises:
        ValueError: the file cannot be read, is not a regular file, is larger than `max_bytes`, or is not
            UTF-8; the message says which, without the name of the file.
    """
    try:
        content = read_regular_file(path, max_bytes)
    except OSError as error:
        raise ValueError(f"cannot be read: {error_reason(error)}") from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(f"line {line} is not UTF-8 text; save the file as UTF-8") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of a TOML text; its integers have about 64 bits at most.

    Raises:
        ValueError: it is not TOML, or nested deeper than `MAX_NESTING`; the message names the line.
    """
    _check_limits(text)
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise ValueError(f"is not TOML: {error}") from None


def _check_limits(text: str) -> None:
    depth = dots = 0
    for token in _TOKEN.finditer(text):
        match token.lastgroup:
            case "open":
                depth, dots = depth + 1, 0
            case "close":
                depth, dots = depth - 1, 0
            case "dot":
                dots += 1
            case "end":
                dots = 0
            case "integer":
                raise ValueError(f"line {_line(token)} has an integer of more than 64 bits")
        if max(depth, dots) > MAX_NESTING:
            raise ValueError(f"line {_line(token)} is nested too deeply; {MAX_NESTING} levels are possible")


def _line(token: re.Match[str]) -> int:
    return token.string.count("\n", 0, token.start()) + 1
