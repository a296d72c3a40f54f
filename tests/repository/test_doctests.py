"""The examples in docstrings are true, and every module can be imported alone."""

from __future__ import annotations

import doctest
import importlib
import linecache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "vidstyle"


@pytest.mark.parametrize(
    "part", sorted({path.relative_to(PACKAGE).parts[0] for path in PACKAGE.rglob("*.py")})
)
def test_examples_in_docstrings_are_true(part: str) -> None:
    linecache.clearcache()  # each docstring has all files looked at that are in it
    for path in sorted([*PACKAGE.glob(part), *(PACKAGE / part).rglob("*.py")]):
        if path.suffix == ".py" and path.name != "__main__.py":
            names = path.relative_to(PACKAGE.parent).with_suffix("").parts
            module = importlib.import_module(".".join(names).removesuffix(".__init__"))
            assert doctest.testmod(module).failed == 0, path
