"""Runs the program: `vidstyle`, `python -m vidstyle`."""

from __future__ import annotations

import atexit
import gc
import os
import sys


def main() -> int:
    """Run the program and return its exit code.

    SIGINT while the libraries are loaded ends it without a word: there is nothing yet to be closed.
    """
    # Else the interpreter looks for garbage in all that it has loaded before it ends: a tenth of a short run.
    atexit.register(gc.freeze)
    # It looks a hundred times while they are loaded, and finds next to nothing.
    gc.set_threshold(100_000)
    # NumPy's BLAS would start a thread for each core, each of which spins until there is work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from vidstyle.cli import main

        return main()
    except KeyboardInterrupt:
        os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
