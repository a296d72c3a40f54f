"""Run all tests on a machine with random settings, and the most sensitive ones on its opposite.

VIDSTYLE_TEST_SEED, the date in `run`, selects the machine; see `settings.py` for overrides.
"""

from __future__ import annotations

import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from settings import BROWSERS, Machine, account_of, draw_machines

ROOT = Path(__file__).resolve().parents[1]
HIDDEN_PROGRAMS = BROWSERS | {"ffmpeg", "ffprobe", "node", "npx"}
"""Programs hidden from a machine "without" other programs."""
SENSITIVE_TESTS = (
    "tests/blade/test_training.py",
    "tests/cli",
    "tests/comic/test_subjects.py",
    "tests/core",
    "tests/cpu",
    "tests/faults",
    "tests/live/test_page_security.py",
    "tests/live/test_styler.py",
    "tests/pipeline",
    "tests/repository",
)
"""Tests whose results depend most on user, paths, locale, cores, Python and dependencies."""
SENSITIVE_TEST_COUNT = 3
"""Number of `SENSITIVE_TESTS` that run on the second machine, a random choice each day."""
THOROUGH_SHARE = "0.015"
"""Share of the thorough tests that run, a random choice each day."""
FUZZ_SECONDS = "25"
FOLDERS = {
    "plain": "checkout",
    "space and umlaut": "mein Ördner/checkout",
    "below a closed folder": "closed/checkout",
}


class Result(NamedTuple):
    """Whether a command succeeded, and the lines of its output."""

    succeeded: bool
    lines: list[str]


class Checkout:
    """A clone in which commands run with the settings of a machine, few variables and an empty home."""

    def __init__(self, machine: Machine, work: Path, seed: str, cores: set[int]) -> None:
        self.machine, self._cores = machine, ",".join(map(str, cores))
        self.python = f"PYTHON={machine.interpreter}"
        place = Path(tempfile.mkdtemp(dir=work))
        self.folder = place / FOLDERS[machine.checkout]
        self.folder.mkdir(parents=True)
        (place / "home").mkdir()
        # The repository may belong to another user; `git clone` does not pass options on to upload-pack.
        upload_pack = "git -c safe.directory=* upload-pack"
        clone = ["git", "clone", "--quiet", "--upload-pack", upload_pack, str(ROOT), str(self.folder)]
        subprocess.run(clone, check=True)
        self._variables = {
            "PATH": os.environ["PATH"] if machine.programs == "with" else _without_programs(place / "bin"),
            "HOME": str(place / "home"),
            "LANG": machine.locale,
            "VIDSTYLE_TEST_SEED": seed,
            "VIDSTYLE_TEST_SHARE": THOROUGH_SHARE,
        }
        if machine.dependencies == "lowest":
            lowest = subprocess.check_output([machine.interpreter, ROOT / ".ci/lowest.py"])
            (place / "constraints").write_bytes(lowest)
            self._variables["PIP_CONSTRAINT"] = str(place / "constraints")
        self._account = account_of(machine.user)
        if self._account:
            subprocess.run(
                ["chown", "-R", f"{self._account.pw_uid}:{self._account.pw_gid}", place], check=True
            )
        place.chmod(0o755)
        if machine.checkout == "below a closed folder":
            self.folder.parent.chmod(0o700)

    def run(self, *command: str, show: bool = False) -> Result:
        """Run a command on the cores of the machine; `show` prints its output immediately."""
        process = subprocess.Popen(
            ["taskset", "--cpu-list", self._cores, *command], cwd=self.folder, env=self._variables,
            text=True, encoding="utf-8", errors="replace",
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            user=self._account and self._account.pw_uid, group=self._account and self._account.pw_gid,
            extra_groups=[] if self._account else None,
        )  # fmt: skip
        assert process.stdout is not None
        lines = []
        for line in process.stdout:
            lines.append(line.rstrip())
            if show:
                print(lines[-1], flush=True)
        return Result(process.wait() == 0, lines)

    def test(self, target: str, *variables: str, show: bool = False) -> Result:
        """Run a test target of `make`, and rerun failed tests once without parallel processes.

        Tests of streams may fail on busy machines.
        """
        make = ["make", target, self.python, *variables]
        result = self.run(*make, show=show)
        if result.succeeded:
            return result
        failed = "TESTS=--last-failed --last-failed-no-failures none"
        again = self.run(*make, failed, "JOBS=0", show=show)
        return Result(again.succeeded, [*result.lines, "Rerun of failed tests:", *again.lines])

    def fuzz(self, seed: str) -> Result:
        """Run the fuzzer, and copy its findings to the repository."""
        limits = ["--seconds", FUZZ_SECONDS, "--seed", seed]
        result = self.run(".venv/bin/python", "tools/fuzz.py", *limits)
        if not result.succeeded:
            found = "tests/fixtures/found"
            shutil.copytree(self.folder / found, ROOT / found, dirs_exist_ok=True)
        return result


def main() -> None:
    """Print the settings, run all tests and checks, and print a summary."""
    seed = os.environ["VIDSTYLE_TEST_SEED"]
    machines = draw_machines(seed)
    print(f"seed {seed}; all tests on:\n{machines[0]}\nsome on the opposite:\n{machines[1]}", flush=True)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as threads:
        Path(folder).chmod(0o711)
        # The machines share as few cores as possible.
        first, second = (
            Checkout(machine, Path(folder), seed, machine.choose_cores(from_last))
            for machine, from_last in zip(machines, (True, False), strict=True)
        )
        installed = threads.submit(first.run, "make", ".venv/dev.stamp", first.python)
        others = threads.submit(_run_others, second, first, installed, seed)
        installed.result()
        all_tests = first.test("test", show=True)
        results = {**others.result(), "all tests": all_tests}
    for name, (succeeded, lines) in results.items():
        if not succeeded and name != "all tests":
            print(f"{name}:", *lines, sep="\n")
    for name, (_, lines) in results.items():
        print(f"{name}: {_summary(lines)}")
    sys.exit(not all(result.succeeded for result in results.values()))


def _summary(lines: list[str]) -> str:
    """Join the lines with counts, of the first run and the rerun."""
    counts = re.compile(r"\d (passed|failed|error).* in |\d cases|^Success")
    return "; ".join(line.strip("= ") for line in lines if counts.search(line)) or lines[-1]


def _run_others(second: Checkout, first: Checkout, installed: Future[Result], seed: str) -> dict[str, Result]:
    """Run the checks and the tests of the second machine in parallel with all tests of the first."""
    sensitive = random.Random(seed).sample(SENSITIVE_TESTS, SENSITIVE_TEST_COUNT)
    results = {
        "sensitive tests": second.test("test", f"TESTS={' '.join(sensitive)}"),
        # Few tests: collecting them in more processes would take longer than running them.
        "thorough tests": second.test("thorough", "JOBS=0"),
        "damaged files": second.fuzz(seed),
    }
    installed.result()
    # Types are checked against the newest libraries; older ones have other annotations.
    newest = first if first.machine.dependencies == "newest" else second
    return {**results, "checks": newest.run("make", "check")}


def _without_programs(folder: Path) -> str:
    """Fill a folder with links to all programs but the hidden ones; return it as a PATH."""
    folder.mkdir()
    for place in os.environ["PATH"].split(os.pathsep):
        for program in Path(place).iterdir() if Path(place).is_dir() else ():
            link = folder / program.name
            if program.name not in HIDDEN_PROGRAMS and not link.is_symlink():
                link.symlink_to(program)
    return str(folder)


if __name__ == "__main__":
    main()
