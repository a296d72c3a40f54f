"""The web site, `make site`: its pages, links and requests."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

pytest.importorskip("mkdocs", reason="the site is built by MkDocs")

from tools.site.__main__ import build_site
from tools.site.documents import ROOT, heading_id
from vidstyle.blocks import all_blocks
from vidstyle.style import PLAIN, style_names

LOADED = {("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src"), ("link", "href")}
"""Attributes whose addresses a browser loads by itself."""


class Addresses(HTMLParser):
    """Collects the addresses and identifiers of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        for key in ("href", "src"):
            if value := values.get(key):
                self.links.append(value)
                if (tag, key) in LOADED and values.get("rel") not in ("canonical", "next", "prev"):
                    self.loaded.append(value)
        self.names |= {name for key in ("id", "name") if (name := values.get(key))}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "out"
    build_site(folder, ["pixel"])
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Addresses]:
    return {path: Addresses(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def broken_links(pages: dict[Path, Addresses]) -> Iterator[str]:
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            # The theme's page for a missing address may be shown at any address.
            if parts.scheme or parts.netloc or path.name == "404.html":
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                yield f"{path.name}: {link}"
            elif parts.fragment and target in pages and "try" not in target.parts:
                if unquote(parts.fragment) not in pages[target].names:
                    yield f"{path.name}: {link}"


def test_every_link_leads_somewhere(pages: dict[Path, Addresses]) -> None:
    assert len(pages) > 80
    assert list(broken_links(pages)) == []


def test_a_broken_link_is_seen(pages: dict[Path, Addresses]) -> None:
    path = next(iter(pages))
    assert list(broken_links({path: Addresses('<a href="none.html">a</a><a href="#none">b</a>')})) == [
        f"{path.name}: none.html",
        f"{path.name}: #none",
    ]


def test_nothing_is_loaded_from_other_hosts(site: Path, pages: dict[Path, Addresses]) -> None:
    assert [link for page in pages.values() for link in page.loaded if urlsplit(link).netloc] == []
    assert [path for path in site.rglob("*.css") if "url(http" in path.read_text(encoding="utf-8")] == []


def test_each_style_and_block_has_a_page(pages: dict[Path, Addresses], site: Path) -> None:
    for name in style_names():
        assert name == PLAIN or site / "styles" / f"{name}.html" in pages
    for name in all_blocks():
        page = pages[site / "blocks" / f"{name}.html"]
        for parameter in all_blocks()[name].parameters:
            text = (site / "blocks" / f"{name}.html").read_text(encoding="utf-8")
            assert f"<code>{parameter}</code>" in text, (name, parameter)
        examples = [link for link in page.loaded if link.startswith("../try/")]
        if examples:
            (example,) = examples
            assert (site / "try/data/styles" / f"{urlsplit(example).fragment}.js").is_file()


@pytest.mark.parametrize(
    ("question", "page"),
    [
        ("how do I restyle a film", "index.html"),
        ("comic style", "styles/comic.html"),
        ("write a block", "contributing.html"),
    ],
)
def test_search_knows_the_words_of_a_question(question: str, page: str, site: Path) -> None:
    entries = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))["docs"]
    words = [word for word in question.split() if len(word) > 3]
    found = {entry["location"].partition("#")[0] for entry in entries}
    texts = {
        location: " ".join(
            f"{entry['title']} {entry['text']}" for entry in entries if entry["location"].startswith(location)
        ).lower()
        for location in found
    }
    assert all(word in texts[page] for word in words)


def test_a_folder_with_other_files_is_refused(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    with pytest.raises(SystemExit, match="not a site"):
        build_site(tmp_path, [])
    assert (tmp_path / "letter.txt").read_text() == "mine"


def test_headings_have_the_names_that_links_in_the_documents_use() -> None:
    assert heading_id("Style files in an editor", "-") == "style-files-in-an-editor"
    assert (ROOT / "README.md").is_file()
