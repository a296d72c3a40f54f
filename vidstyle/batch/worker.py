"""The process of one job: runs `vidstyle` with the arguments of this program, until the batch ends.

Standard input is a pipe from the batch. It closes at any end of the batch; then this process closes its film
and ends, too.
"""

from __future__ import annotations

import os
import runpy
import signal
import threading
import time

END_SECONDS = 5.0
"""Time limit for closing the film."""


def main() -> None:
    """Run `vidstyle`."""
    threading.Thread(target=_end_with_batch, daemon=True).start()
    runpy.run_module("vidstyle", run_name="__main__", alter_sys=True)


def _end_with_batch() -> None:
    while os.read(0, 1024):
        pass
    # Send the signal to the main thread, which would not wake for a signal to another thread.
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)
        time.sleep(END_SECONDS)
    os._exit(128 + signal.SIGTERM)


if __name__ == "__main__":
    main()
