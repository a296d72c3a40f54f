"""Styles that the page saves for all commands, in the folder of the user."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vidstyle.assets import asset_folder
from vidstyle.errors import UsageError
from vidstyle.export.export_style import export_style
from vidstyle.preview.outputs import output_path
from vidstyle.preview.places import check_name
from vidstyle.style import PLAIN, Style, user_styles


def save_style_of_user(style: Style, name: str, overwrite: bool = False) -> Path:
    """Save a style to the folder of the user, where all commands find it by name.

    Raises:
        UsageError: the name is invalid, or is the name of a shipped style or an existing file.
        OutputError: the file cannot be written.
    """
    folder = user_styles()
    name = check_name(name, ".toml")
    if Path(name).stem == PLAIN or (asset_folder("styles") / name).exists():
        raise UsageError(name, "is the name of a shipped style", "choose another name")
    folder.mkdir(parents=True, exist_ok=True)
    target = output_path(folder, name, ".toml", overwrite)
    export_style(replace(style, name=target.stem), target, overwrite=overwrite)
    return target
