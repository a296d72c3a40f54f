"""Names of classes and modules of the package are unique."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import vidstyle

PACKAGE = Path(__file__).parents[2] / "vidstyle"
FILES = sorted(PACKAGE.rglob("*.py"))

SAME_ALIASES = {"Pair", "Point"}
"""Type aliases that mean the same wherever they stand."""

SHARED_MODULES = {
    "renderer": "the public one, those of CPU and GPU",
    "session": "of a GPU, of live",
    "stabilizer": "on the CPU, on a GPU",
    "svg": "of a comic page, of a style's graph",
}
"""Names of files that may occur twice: the same thing in two subjects."""


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def defined() -> Iterator[str]:
    """The classes and type aliases of every module, type variables aside."""
    for path in FILES:
        for node in parsed(path).body:
            if isinstance(node, ast.ClassDef):
                yield node.name
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                name = node.targets[0].id
                is_type = name[0].isupper() and not name.isupper()
                if is_type and not ast.unparse(node.value).startswith(("TypeVar", "ParamSpec")):
                    yield name


def test_a_class_or_type_is_defined_once() -> None:
    twice = {name for name, count in Counter(defined()).items() if count > 1 and not name.startswith("_")}
    assert twice <= SAME_ALIASES


def test_public_names_are_classes_or_functions_of_one_meaning() -> None:
    """What `import vidstyle` offers is defined nowhere else, as a class or as a function."""
    functions = Counter(
        node.name
        for path in FILES
        if path.parent.name != "cli"  # a command is called as the function that it runs
        for node in parsed(path).body
        if isinstance(node, ast.FunctionDef)
    )
    classes = Counter(defined())
    assert {name: classes[name] + functions[name] for name in vidstyle.__all__} == dict.fromkeys(
        vidstyle.__all__, 1
    )


def test_a_file_name_occurs_once() -> None:
    """Commands and blocks are called as the user calls them, whatever else is called so."""
    named_by_users = {PACKAGE / "cli", PACKAGE / "blocks"}
    stems = Counter(path.stem for path in FILES if path.parent not in named_by_users)
    twice = {stem for stem, count in stems.items() if count > 1 and not stem.startswith("__")}
    assert twice <= SHARED_MODULES.keys()
