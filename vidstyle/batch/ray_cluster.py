"""Runs the processes of a batch on a Ray cluster."""

from __future__ import annotations

import ipaddress
import json
import os
import queue
import re
import secrets
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from typing import Any

from vidstyle.batch.processes import END_SECONDS, Event, Outcome
from vidstyle.batch.resources import Room
from vidstyle.core.machine.versions import version_of
from vidstyle.errors import OutputError, UsageError

HERE = "ray"
"""The address for a cluster of this machine only, which lives as long as the batch."""
MIN_RAY = (2, 52)
"""The first version with authentication."""
_ADDRESS = re.compile(r"ray://(\[[0-9a-fA-F:]+\]|[\w.-]+):\d+")
SHUTDOWN_SECONDS = 3 * END_SECONDS
"""How long processes and Ray may take to end."""


class RayCluster:
    """An executor whose processes run on the machines of a Ray cluster; see `Executor`.

    Ray prints to the terminal, handles signals, and may end its process: `ray_driver` has a separate one.
    Both sides send JSON objects, one in a line.
    """

    def __init__(self, address: str) -> None:
        """Connect to a cluster, or start one.

        Args:
            address: as `check_address` takes it.

        Raises:
            OutputError: Ray does not start, or cannot be reached.
        """
        self._driver = subprocess.Popen(
            [sys.executable, "-m", "vidstyle.batch.ray_driver", address],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            encoding="utf-8",
            env={**os.environ, **_environment(address)},
            start_new_session=True,
        )
        self._lock, self.is_stopped, self._has_ended = threading.Lock(), False, False
        self._tasks: dict[int, queue.SimpleQueue[Mapping[str, Any] | None]] = {}
        self._count = 0
        assert self._driver.stdout is not None
        try:
            answer = json.loads(self._driver.stdout.readline() or '{"error": "it has ended"}')
        except BaseException:
            self.stop()
            raise
        if "error" in answer:
            self.stop()
            raise OutputError("--on", f"{address} cannot be used: {answer['error']}")
        self.room = Room(**answer)
        threading.Thread(target=self._receive, name="vidstyle batch ray", daemon=True).start()

    def run(self, words: Sequence[str], on_event: Callable[[Event], None], cores: int = 1) -> Outcome:
        """See Executor."""
        if cores > self.room.machine_cores:
            reason = f"{cores} are more than any machine of the cluster has ({self.room.machine_cores})"
            raise UsageError("--threads", reason)
        number, messages = self._begin({"words": [*words], "cores": cores})
        try:
            while message := messages.get():
                if "outcome" in message:
                    return Outcome(**message["outcome"])
                on_event(message["event"])
        finally:
            with self._lock:
                self._tasks.pop(number, None)
        if self.is_stopped:
            return Outcome(128 + signal.SIGTERM, "stopped", {})
        return Outcome(OutputError.exit_code, "the connection to Ray was lost; run the batch again", {})

    def stop(self) -> None:
        """See Executor."""
        self.is_stopped = True
        assert self._driver.stdin is not None
        with suppress(OSError):
            self._driver.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            self._driver.wait(SHUTDOWN_SECONDS)
        self._driver.kill()

    def _begin(self, request: dict[str, Any]) -> tuple[int, queue.SimpleQueue[Mapping[str, Any] | None]]:
        """Send a request; returns the task number, and a queue of its answers, which ends with None."""
        messages: queue.SimpleQueue[Mapping[str, Any] | None] = queue.SimpleQueue()
        with self._lock:
            self._count += 1
            number = self._count
            self._tasks[number] = messages
            try:
                if self._has_ended:
                    raise BrokenPipeError
                print(json.dumps({"task": number, **request}), file=self._driver.stdin, flush=True)
            except (OSError, ValueError):  # closed by `stop`
                messages.put(None)
        return number, messages

    def _receive(self) -> None:
        assert self._driver.stdout is not None
        for line in self._driver.stdout:
            message = json.loads(line)
            with self._lock:
                if messages := self._tasks.get(message["task"]):
                    messages.put(message)
        with self._lock:
            self._has_ended = True
            for messages in self._tasks.values():
                messages.put(None)


def check_address(address: str, insecure: bool) -> None:
    """Check that a cluster may be used.

    Args:
        address: "ray" for one of this machine only, or "ray://HOST:PORT".
        insecure: whether it may lie elsewhere and ask for no token.

    Raises:
        UsageError: it may not, or Ray is missing.
    """
    match = _ADDRESS.fullmatch(address)
    if address != HERE and match is None:
        raise UsageError("--on", f"{address!r} is not a cluster", "give ray or ray://HOST:PORT")
    if match and not insecure and not _is_this_machine(match[1]) and not _has_token():
        reason = f"{match[1]} may belong to anyone: Ray runs any code, and RAY_AUTH_MODE is not 'token'"
        raise UsageError("--on", reason, "set it on all machines (docs/batch.md), or add --insecure")
    version = version_of("ray") if find_spec("ray") else "0.0"
    if tuple(map(int, re.findall(r"\d+", version)[:2])) < MIN_RAY:
        needed = ".".join(map(str, MIN_RAY))
        raise UsageError("--on", f"needs Ray {needed} or newer", "pip install 'vidstyle[cluster]'")


def _has_token() -> bool:
    return os.environ.get("RAY_AUTH_MODE", "").lower() == "token"


def _is_this_machine(host: str) -> bool:
    with suppress(ValueError):
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    return host.lower() == "localhost"


def _environment(address: str) -> dict[str, str]:
    """Variables that Ray reads."""
    variables = {"RAY_USAGE_STATS_ENABLED": "0"}
    if address == HERE:
        # Only with this does Ray keep all ports on 127.0.0.1. The token is for other users of this machine.
        variables |= {"RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0"}
        variables |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    return variables
