"""The documents: their commands parse, their links and files exist, generated parts are current."""

from __future__ import annotations

import re
import runpy
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from covering import in_one_test

from tools import performance
from tools.pictures import gallery
from vidstyle.cli import commands
from vidstyle.cli.terminal.reporting import Reporting
from vidstyle.export.export_targets import EXPORT_TARGETS
from vidstyle.style import load_style, override

ROOT = Path(__file__).parents[2]
PROGRAM = ("vidstyle", ".venv/bin/vidstyle")


def calls(path: Path) -> Iterator[list[str]]:
    """Return the arguments of each call of the program in shell blocks of a document, also in pipes."""
    for block in path.read_text(encoding="utf-8").split("```sh\n")[1:]:
        for line in block.partition("```")[0].replace("\\\n", " ").splitlines():
            words = [*shlex.split(re.sub(r"(^|\s)#.*", "", line)), "|"]
            while words:
                end = words.index("|")
                if words[0] in PROGRAM:
                    yield words[1:end]
                words = words[end + 1 :]


PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "examples").glob("*.md")])
COMMANDS = [
    words for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))) for words in calls(path)
]


def test_there_are_commands_to_look_at() -> None:
    assert {words[0] for words in COMMANDS} > {"render", "live", "comic", "styles", "train"}


@in_one_test("words", COMMANDS)
def test_a_command_in_the_documents_is_understood(words: list[str]) -> None:
    context = click.Context(commands, obj=Reporting())
    command = commands.get_command(context, words[0])
    assert command is not None
    with command.make_context(words[0], words[1:], parent=context) as parsed:
        names = parsed.params.get("style_name") or parsed.params.get("style") or ""
        for name in names.split(",") if names and isinstance(names, str) else names:
            override(load_style(name), parsed.params.get("changes") or ())


def test_export_targets_are_documented() -> None:
    rows = [
        f"| `vidstyle export ink {target.example}` | {target.help} |" for target in EXPORT_TARGETS.values()
    ]
    text = (ROOT / "docs" / "everywhere.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `vidstyle export .* \|$", text, re.MULTILINE) == rows


def test_files_that_the_documents_name_exist() -> None:
    named = [
        name
        for page in ("CONTRIBUTING.md", "README.md", "SECURITY.md", "docs/architecture.md")
        for name in re.findall(
            r"[`(]((?:vidstyle|shaders|tools|tests|docs|examples)/[\w/.]*)[`)]",
            (ROOT / page).read_text("utf-8"),
        )
        if "NAME" not in name
    ]
    places = ROOT, ROOT / "vidstyle", ROOT / "vidstyle/comic"
    missing = [name for name in named if not any((place / name).exists() for place in places)]
    assert len(named) > 40 and missing == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)(?:#[\w-]*)?\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if "://" not in link and not (page.parent / link).exists()] == []


def test_rules_that_docstrings_cite_exist() -> None:
    rules = (ROOT / "docs" / "rules.md").read_text(encoding="utf-8")
    headings = {line.removeprefix("## ").lower() for line in rules.splitlines() if line.startswith("## ")}
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "vidstyle").rglob("*.py")]
    cited = {name.lower() for text in texts for name in re.findall(r"docs/rules\.md, ([A-Za-z ]+)", text)}
    assert cited and cited <= headings


@pytest.mark.parametrize("section", ["peers", "film", "bench"])
def test_measurements_replace_those_in_the_document(section: str) -> None:
    page = performance.PAGE.read_text(encoding="utf-8")
    begin = page.index(f"<!-- {section} -->")
    end = page.index("<!-- end -->", begin)
    assert page[begin:end].count("|") > 20
    changed = performance.replace_section(page, section, "machine: here\n\n## 8x8, CPU\n")
    assert changed == f"{page[:begin]}<!-- {section} -->\nmachine: here\n\n### 8x8, CPU\n{page[end:]}"
    with pytest.raises(ValueError, match="no section elsewhere"):
        performance.replace_section(page, "elsewhere", "")


PATTERNS = ("*.py", "drivers/*.py", "pictures/*.py", "tables/*.py", "*/__main__.py")
TOOLS = [path for pattern in PATTERNS for path in ROOT.glob(f"tools/{pattern}")]


@pytest.mark.parametrize("tool", sorted(TOOLS), ids=lambda tool: str(tool.relative_to(ROOT)))
def test_a_tool_can_be_imported(tool: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tool.parent))
    assert runpy.run_path(str(tool), run_name="imported")["__doc__"]


def test_the_gallery_shows_the_current_styles() -> None:
    shown = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    assert shown == gallery.format_page(gallery.sort_styles(), "gallery")
