"""The web site, `make site`: its pages, links and requests."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

pytest.importorskip("mkdocs", reason="the site is built by MkDocs")

import vidstyle
from tools.site.__main__ import build_site
from vidstyle.blocks import all_blocks
from vidstyle.style import PLAIN, style_names

LOADED = {("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src"), ("link", "href")}
"""Attributes whose addresses a browser loads automatically."""


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


def check_api_reference(folder: Path) -> None:
    page = (folder / "vidstyle.html").read_text(encoding="utf-8")
    assert all(f'id="{name}"' in page for name in vidstyle.__all__)
    assert 'id="Renderer.__call__"' in page
    blocks = (folder / "blocks.html").read_text(encoding="utf-8")
    assert all(f'id="{name}"' in blocks for name in all_blocks())


def test_a_site_is_whole_and_loads_nothing_from_other_hosts(tmp_path: Path) -> None:
    """One test, since building takes longer than looking."""
    site = tmp_path / "out"
    build_site(site, ["pixel"])
    pages = {path: Addresses(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    assert list(broken_links(pages)) == []
    assert [link for page in pages.values() for link in page.loaded if urlsplit(link).netloc] == []
    assert [path for path in site.rglob("*.css") if "url(http" in path.read_text(encoding="utf-8")] == []
    for name in style_names():
        assert name == PLAIN or site / "styles" / f"{name}.html" in pages
    for name, block in all_blocks().items():
        text = (site / "blocks" / f"{name}.html").read_text(encoding="utf-8")
        assert all(f"<code>{parameter}</code>" in text for parameter in block.parameters), name
        for example in pages[site / "blocks" / f"{name}.html"].loaded:
            if example.startswith("../try/"):
                assert (site / "try/data/styles" / f"{urlsplit(example).fragment}.js").is_file()
    check_api_reference(site / "api")
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    titles = {entry["title"] for entry in index["docs"]}
    assert {"How do I restyle a film?", "Which style is like a comic?", "How do I write a block?"} <= titles


def test_a_broken_link_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("")
    found = broken_links({path: Addresses('<a href="none.html">a</a><a href="#none">b</a>')})
    assert list(found) == ["page.html: none.html", "page.html: #none"]


def test_a_folder_with_other_files_is_refused(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    with pytest.raises(SystemExit, match="not a site"):
        build_site(tmp_path, [])
    assert (tmp_path / "letter.txt").read_text() == "mine"
