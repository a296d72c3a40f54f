"""Random settings of the machines for the tests; the seed is the date, so each day uses other settings.

A second machine has the opposite settings. Environment variables such as VIDSTYLE_CI_USER=ordinary override
settings of the first machine.
"""

from __future__ import annotations

import os
import pwd
import random
import shutil
import subprocess
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

ORDINARY_USER = "vidstyle-tests"
OLDEST_PYTHON = "3.11"
BROWSERS = {"chromium", "chromium-browser", "google-chrome", "chrome"}
"""Names of browsers, one of which the tests of pages need."""

OPTIONS = {
    "user": ("root", "ordinary"),
    "dependencies": ("newest", "lowest"),
    "python": (OLDEST_PYTHON, "3.12", "3.13", "3.14"),
    "cores": ("1", "2", "all"),
    "checkout": ("plain", "space and umlaut", "below a closed folder"),
    "locale": ("C", "C.UTF-8", "de_DE.UTF-8"),
    "programs": ("with", "without"),
}
"""Options of each setting; they may depend on the settings above."""


@dataclass(frozen=True)
class Machine:
    """Settings under which tests run, by the names of `OPTIONS`."""

    user: str
    dependencies: str
    python: str
    cores: str
    checkout: str
    locale: str
    programs: str

    def __str__(self) -> str:
        return "\n".join(f"  {field.name}: {getattr(self, field.name)}" for field in fields(self))

    @property
    def interpreter(self) -> Path:
        """The Python of the virtual environment."""
        found = find_python(self.python, self.user)
        assert found is not None
        return found

    def choose_cores(self, from_last: bool) -> set[int]:
        """Return the processor cores that its processes may use, counted from the last or the first one."""
        allowed = sorted(os.sched_getaffinity(0), reverse=from_last)
        return set(allowed if self.cores == "all" else allowed[: int(self.cores)])


def draw_machines(seed: str) -> tuple[Machine, Machine]:
    """Return the machine of a seed and its opposite, and print unavailable options."""
    orders = {name: random.Random(f"{seed} {name}").sample(of, len(of)) for name, of in OPTIONS.items()}
    for name, order in orders.items():
        order.sort(key=lambda option, name=name: option != os.environ.get(f"VIDSTYLE_CI_{name.upper()}"))
    first = _first_possible(orders)
    opposite = _first_possible({name: order[::-1] for name, order in orders.items()})
    if first.cores == "1" and "VIDSTYLE_CI_CORES" not in os.environ:
        return opposite, first  # the first machine runs all tests, too many for one core
    return first, opposite


def account_of(user: str) -> pwd.struct_passwd | None:
    """Return the account to switch to, or None for the current one."""
    return None if os.geteuid() != 0 or user == "root" else pwd.getpwnam(ORDINARY_USER)


@cache
def find_python(version: str, user: str) -> Path | None:
    """Return a Python of a version such as "3.12" that the user can run and that has venv, or None."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    found = [f"/usr/bin/python{version}", f"/usr/local/bin/python{version}", shutil.which(f"python{version}")]
    found += sorted(map(str, pyenv.glob(f"versions/{version}.*/bin/python{version}")))
    return next((Path(path) for path in found if path and _has_venv(path, version, user)), None)


def _has_venv(python: str, version: str, user: str) -> bool:
    check = "import ensurepip, sys, venv; print('{}.{}'.format(*sys.version_info))"
    account = account_of(user)
    try:
        run_result = subprocess.run(
            [python, "-c", check], capture_output=True, text=True, cwd="/", user=account and account.pw_uid
        )
    except OSError:
        return False
    return run_result.stdout.strip() == version


def _first_possible(orders: Mapping[str, Iterable[str]]) -> Machine:
    chosen: dict[str, str] = {}
    for name, order in orders.items():
        for option in order:
            if not (reason := OBSTACLES[name](option, chosen)):
                chosen[name] = option
                break
            print(f"not {name} {option}: {reason}", flush=True)
    return Machine(**chosen)


def _obstacle_to_user(option: str, _: Mapping[str, str]) -> str | None:
    if option == "root":
        return None if os.geteuid() == 0 else "not started by root"
    if os.geteuid() != 0 or any(each.pw_name == ORDINARY_USER for each in pwd.getpwall()):
        return None
    try:
        subprocess.run(["useradd", "--system", ORDINARY_USER], check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        return str(error)
    return None


def _obstacle_to_dependencies(option: str, chosen: Mapping[str, str]) -> str | None:
    # Their wheels are as old as the oldest Python.
    return _obstacle_to_python(OLDEST_PYTHON, chosen) if option == "lowest" else None


def _obstacle_to_python(option: str, chosen: Mapping[str, str]) -> str | None:
    if chosen.get("dependencies") == "lowest" and option != OLDEST_PYTHON:
        return f"the lowest dependencies have wheels for {OLDEST_PYTHON}"
    return None if find_python(option, chosen["user"]) else f"none that user {chosen['user']} can start"


def _obstacle_to_cores(option: str, _: Mapping[str, str]) -> str | None:
    count = len(os.sched_getaffinity(0))
    return f"there is {count}" if option != "all" and int(option) > count else None


def _obstacle_to_locale(option: str, _: Mapping[str, str]) -> str | None:
    known = subprocess.run(["locale", "-a"], capture_output=True, text=True).stdout.lower().split()
    return None if option.lower().replace("utf-8", "utf8") in (*known, "c") else "it is not installed"


def _obstacle_to_programs(option: str, _: Mapping[str, str]) -> str | None:
    missing = [] if any(map(shutil.which, BROWSERS)) else ["chromium"]
    missing += [] if shutil.which("ffmpeg") else ["ffmpeg"]
    return f"no {' and no '.join(missing)}" if option == "with" and missing else None


OBSTACLES: dict[str, Callable[[str, Mapping[str, str]], str | None]] = {
    "user": _obstacle_to_user,
    "dependencies": _obstacle_to_dependencies,
    "python": _obstacle_to_python,
    "cores": _obstacle_to_cores,
    "checkout": lambda *_: None,
    "locale": _obstacle_to_locale,
    "programs": _obstacle_to_programs,
}
"""Functions that return why an option of a setting is unavailable, given the previous settings, or None."""
