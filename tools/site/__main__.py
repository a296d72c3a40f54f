"""Build the site; see `tools.site`."""

from __future__ import annotations

import logging
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.config.defaults import MkDocsConfig

from tools.api_reference import write_reference_pages
from tools.pictures.gallery import PHOTOGRAPHS
from tools.site.documents import copy_documents, page_titles
from tools.site.reference import block_examples, write_reference
from vidstyle.gallery.showcase import ExamplePicture, write_showcase
from vidstyle.style import PLAIN, load_style, style_names

DEFAULT_FOLDER = Path("build/site")
EXAMPLES = {"astronaut": "A face", "cat": "A cat", "rocket": "Night"}
"""Example photographs from `PHOTOGRAPHS`, and their titles."""
EXCLUDED = "**/*.map", "assets/javascripts/lunr/**"
"""Unused files of the theme: source maps, and search in other languages."""


def main() -> None:
    """Build the site and print its size."""
    folder = Path(*sys.argv[1:]) if sys.argv[1:] else DEFAULT_FOLDER
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    build_site(folder, [name for name in style_names() if name != PLAIN])
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    print(f"{folder / 'index.html'}: {size / 1e6:.1f} MB")


def build_site(folder: Path, tried: Sequence[str]) -> None:
    """Write the site to a folder, and replace an existing site.

    Args:
        tried: names of the styles on the page where visitors restyle their own pictures.

    Raises:
        SystemExit: the folder has files other than a site, or a link is broken.
    """
    if folder.is_dir() and any(folder.iterdir()) and not (folder / "search").is_dir():
        sys.exit(f"{folder} has files that are not a site; choose another folder")
    with tempfile.TemporaryDirectory() as pages:
        copy_documents(Path(pages))
        reference = write_reference(Path(pages))
        write_reference_pages(Path(pages) / "api")
        _write_try_page(Path(pages) / "try", tried)
        build(_configuration(Path(pages), folder.absolute(), reference))
    for pattern in EXCLUDED:
        for path in folder.glob(pattern):
            if path.is_file():
                path.unlink()


def _configuration(pages: Path, folder: Path, reference: list[Any]) -> MkDocsConfig:
    nav = [{"vidstyle": "index.md"}, {"Try it": "try/index.html"}, {"Guide": page_titles()}, *reference]
    settings = str(Path(__file__).with_name("mkdocs.yml"))
    return load_config(settings, nav=nav, docs_dir=str(pages), site_dir=str(folder))


def _write_try_page(folder: Path, names: Sequence[str]) -> None:
    styles = [load_style(name) for name in names]
    examples = [ExamplePicture(name, title, PHOTOGRAPHS[name]) for name, title in EXAMPLES.items()]
    write_showcase(folder, styles, examples, "Try vidstyle", unlisted=block_examples())


if __name__ == "__main__":
    main()
