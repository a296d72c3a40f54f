"""The one thread in which a context lives."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Owner:
    """Runs calls one after another in a thread of its own, because a context belongs to one thread.

    A daemon: a driver that hangs must not keep the program from ending.
    """

    def __init__(self, name: str) -> None:
        self._calls: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name=name, daemon=True)
        self._thread.start()

    def submit(
        self, function: Callable[Arguments, Result], *values: Arguments.args, **named: Arguments.kwargs
    ) -> Future[Result]:
        """Call the function in the thread, after all that was submitted before."""
        future: Future[Result] = Future()
        self._calls.put((future, lambda: function(*values, **named)))
        return future

    def end(self, seconds: float) -> None:
        """Let the thread end after what was submitted, and wait for that so long."""
        self._calls.put(None)
        self._thread.join(seconds)

    def _work(self) -> None:
        while (item := self._calls.get()) is not None:
            future, call = item
            try:
                future.set_result(call())
            except BaseException as error:  # it belongs to whoever asks for the result
                future.set_exception(error)
            # Else the last result, perhaps a picture, would live until the next call.
            del item, future, call
