"""The installed wheel: it contains all that it needs to run, and nothing else."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest
from media import make_picture

import vidstyle

ROOT = Path(__file__).parents[2]
SHIPPED = {
    "vidstyle": {".py", ".html", ".json", ".css", ".js", ".svg", ".typed", ".toml", ".webp", ".png", ".txt"},
    "shaders": {".glsl"},
    "filters_bank": {".npz", ".md"},
}
"""The kinds of files that each folder ships."""

RESTYLE = """
import json, sys
import numpy
import vidstyle
from vidstyle.blocks import all_blocks
from vidstyle.style import style_names

style = vidstyle.load_style(style_names()[0])
picture = numpy.linspace(0, 255, 40 * 60 * 3).reshape(40, 60, 3).astype(numpy.uint8)
out = vidstyle.stylize(picture, style)
found = {"file": vidstyle.__file__, "blocks": list(all_blocks()), "styles": style_names()}
json.dump(found | {"shape": out.shape, "type": str(out.dtype), "style": style.name}, sys.stdout)
"""


def run(*command: str | Path, folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    build = (sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder)
    run(*build, ROOT, folder=folder)
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of a fresh environment that holds the wheel, and borrows the libraries of this one."""
    folder = tmp_path_factory.mktemp("fresh")
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    run(
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "--quiet",
        "--no-deps",
        "--no-index",
        wheel,
        folder=folder,
    )
    packages = Path(
        run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", folder=folder).strip()
    )
    # A folder named in a .pth file is searched, but .pth files in it are not read: an editable
    # installation of vidstyle there stays out of sight.
    (packages / "borrowed.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    return python


def shipped_files() -> set[str]:
    """What the wheel has to hold, by the files of the checkout."""
    names = set()
    for folder, suffixes in SHIPPED.items():
        paths = [path for path in (ROOT / folder).rglob("*") if path.suffix in suffixes]
        prefix = "" if folder == "vidstyle" else "vidstyle/"
        names |= {prefix + path.relative_to(ROOT).as_posix() for path in paths}
    return names


def test_the_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert names == shipped_files()
    assert {"vidstyle/__init__.py", "vidstyle/py.typed", "vidstyle/blocks/posterize.py"} <= names


def test_the_wheel_says_what_it_is(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        info = f"vidstyle-{vidstyle.__version__}.dist-info"
        metadata = archive.read(f"{info}/METADATA").decode()
        assert f"\nVersion: {vidstyle.__version__}\n" in metadata
        assert "\nLicense-Expression: Apache-2.0\n" in metadata
        assert b"Apache License" in archive.read(f"{info}/licenses/LICENSE")
        assert b"vidstyle = vidstyle.__main__:main" in archive.read(f"{info}/entry_points.txt")


def test_the_installed_package_restyles_a_picture(python: Path, tmp_path: Path) -> None:
    found = json.loads(run(python, "-I", "-W", "error", "-c", RESTYLE, folder=tmp_path))
    assert Path(found["file"]).is_relative_to(python.parent.parent)
    assert {f"vidstyle/blocks/{name}.py" for name in found["blocks"]} <= shipped_files()
    assert len(found["blocks"]) >= 17
    assert {f"vidstyle/styles/{name}.toml" for name in found["styles"]} - shipped_files() == {
        "vidstyle/styles/plain.toml"
    }
    assert (found["shape"], found["type"]) == ([40, 60, 3], "uint8")


def test_what_texts_say_to_install_can_be_installed() -> None:
    named = {
        path.name: {
            extra
            for extras in re.findall(r"(?:vidstyle|'\.)\[([\w,]+)\]", path.read_text(encoding="utf-8"))
            for extra in extras.split(",")
        }
        for path in (ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "vidstyle").rglob("*.py"))
    }
    assert {"web", "comic"} <= named["README.md"] & named["CHANGELOG.md"]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert set().union(*named.values()) <= project["optional-dependencies"].keys()


def test_the_installed_commands_list_blocks_and_styles(python: Path, tmp_path: Path) -> None:
    program = python.parent / "vidstyle"
    assert vidstyle.__version__ in run(program, "--version", folder=tmp_path)
    blocks = run(program, "blocks", "--json", folder=tmp_path)
    assert "posterize" in json.dumps(json.loads(blocks))
    styles = run(program, "styles", "--json", folder=tmp_path)
    assert "plain" in json.dumps(json.loads(styles))
    assert list(tmp_path.iterdir()) == []


def test_the_installed_command_makes_a_preview(python: Path, tmp_path: Path) -> None:
    picture = make_picture(tmp_path / "in.png", size=(32, 18))
    run(
        python.parent / "vidstyle", "styles", "plain", "--preview", picture, "-o", "out.html", folder=tmp_path
    )
    assert "data:image/jpeg" in (tmp_path / "out.html").read_text(encoding="utf-8")
