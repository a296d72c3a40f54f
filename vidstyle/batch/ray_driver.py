"""The process through which a batch talks with Ray; `RayCluster` starts it.

Each line of standard input is a task, each line of standard output a message about one, both in JSON. When
standard input closes, all tasks are stopped, and this process ends.
"""

from __future__ import annotations

import json
import os
import platform
import queue
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any

from vidstyle.batch.processes import END_SECONDS, Outcome, Processes
from vidstyle.batch.ray_cluster import HERE
from vidstyle.batch.resources import JOB_BYTES
from vidstyle.errors import OutputError

MAX_LOSSES = 5
"""Number of lost machines or workers that a task survives."""
PAUSE_SECONDS = 10.0
"""Time for which a task waits after a loss, until the process of the lost worker has closed its files."""
STORE_BYTES = 2**27
"""Size of Ray's object store, which stays small because tasks get paths."""

MAX_LETTERS = 200

Send = Callable[[Mapping[str, Any]], None]


class RemoteProcess:
    """An actor: a process of `vidstyle` on a machine of the cluster.

    If the actor dies, however it dies, the standard input of the process closes, and it ends; see `worker`.
    """

    def __init__(self, words: Sequence[str], folder: str) -> None:
        """Start the process in a folder that has the same path on all machines."""
        self._processes = Processes(folder)
        self._messages: queue.SimpleQueue[Mapping[str, Any]] = queue.SimpleQueue()
        threading.Thread(target=self._run, args=(words, folder), daemon=True).start()

    def take(self) -> Mapping[str, Any]:
        """Wait for the next message: {"event": ...}, or {"outcome": ...} in the end."""
        return self._messages.get()

    def stop(self) -> None:
        """Have the process close its files and end."""
        self._processes.stop()

    def _run(self, words: Sequence[str], folder: str) -> None:
        try:
            outcome = self._processes.run(words, lambda event: self._messages.put({"event": event}))
        except OSError as error:
            outcome = Outcome(OutputError.exit_code, f"{platform.node()}: {folder}: {error.strerror}", {})
        self._messages.put({"outcome": asdict(outcome)})


def main() -> None:
    """Connect to Ray, and run tasks until standard input closes."""
    out = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # Ray prints to both
    lock = threading.Lock()

    def send(message: Mapping[str, Any]) -> None:
        with lock:
            print(json.dumps(message), file=out, flush=True)

    try:
        with _connected(sys.argv[1]) as ray:
            send(_room(ray))
            _serve(ray, send)
    except Exception as error:  # every failure of Ray is one line for the user
        send({"error": _line(error)})
    os._exit(0)  # threads may still wait for Ray


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    import ray

    options: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
    with tempfile.TemporaryDirectory(prefix="vidstyle-ray-", ignore_cleanup_errors=True) as folder:
        if address == HERE:
            options |= {"include_dashboard": False, "object_store_memory": STORE_BYTES, "_temp_dir": folder}
        ray.init(address="local" if address == HERE else address, **options)
        try:
            yield ray
        finally:
            ray.shutdown()


def _line(error: Exception) -> str:
    """The beginning of a message of Ray, which has many lines."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= MAX_LETTERS else f"{text[:MAX_LETTERS]}..."


def _room(ray: Any) -> dict[str, int]:
    """The arguments of `Room`."""
    machines = [node["Resources"] for node in ray.nodes() if node["Alive"]]
    cores = [int(each.get("CPU", 0)) for each in machines]
    memory = sum(int(each.get("memory", 0)) for each in machines)
    return {"cores": sum(cores), "machine_cores": max(cores), "memory": memory}


def _serve(ray: Any, send: Send) -> None:
    actors: dict[int, Any] = {}
    for line in sys.stdin:
        task = json.loads(line)
        threading.Thread(target=_run_task, args=(ray, task, actors, send), daemon=True).start()
    stops = [actor.stop.remote() for actor in [*actors.values()]]
    if stops:
        ray.wait(stops, num_returns=len(stops), timeout=END_SECONDS)


def _run_task(ray: Any, task: Mapping[str, Any], actors: dict[int, Any], send: Send) -> None:
    """Run a task to its end, on another machine if one is lost."""
    number, reason = task["task"], ""
    for attempt in range(MAX_LOSSES + 1):
        if attempt:
            text = "a worker of the cluster was lost; its task begins again"
            send({"task": number, "event": {"event": "notice", "text": text}})
            time.sleep(PAUSE_SECONDS)
        try:
            outcome = _follow(ray, task, actors, send)
        except ray.exceptions.RayError as error:
            reason = _line(error)
        else:
            send({"task": number, "outcome": outcome})
            return
    lost = Outcome(OutputError.exit_code, f"{MAX_LOSSES + 1} workers were lost: {reason}", {})
    send({"task": number, "outcome": asdict(lost)})


def _follow(ray: Any, task: Mapping[str, Any], actors: dict[int, Any], send: Send) -> Mapping[str, Any]:
    """Run a task once, and pass on its events; raises RayError if its worker is lost."""
    options = {"num_cpus": task["cores"], "memory": JOB_BYTES, "max_restarts": 0, "max_concurrency": 2}
    actor = ray.remote(RemoteProcess).options(**options).remote(task["words"], os.getcwd())
    actors[task["task"]] = actor
    try:
        while "outcome" not in (message := ray.get(actor.take.remote())):
            send({"task": task["task"], **message})
        return message["outcome"]
    finally:
        del actors[task["task"]]
        ray.kill(actor)


if __name__ == "__main__":
    main()
