"""The reader of TOML from untrusted sources."""

from __future__ import annotations

import os
from pathlib import Path
from random import Random

import pytest

from vidstyle.core.file_checks import MAX_NESTING, parse_toml, read_toml_text

TEXT = r"""name = "a.b.c [[[ # \" {"  # [[[ a.b.c
'literal' = 'no \ escape [[['
long = '''
[[[ 12345678901234567890123 '' ...
''''
basic = @
\@ {{{ "" [[[
@"
numbers = [1e400, 0.12345678901234567890123, 123456789012345678901234.5, 9223372036854775807, 0x7fff_ffff]
date = 1979-05-27T00:32:00.999999-07:00
[a."b.c".'d']
e = { f = [[[1, 2], [3]]], g = {} }
""".replace("@", '"""')


def test_strings_and_comments_do_not_count() -> None:
    table = parse_toml(TEXT.replace("...", "." * 99))
    assert table["a"]["b.c"]["d"]["e"] == {"f": [[[1, 2], [3]]], "g": {}}
    assert table["numbers"][2] == 123456789012345678901234.5


@pytest.mark.parametrize("prefix", ["", "x = '['\n", 's = """\\"""\n"""\n', 'y = "#" # \'\n'])
def test_limits_hold_whatever_stands_before(prefix: str) -> None:
    line = prefix.count("\n") + 1
    for text in (
        "a = " + "[" * MAX_NESTING + "]" * MAX_NESTING,
        "a." * MAX_NESTING + "b = 1",
        "[" + "a." * MAX_NESTING + "b]",
    ):
        parse_toml(prefix + text)
    for text in (
        "a = " + "[" * (MAX_NESTING + 1),
        "a = " + "{b = " * (MAX_NESTING + 1),
        "'a' . " * (MAX_NESTING + 1) + "b = 1",
        "[[" + "a." * (MAX_NESTING + 1) + "b]]",
    ):
        with pytest.raises(ValueError, match=f"line {line} is nested too deeply; 16 levels are possible"):
            parse_toml(prefix + text)
    for number in (
        "9" * 20,
        "-" + "9" * 5000,
        "1_" * 30 + "1",
        "0x" + "f" * 17,
        "0b" + "1" * 65,
        "1" * 30 + ".x",
    ):
        with pytest.raises(ValueError, match=f"line {line} has an integer of more than 64 bits"):
            parse_toml(f"{prefix}a = {number}")


def test_mutated_texts_are_read_or_refused() -> None:
    """No text makes tomllib recurse deeper than the limit, and every failure is a ValueError."""
    random = Random(os.environ["VIDSTYLE_TEST_SEED"])
    pieces = [*"[]{}'\"\\#\n.=,a1\0", '"""', "'''", "9" * 25]
    for _ in range(2000):
        text = TEXT
        for _ in range(random.randint(1, 6)):
            at, cut = random.randrange(len(text)), random.randint(0, 3)
            text = text[:at] + random.choice(pieces) * random.choice([1, 1, 2, 40]) + text[at + cut :]
        try:
            found = parse_toml(text)
        except ValueError:
            continue
        repr(found)


def test_the_text_is_limited_before_it_is_read(tmp_path: Path) -> None:
    file = tmp_path / "file.toml"
    for content, reason in (
        (b"x" * 1025, "is larger than 1 KiB"),
        (b"a\nb\n\xff", "line 3 is not UTF-8 text; save the file as UTF-8"),
    ):
        file.write_bytes(content)
        with pytest.raises(ValueError, match=reason):
            read_toml_text(file, 1024)
    file.write_bytes(b"\xef\xbb\xbfa = 1")
    assert read_toml_text(file, 1024) == "a = 1"
    with pytest.raises(ValueError, match="cannot be read: No such file or directory"):
        read_toml_text(tmp_path / "none.toml", 1024)
