"""The options that limit a style to a region of the picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import Group, option

if TYPE_CHECKING:
    from vidstyle.style import Style


def region_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --only, --keep, --background and --model."""
    group = Group.STYLE
    text = "Restyle only this region: people, background, faces, skin, or a mask of the style."
    only = option("--only", metavar="MASK", group=group, help=text)
    keep = option("--keep", metavar="MASK", group=group, help="Leave this region unchanged.")
    text = "Show people in front of this: a style, blur, a colour such as #00b140, a picture or a film."
    background = option("--background", metavar="STYLE|blur|COLOR|FILE", group=group,
                        callback=_use_backdrop, help=text)  # fmt: skip
    text = "Find people with this TFLite or ONNX model.  [default: the model of mediapipe, if installed]"
    model = option("--model", type=click.Path(path_type=Path), metavar="FILE", group=group,
                   expose_value=False, callback=_use_model, help=text)  # fmt: skip
    return only(keep(background(model(command))))


def _use_model(context: click.Context, _: click.Parameter, path: Path | None) -> None:
    if path is not None and not context.resilient_parsing:
        from vidstyle.regions.chosen_files import MODEL_VARIABLE, use_file

        context.with_resource(use_file(MODEL_VARIABLE, path))


def _use_backdrop(context: click.Context, _: click.Parameter, text: str | None) -> str | None:
    """Return the style or file behind people; a file that is not a style is the backdrop."""
    path = Path(text or "")
    if context.resilient_parsing or path.suffix in ("", ".toml") or not path.is_file():
        return text
    from vidstyle.regions.chosen_files import BACKDROP_VARIABLE, use_file
    from vidstyle.style.mask_declarations import BACKDROP

    context.with_resource(use_file(BACKDROP_VARIABLE, path))
    return BACKDROP


def with_background(style: Style, options: Mapping[str, Any]) -> Style:
    """Return the style with the background of the options, if there is one."""
    if options["background"] is None:
        return style
    from vidstyle.style.behind import style_behind

    return replace(style, behind=style_behind(options["background"]))
