"""Layers: a file imports only from packages before its own."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from source_files import parsed

ROOT = Path(__file__).parents[2]
FILES = sorted([*(ROOT / "vidstyle").rglob("*.py"), *(ROOT / "tools").rglob("*.py")])

ORDER = (
    (ROOT / "docs" / "rules.md").read_text(encoding="utf-8").partition("## Layers")[2].split("```")[1].split()
)
"""The subjects: a package or a file of the package."""

STRANGERS = {"media", "cpu", "gpu"}
"""These do not know one another."""

HOMES = {
    "PIL": "comic",
    "aiohttp": "web live explore design",
    "av": "media",
    "click": "cli",
    "fsspec": "media",
    "llvmlite": "core",
    "moderngl": "gpu",
    "numba": "core",
    "ray": "batch",
    "rich": "cli",
    "tomlkit": "style",
}
"""The subjects that import a library."""


def subject_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return "tools" if parts[0] == "tools" else parts[1]


def statements(tree: ast.AST, types: bool = True) -> Iterator[ast.AST]:
    """All statements in a tree, wherever in it; with or without what only types need."""
    test = getattr(tree, "test", None)
    is_for_types = isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"
    for part in ("body", "handlers", "cases", "orelse", "finalbody"):
        for each in getattr(tree, part, ()) if types or not is_for_types or part != "body" else ():
            yield each
            yield from statements(each, types)


def imports(path: Path, types: bool = True) -> Iterator[str]:
    """The full names of all that a file imports, wherever in it; with or without what only types need."""
    for node in statements(parsed(path), types):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: import by full names"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def wrong_imports(path: Path) -> Iterator[str]:
    subject = subject_of(path)
    libraries = {name.partition(".")[0] for name in imports(path, types=False)}
    for library in sorted(libraries & HOMES.keys()):
        if subject not in (*HOMES[library].split(), "tools"):
            yield f"{library} belongs to {HOMES[library]}"
    known = {f"{name}.".split(".")[1] for name in imports(path) if name.startswith("vidstyle")}
    for other in sorted(known & set(ORDER) - {subject}):
        if ORDER.index(other) > ORDER.index(subject) or {other, subject} <= STRANGERS:
            yield f"{subject} must not know {other}"


@pytest.mark.parametrize(
    ("folder", "known"),
    [
        ("vidstyle/media/capture", ["monotonic.py"]),
        ("vidstyle/live", []),
        ("tests", ["waiting.py"]),
        ("examples", []),
    ],
)
def test_the_time_is_known_in_one_place(folder: str, known: list[str]):
    """What depends on time takes a clock as an argument, and a test waits for a condition."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / folder).rglob("*.py")}
    assert known == [
        name for name, text in texts.items() if re.search(r"^\s*(import|from) time\b", text, re.M)
    ]


def test_files_import_only_from_before_themselves() -> None:
    own = {ROOT / "vidstyle" / name for name in ("__init__.py", "__main__.py")}
    files = [path for path in FILES if path not in own]
    assert {subject_of(path) for path in files} <= set(ORDER), "give it a place in ORDER"
    assert [f"{path}: {wrong}" for path in files for wrong in wrong_imports(path)] == []


def circle(paths: Iterable[Path]) -> list[str]:
    """Some files that import one another in a circle, or none."""
    modules = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in paths
    }
    graph = {
        module: {
            other
            for name in imports(path)
            if (other := name if name in modules else name.rpartition(".")[0]) in modules and other != module
        }
        for module, path in modules.items()
    }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_files_import_one_another_in_one_direction() -> None:
    """Also in functions and for types: who reads one file of a circle has to read all."""
    assert len(FILES) > 400 and circle(FILES) == []


@pytest.mark.parametrize(
    "line",
    [
        "from vidstyle.core.two import name",
        "from vidstyle.core import two",
        "def call():\n    import vidstyle.core.two",
        "if TYPE_CHECKING:\n    from vidstyle.core.two import Name",
    ],
)
def test_a_circle_is_seen(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    one, two = (tmp_path / f"vidstyle/core/{name}.py" for name in ("one", "two"))
    one.parent.mkdir(parents=True)
    one.write_text(line, encoding="utf-8")
    assert circle([one]) == []
    two.write_text("from vidstyle.core.one import call", encoding="utf-8")
    assert {*circle([one, two])} == {"vidstyle.core.one", "vidstyle.core.two"}


def test_numba_and_llvm_have_one_door() -> None:
    """Few files know them, so that a new version of either is looked at in these only."""
    folder = ROOT / "vidstyle" / "core" / "kernels"
    found: dict[str, set[Path]] = {"numba": set(), "llvmlite": set()}
    for path in (ROOT / "vidstyle").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for library in re.findall(r'(?:^\s*(?:from|import) |import_module\(")(numba|llvmlite)\b', text, re.M):
            found[library].add(path)
    own = ("compiler.py", "entry_function.py")
    assert found["numba"] == {folder / name for name in (*own, "plain_numba.py")}
    assert found["llvmlite"] == {folder / name for name in (*own, "engine.py", "vectors.py")}


def test_plans_and_shaders_are_made_without_opengl() -> None:
    """gpu/compile knows no device: its plans are explained, and later exported, on machines without a GPU."""
    for path in (ROOT / "vidstyle/gpu/compile").glob("*.py"):
        known = {name for name in imports(path, types=False) if name.startswith(("vidstyle.gpu", "moderngl"))}
        assert all(name.startswith("vidstyle.gpu.compile") for name in known), path


def test_no_folder_is_a_heap() -> None:
    """Fewer than twenty files in a folder; `blocks` has one for each block."""
    folders = {path.parent for name in ("vidstyle", "tools", "tests") for path in (ROOT / name).rglob("*.py")}
    counts = {folder.relative_to(ROOT).as_posix(): len([*folder.glob("[!_]*.py")]) for folder in folders}
    assert [name for name, count in counts.items() if count >= 20 and not name.endswith("/blocks")] == []


def test_every_folder_with_code_is_a_package() -> None:
    """Otherwise its files would be imported as top-level modules, such as media/codecs.py as `codecs`."""
    folders = {path.parent for path in (ROOT / "vidstyle").rglob("*.py")}
    assert [folder.name for folder in folders if not (folder / "__init__.py").exists()] == []


@pytest.mark.parametrize(
    ("place", "line", "wrong"),
    [
        ("vidstyle/media/x.py", "from vidstyle.style import load_style", "media must not know style"),
        ("vidstyle/cpu/x.py", "import vidstyle.media.read.reader", "cpu must not know media"),
        ("vidstyle/style/x.py", "def f():\n    import vidstyle.cpu", "style must not know cpu"),
        ("vidstyle/blocks/x.py", "import av", "av belongs to media"),
        ("vidstyle/pipeline/render.py", "from rich.progress import Progress", "rich belongs to cli"),
    ],
)
def test_a_wrong_import_is_seen(
    place: str, line: str, wrong: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    path = tmp_path / place
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(line, encoding="utf-8")
    assert list(wrong_imports(path)) == [wrong]


@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import vidstyle", "av cv2 numba moderngl numpy click rich tomlkit"),
        ("from vidstyle.cli import main", "av cv2 numba moderngl"),
        ("import vidstyle.pipeline.render", "cv2 llvmlite numba moderngl vidstyle.gpu.compile.plan"),
    ],
)
def test_importing_loads_nothing_heavy(code: str, heavy: str) -> None:
    """`vidstyle --help` answers at once because libraries are imported when they are used."""
    program = f"{code}\nimport sys\nprint(*sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert set(heavy.split()).isdisjoint(run.stdout.split())
