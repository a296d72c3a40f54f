"""Pictures in the terminal: what each kind of terminal is sent, and nobody else."""

from __future__ import annotations

import re
from base64 import b64decode

import cv2
import numpy as np
import pytest

from vidstyle.cli import main
from vidstyle.cli.terminal.terminal_pictures import MAX_CHUNK_BYTES, protocol_of, sheet_lines

RED, BLUE = np.full((90, 160, 3), (255, 0, 0), np.uint8), np.full((90, 160, 3), (0, 0, 255), np.uint8)
NAMED = [("red", RED), ("blue", BLUE), ("third", RED)]


@pytest.mark.parametrize(
    ("environment", "protocol"),
    [
        ({"TERM": "xterm-kitty"}, "kitty"),
        ({"TERM": "xterm-256color", "TERM_PROGRAM": "iTerm.app"}, "iterm"),
        ({"TERM": "tmux-256color", "COLORTERM": "truecolor"}, "blocks"),
        ({"TERM": "xterm-256color"}, ""),
        ({"TERM": "xterm-kitty", "NO_COLOR": "1"}, ""),
        ({"TERM": "dumb", "COLORTERM": "truecolor"}, ""),
        ({"COLORTERM": "truecolor"}, ""),
    ],
)
def test_pictures_are_for_terminals_that_show_them(
    environment: dict[str, str], protocol: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert protocol_of(environment) == "", "standard output is no terminal"
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert protocol_of(environment) == protocol


def test_blocks_have_two_pixels_each_and_stand_above_their_names() -> None:
    lines = list(sheet_lines(NAMED, "blocks", columns=60))
    colours = [re.findall(r"38;2;([\d;]+);48;2;([\d;]+)m▀", line) for line in lines]
    assert [len(each) for each in colours] == [58] * 8 + [0] + [29] * 8 + [0]
    assert colours[0][0] == ("255;0;0", "255;0;0") and colours[0][-1] == ("0;0;255", "0;0;255")
    assert (lines[8], lines[-1]) == (f"{'red':30}blue", "third")
    assert all(line.endswith("\x1b[0m") for line in lines if "▀" in line)


@pytest.mark.parametrize("protocol", ["kitty", "iterm"])
def test_a_row_is_one_picture_with_gaps_that_are_transparent(protocol: str) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (90, 160, 3), np.uint8)
    line, names = sheet_lines([("noise", noise), ("red", RED)], protocol, columns=60)
    if protocol == "kitty":
        parts = re.findall(r"\x1b_G([^;]*);([^\x1b]*)\x1b\\", line)
        assert parts[0][0] == "a=T,f=100,q=2,c=59,r=8,m=1"
        assert {keys for keys, _ in parts[1:-1]} == {"m=1"} and parts[-1][0] == "m=0"
        assert max(len(data) for _, data in parts) <= MAX_CHUNK_BYTES
        png = b64decode("".join(data for _, data in parts))
    else:
        found = re.fullmatch(r"\x1b]1337;File=inline=1;size=(\d+);width=59;height=8;[^:]*:(.*)\a", line)
        assert found is not None
        png = b64decode(found[2])
        assert len(png) == int(found[1])
    strip = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(strip[:, :160, :3], noise[..., ::-1]) and (strip[:, -160:, 2] == 255).all()
    assert not strip[:, 160:-160].any() and strip.shape[1] > 320
    assert names == f"{'noise':30}red"


def test_the_list_and_one_style_are_shown_in_pictures(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["styles"]) == 0
    assert "▀" not in (listed := capsys.readouterr().out)
    monkeypatch.setattr("vidstyle.cli.styles.protocol_of", lambda: "blocks")
    assert main(["styles"]) == 0
    out = capsys.readouterr().out
    assert out.endswith(f"\n\n{listed}") and "▀" in out
    assert main(["styles", "ink", "--json"]) == 0
    assert "▀" not in capsys.readouterr().out
    assert main(["styles", "ink"]) == 0
    assert "▀\n\nink: " in capsys.readouterr().out
