"""Times as users write them."""

from __future__ import annotations

import re
from fractions import Fraction


def parse_seconds(text: str) -> Fraction:
    """Return a time: seconds, or [hours:]minutes:seconds.

    Raises:
        ValueError: it is not a time.

    >>> parse_seconds("1:02.5")
    Fraction(125, 2)
    """
    if not re.fullmatch(r"(\d{1,9}:){0,2}\d{1,9}(\.\d{0,9})?", text, re.ASCII):
        raise ValueError(f"{text!r} is not a time such as 12.5 or 1:02:03.5")
    return sum((60**power * Fraction(part) for power, part in enumerate(text.split(":")[::-1])), Fraction(0))


def parse_interval(text: str) -> Fraction:
    """Return a time above 0, which may end in s: "30s", "1:30".

    Raises:
        ValueError: it is not a time, or 0.
    """
    if not (seconds := parse_seconds(text.removesuffix("s"))):
        raise ValueError(f"{text!r} is not a time above 0, such as 30s")
    return seconds


def parse_time_code(text: str, rate: Fraction | None) -> Fraction:
    """Return a time, also as a time code, hours:minutes:seconds:frames, without dropped frames.

    Args:
        rate: frames per second, for time codes.

    Raises:
        ValueError: it is not a time, or there is no rate.

    >>> parse_time_code("00:00:02:12", Fraction(24))
    Fraction(5, 2)
    """
    if not re.fullmatch(r"\d{1,3}(:\d\d){3}", text, re.ASCII):
        return parse_seconds(text)
    if rate is None:
        raise ValueError(f"{text!r} is a time code, which needs the frame rate: add a line such as rate = 25")
    time, _, frame = text.rpartition(":")
    nominal = -(-rate.numerator // rate.denominator)
    if int(frame) >= nominal:
        raise ValueError(f"{text!r} has frame {int(frame)} of a second with {nominal} frames")
    return (parse_seconds(time) * nominal + int(frame)) / rate


def seconds_text(time: Fraction) -> str:
    """Return a time in seconds as a text.

    >>> seconds_text(Fraction(1001, 24000))
    '0.041708'
    """
    return f"{float(time):.6f}".rstrip("0").rstrip(".")
