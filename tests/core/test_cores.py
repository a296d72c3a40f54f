"""The number of cores: CPU affinity, control groups, the environment variable and --threads."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import cv2
import pytest
from control_groups import machine

from vidstyle.core.bands import BandWorkers, CallingThread, in_bands
from vidstyle.core.machine import cores
from vidstyle.core.machine.cores import (
    MAX_THREADS,
    THREADS_VARIABLE,
    CoreCount,
    available_cores,
    cgroup_quota,
    core_count,
    imposed_threads,
    limit_opencv,
    limited_cores,
    process_cores,
    use_threads,
)
from vidstyle.errors import UsageError


@pytest.fixture(autouse=True)
def without_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(THREADS_VARIABLE, raising=False)


V1 = "5:memory:/m\n4:cpu,cpuacct:/docker/1\n1:name=systemd:/docker/1\n"
V1_QUOTA, V1_PERIOD = "cpu,cpuacct{}/cpu.cfs_quota_us", "cpu,cpuacct{}/cpu.cfs_period_us"


@pytest.mark.parametrize(
    ("groups", "files", "quota"),
    [
        ("0::/\n", {"cpu.max": "150000 100000\n"}, 1.5),
        ("0::/\n", {"cpu.max": "max 100000\n"}, None),
        ("0::/a/b\n", {"a/b/cpu.max": "max 100000\n", "a/cpu.max": "200000 100000\n"}, 2),
        ("0::/a/b\n", {"a/b/cpu.max": "50000 100000\n", "a/cpu.max": "200000 100000\n"}, 0.5),
        ("0::/a/b\n", {"a/b/cpu.max": "400000 100000\n", "cpu.max": "100000 100000\n"}, 1),
        ("0::/a\n", {"b/cpu.max": "100000 100000\n"}, None),  # the group of another process
        ("0::/../../host\n", {"cpu.max": "300000 100000\n"}, 3),
        (V1, {V1_QUOTA.format("/docker/1"): "250000\n", V1_PERIOD.format("/docker/1"): "100000\n"}, 2.5),
        (V1, {V1_QUOTA.format(""): "100000\n", V1_PERIOD.format(""): "100000\n"}, 1),  # in a container
        (V1, {V1_QUOTA.format("/docker/1"): "-1\n", V1_PERIOD.format("/docker/1"): "100000\n"}, None),
        (V1 + "0::/x\n", {V1_QUOTA.format(""): "90000\n", V1_PERIOD.format(""): "30000\n"}, 3),
        ("3:cpuset:/\n", {"cpuset/cpu.cfs_quota_us": "1\n", "cpuset/cpu.cfs_period_us": "1\n"}, None),
        ("0::/\n", {"cpu.max": "100000\n"}, None),
        ("0::/\n", {"cpu.max": "a b\n"}, None),
        ("0::/\n", {"cpu.max": "100000 0\n"}, None),
        ("0::/\n", {"cpu.max": "-5 100000\n"}, None),
        ("0::/\n", {"cpu.max": ""}, None),
        ("nonsense\n\n::\n", {}, None),
        ("", {}, None),
    ],
)  # fmt: skip
def test_the_lowest_quota_of_the_control_groups_counts(
    tmp_path: Path, groups: str, files: dict[str, str], quota: float | None
) -> None:
    assert cgroup_quota(machine(tmp_path, groups, files)) == quota


def test_a_system_without_control_groups_has_no_quota(tmp_path: Path) -> None:
    assert cgroup_quota(tmp_path) is None


@pytest.mark.parametrize(
    ("affinity", "quota", "text"),
    [(64, None, "64: all cores"), (4, None, "4 of 64: CPU affinity"), (4, 1.5, "2 of 64: cgroup quota"),
     (4, 0.01, "1 of 64: cgroup quota"), (4, 3.5, "4 of 64: CPU affinity"), (2, 8, "2 of 64: CPU affinity")],
)  # fmt: skip
def test_affinity_and_quota_limit_the_cores(affinity: int, quota: float | None, text: str) -> None:
    assert str(limited_cores(64, affinity, quota)) == text


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system has no CPU affinity")
def test_a_process_on_one_core_uses_one() -> None:
    command = (
        "import os; os.sched_setaffinity(0, [min(os.sched_getaffinity(0))]);"
        "from vidstyle.core.machine.cores import core_count; print(core_count())"
    )
    ended = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True)
    wanted = "1: all cores" if os.cpu_count() == 1 else f"1 of {os.cpu_count()}: "
    assert ended.stdout.startswith(wanted)


def test_the_variable_overrides_the_machine_and_the_option_both(monkeypatch: pytest.MonkeyPatch) -> None:
    everything = process_cores().machine
    assert core_count() == process_cores()
    monkeypatch.setenv(THREADS_VARIABLE, " 3 ")
    assert core_count() == CoreCount(3, THREADS_VARIABLE, everything)
    with use_threads(5):
        assert core_count() == CoreCount(5, "--threads", everything)
        assert os.environ[THREADS_VARIABLE] == "5", "child processes do not inherit it"
    assert core_count() == CoreCount(3, THREADS_VARIABLE, everything)


@pytest.mark.parametrize("text", ["0", "-1", "two", "1.5", str(MAX_THREADS + 1), "9" * 5000])
def test_a_variable_that_is_no_number_of_threads_is_refused(
    monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    monkeypatch.setenv(THREADS_VARIABLE, text)
    with pytest.raises(UsageError, match=f"^{THREADS_VARIABLE}: .*unset it"):
        available_cores()


def test_an_empty_variable_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS_VARIABLE, "")
    assert core_count() == process_cores()


def test_libraries_that_know_affinity_are_told_only_what_differs_from_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    affinity = limited_cores(1024, cores._affinity(), None).number
    with use_threads(affinity):
        assert imposed_threads() == 0
    with use_threads(affinity + 1):
        assert imposed_threads() == affinity + 1


def test_opencv_uses_the_number_and_gets_its_own_back() -> None:
    before, number = cv2.getNumThreads(), process_cores().number + 1
    with use_threads(number), limit_opencv():
        assert cv2.getNumThreads() == number
    assert cv2.getNumThreads() == before


def test_opencv_that_is_imported_later_uses_the_number() -> None:
    number = process_cores().number + 2
    command = (
        "from vidstyle.core.machine.cores import limit_opencv\n"
        "with limit_opencv():\n import cv2; print(cv2.getNumThreads())"
    )
    ended = subprocess.run(
        [sys.executable, "-c", command],
        env=os.environ | {THREADS_VARIABLE: str(number)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout.strip() == str(number)


class CountingPool(CallingThread):
    """Counts the tasks that it is given."""

    submitted = 0

    def submit(self, *arguments: Any, **named: Any) -> Future[Any]:
        self.submitted += 1
        return super().submit(*arguments, **named)


@pytest.mark.parametrize("number", [1, 3])
def test_bands_are_divided_among_this_number_of_threads(number: int) -> None:
    pool = CountingPool()
    in_bands(BandWorkers(pool, number), (4096, 64), 0, lambda top, bottom: None)
    assert pool.submitted == number - 1
