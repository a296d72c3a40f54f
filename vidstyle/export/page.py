"""Export as a self-contained HTML file that restyles a camera, films and photographs in a browser."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import cv2
import numpy as np

import vidstyle
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.export import EXAMPLE_FILE, join_modules, module_text
from vidstyle.export.adjust import is_alike, main_controls, tables_fit, tables_of, with_tints
from vidstyle.gpu.compile.es import EsPlan
from vidstyle.media.picture_bytes import webp_bytes
from vidstyle.renderer import restyle_array
from vidstyle.style import Style, set_values
from vidstyle.style.panel import panel

WORKING_SIDES_PX = (720, 360, 1080)
"""Working sizes of the page: the shorter side; the default comes first."""

_EXAMPLE_WIDTH_PX, _EXAMPLE_QUALITY = 960, 75
"""Of the example in the style, which the page shows until it has drawn it."""
_PAGE_MODULE = Path(__file__).with_name("page.js")


def page_of_style(style: Style) -> str:
    """Return the page of a style.

    Raises:
        StyleError: the style is invalid.
    """
    script = page_script(_PAGE_MODULE)
    css = viewer_css()
    data = json.dumps(page_data(style), separators=(",", ":")).replace("</", "<\\/")
    return Template(_text("page.html")).substitute(
        name=escape(style.name),
        stage=viewer_markup(style),
        example=_address(EXAMPLE_FILE.read_bytes()),
        restyled=_address(restyled_example(style)),
        css=css,
        css_sum=_sum(css),
        script=script,
        script_sum=_sum(script),
        data=data,
        version=vidstyle.__version__,
    )


def viewer_markup(style: Style, more: str = "") -> str:
    """Return the HTML of the large picture of a style and its panel, which `viewer.js` uses.

    Args:
        more: HTML for the end of the panel.
    """
    about = style.about  # the controls stand below it, under plainer names
    note = re.sub("`([^`]*)`", r"<code>\1</code>", escape(about))
    return Template(_text("stage.html")).substitute(name=escape(style.name), note=note, more=more)


def viewer_css() -> str:
    """Return the CSS of `viewer_markup` and of the elements of a page, without comments for developers."""
    return minify_css(module_text("components.css") + _text("page.css"))


def minify_css(css: str) -> str:
    """Return CSS without comments, indentation and line ends; strings and addresses are unchanged."""
    comment = r"/\*(?:(?!\*/).)*\*/"
    space = rf"(?:\s|{comment})*"
    kept = r""""(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|url\([^)]*\)"""
    parts = rf"{space}([{{}};]){space}|{comment}|({kept})"
    return re.sub(parts, lambda found: found[1] or found[2] or "", css, flags=re.S)


def page_script(module: Path) -> str:
    """Return a module with the modules that it imports, without exports, comments, casts and blank space."""
    text = re.sub(r"^export (?=class|function|const|async)", "", join_modules(module), flags=re.M)
    # Only text in backquotes goes over line ends.
    comment = r"^ *(?://[^\n]*|/\*\*(?:(?!\*/).)*\*/)\n"
    cast = r"/\*\* @type {[^*]*} \*/ (?=\()"
    parts = rf"(`(?:\\.|[^`\\])*`)|{comment}|{cast}|^ +|^\n"
    return re.sub(parts, lambda found: found[1] or "", text, flags=re.M | re.S)


def page_data(style: Style, sides: Sequence[int] = WORKING_SIDES_PX) -> dict[str, Any]:
    """Return the plans of a style, its controls and their effect on plan values.

    Shader texts and textures are shared by all plans.

    Args:
        sides: working sizes: the shorter side in pixels.
    """
    style = with_tints(style)
    controls = main_controls(style)
    plans: list[dict[str, Any]] = []
    for side in sides:
        plan = EsPlan.of(style, _width(side), side)
        alike = next((other for other in plans if is_alike(plan.data, other["plan"])), None)
        plans.append({"side": side, "plan": plan.data, "tables": _tables(style, plan, controls, alike)})
    shown = [control for control in controls if all(control["path"] in each["tables"] for each in plans)]
    texts = list(dict.fromkeys(text for each in plans for text in each["plan"]["shaders"]))
    textures = {name: made for each in plans for name, made in each["plan"].pop("textures").items()}
    for each in plans:
        each["plan"]["shaders"] = [texts.index(text) for text in each["plan"]["shaders"]]
    return {
        "version": vidstyle.__version__,
        "name": style.name,
        "plans": plans,
        "shaders": texts,
        "textures": textures,
        "controls": shown,
        "focus": bool(style.focus and style.height),
        "fixed": [control["path"] for control in controls if control not in shown],
        "variants": _variants(style, shown),
    }


def _tables(
    style: Style, plan: EsPlan, controls: list[dict[str, Any]], alike: dict[str, Any] | None
) -> dict[str, Any]:
    """Return tables by path of the control; reuse the tables of a similar plan if they fit."""
    tables = {}
    for control in controls:
        serves = alike is not None and control.get("unit") != "px"
        found = alike["tables"].get(control["path"], []) if alike and serves else []
        if not serves or not tables_fit(found, control, plan.data):
            found = tables_of(style, plan, control, lambda changed: EsPlan.of(changed, *plan.data["size"]))
        if found:
            tables[control["path"]] = found
    return tables


def _variants(style: Style, controls: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return the changed values of each variant that changes only these controls, by path."""
    found = {}
    for name in style.variants:
        varied = panel(set_values(style, style.variants[name]), style)["entries"]
        changed = {entry["path"]: entry["value"] for entry in varied if entry["value"] != entry["start"]}
        if changed.keys() <= {control["path"] for control in controls}:
            found[name] = changed
    return found


def _width(side: int) -> int:
    return -(-side * 16 // 9)


def restyled_example(style: Style) -> bytes:
    """Return the example in a style, in the detail in which the page draws it, as WebP."""
    example = cv2.imdecode(np.frombuffer(EXAMPLE_FILE.read_bytes(), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert example is not None
    side = WORKING_SIDES_PX[0]
    large = cv2.resize(example, (_width(side), side), interpolation=cv2.INTER_CUBIC)
    bare = replace(style, only="", keep="", behind=None, focus=0)  # the page finds no faces and no people
    with CpuRenderer(bare) as renderer:
        drawn = restyle_array(renderer, large)
    small = cv2.resize(drawn, (_EXAMPLE_WIDTH_PX, _EXAMPLE_WIDTH_PX * 9 // 16), interpolation=cv2.INTER_AREA)
    return webp_bytes(small, _EXAMPLE_QUALITY)


def _address(picture: bytes) -> str:
    return "data:image/webp;base64," + base64.b64encode(picture).decode()


def _text(name: str) -> str:
    return (files(__package__) / name).read_text(encoding="utf-8")


def _sum(text: str) -> str:
    """Return the hash source that allows exactly this text in a content security policy."""
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"
