"""Free memory: of the machine and of control groups, and sizes that users write."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from control_groups import machine

from vidstyle.core.machine.free_memory import (
    DEFAULT_MEMORY_SHARE,
    frame_memory,
    free_memory,
    parse_memory,
    resident_memory,
    use_memory,
)

GIB = 1 << 30
V1 = "5:memory:/m\n4:cpu,cpuacct:/docker/1\n"
LIMIT, USAGE = "memory{}/memory.limit_in_bytes", "memory{}/memory.usage_in_bytes"


def with_memory(root: Path, groups: str, files: dict[str, str], kib: int = 8 << 20) -> Path:
    machine(root, groups, files)
    (root / "proc/meminfo").write_text(f"MemTotal: 9 kB\nMemAvailable:   {kib} kB\nSwapFree: 1 kB\n")
    return root


@pytest.mark.parametrize(
    ("groups", "files", "gib"),
    [
        ("", {}, 8),
        ("0::/\n", {"memory.max": "max\n", "memory.current": f"{GIB}\n"}, 8),
        ("0::/\n", {"memory.max": f"{3 * GIB}\n", "memory.current": f"{GIB}\n"}, 2),
        ("0::/a/b\n", {"a/memory.max": f"{3 * GIB}\n", "a/memory.current": f"{2 * GIB}\n",
                       "a/b/memory.max": f"{9 * GIB}\n", "a/b/memory.current": "0\n"}, 1),
        ("0::/\n", {"memory.max": f"{3 * GIB}\n", "memory.current": f"{2 * GIB}\n",
                    "memory.stat": f"anon 5\ninactive_file {GIB}\n"}, 2),
        ("0::/\n", {"memory.max": f"{GIB}\n", "memory.current": f"{2 * GIB}\n"}, 0),
        ("0::/\n", {"memory.max": f"{GIB}\n"}, 8),
        (V1, {LIMIT.format("/m"): f"{5 * GIB}\n", USAGE.format("/m"): f"{GIB}\n"}, 4),
        (V1, {LIMIT.format(""): f"{5 * GIB}\n", USAGE.format(""): f"{4 * GIB}\n",
              "memory/memory.stat": f"inactive_file 1\ntotal_inactive_file {GIB}\n"}, 2),
        (V1, {LIMIT.format("/m"): "9223372036854771712\n", USAGE.format("/m"): "1\n"}, 8),
    ],
)  # fmt: skip
def test_free_memory_is_what_machine_and_control_groups_leave(
    tmp_path: Path, groups: str, files: dict[str, str], gib: float
) -> None:
    assert free_memory(with_memory(tmp_path, groups, files)) == gib * GIB


def test_a_system_without_proc_has_some_memory(tmp_path: Path) -> None:
    assert free_memory(tmp_path) > 0 and resident_memory(tmp_path) == 0


def test_the_option_is_for_the_whole_process() -> None:
    assert frame_memory() <= free_memory() // DEFAULT_MEMORY_SHARE * 2
    with use_memory(1 << 40):
        assert (1 << 40) - (1 << 36) < frame_memory() <= (1 << 40) - resident_memory() // 2
    with use_memory(1):
        assert frame_memory() == 0


@pytest.mark.parametrize(
    ("text", "size"),
    [("2G", 2 * GIB), ("1.5g", 3 * GIB // 2), ("800MB", 800 << 20), ("1048576", 1 << 20), ("16T", 1 << 44)],
)
def test_sizes(text: str, size: int) -> None:
    assert parse_memory(text) == size


@pytest.mark.parametrize("text", ["", "G", "-1G", "1e9", "2 G", "2GiB", "inf", "9" * 5000, "٣G", "1..2G"])
def test_no_sizes(text: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(repr(text))} is not a size of memory such as"):
        parse_memory(text)


@pytest.mark.parametrize("text", ["0", "2", "1023K", "17T"])
def test_sizes_out_of_range(text: str) -> None:
    with pytest.raises(ValueError, match=f"^{text} is outside 1M to 16T$"):
        parse_memory(text)
