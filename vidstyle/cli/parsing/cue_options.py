"""The options that let a style change over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from vidstyle.cli.parsing.command import Decorator, Group, option
from vidstyle.cli.parsing.common_options import Parsed, number, style_from_options
from vidstyle.cli.parsing.path_arguments import PATH
from vidstyle.cues.style_change import CHANGE_HELP, MAX_PARTS, StyleChange, in_turn
from vidstyle.errors import UsageError, log

if TYPE_CHECKING:
    from vidstyle.cues.cue_list import CueList
    from vidstyle.cues.rotation import StyleChoice, StyleRotation, Turn
    from vidstyle.media.options import ReadOptions
    from vidstyle.pipeline.scenes import Scene
    from vidstyle.style import Style


def by_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --by and --seed, which give each part of a film one of several styles."""
    text = f"Change between the styles of --style, as in ink,noir,poster: {CHANGE_HELP}."
    by = option("--by", type=Parsed("change", StyleChange.parse), group=Group.STYLE, help=text)
    text = "Random seed for the order of the styles of --by.  [default: in turn]"
    seed = option("--seed", type=number(0, whole=True), group=Group.STYLE, help=text)
    return by(seed(command))


CUES_HELP = "File with styles and their times, as 'vidstyle cues' writes it; instead of --style."


def cues_option(text: str = CUES_HELP) -> Decorator:
    """Add --cues, a file with styles and their times."""
    return option("--cues", type=PATH, metavar="FILE", group=Group.STYLE, help=text)


def look_from_options(options: Mapping[str, Any]) -> StyleChoice:
    """Return the style that the options describe, or the styles over time."""
    from vidstyle.cues.rotation import StyleRotation

    if options["cues"] is not None:
        return _cues_from_file(options)
    if options["by"] is not None:
        styles = (style_from_options({**options, "style_name": name}) for name in style_list(options))
        return StyleRotation(tuple(styles), options["by"], options["seed"])
    if options["seed"] is not None:
        raise UsageError("--seed", "needs --by")
    if "," in (options["style_name"] or ""):
        raise UsageError("--style", "has several styles", "say when to change, such as --by scene")
    return style_from_options(options)


def scenes_of(
    source: str, read: ReadOptions | None = None, pictures: bool = True
) -> tuple[list[Scene], Fraction | None]:
    """Return the scenes of the source, and its rate; see `find_scenes`."""
    from vidstyle.pipeline.scenes import find_scenes

    log.info("%s: finding the scenes", source)
    return find_scenes(source, read, pictures)


def styles_of_scenes(scenes: Sequence[Scene], options: Mapping[str, Any]) -> list[str | None]:
    """Return the name of a style for each scene, by --style, --by and --seed; None: as before."""
    from vidstyle.style import load_style

    change: StyleChange = options["by"] or StyleChange("scene")
    if change.kind == "seconds":
        raise UsageError("--by", "is a time, and a cue file has scenes", "use it with 'vidstyle render'")
    names = style_list(options)
    choices = [load_style(name) for name in names]
    parts = iter(names[number] for number in _chosen(scenes, choices, change, options["seed"]))
    return [next(parts) if number % int(change.step) == 0 else None for number in range(len(scenes))]


def _cues_from_file(options: Mapping[str, Any]) -> CueList:
    from vidstyle.cues.cue_file import read_cue_file

    refuse_with_cues(options)
    return read_cue_file(options["cues"])


def refuse_with_cues(options: Mapping[str, Any]) -> None:
    """Raise UsageError for an option that a cue file replaces."""
    names = {"style_name": "--style", "by": "--by", "seed": "--seed", "changes": "--set"}
    names |= {name: f"--{name}" for name in ("steady", "detail", "focus", "only", "keep", "background")}
    if given := [text for name, text in names.items() if options.get(name) not in (None, ())]:
        raise UsageError(given[0], "cannot be used with --cues", "write it in the cue file")


def look_of_film(source: str, look: StyleChoice, read: ReadOptions) -> Style | CueList:
    """Return the look of a film; the film is read once to find its scenes, where they decide."""
    from vidstyle.cues.rotation import StyleRotation

    return look.cue_list(turns_of_film(source, look, read)) if isinstance(look, StyleRotation) else look


def turns_of_film(source: str, rotation: StyleRotation, read: ReadOptions) -> list[Turn]:
    """Return when the styles of a film take turns; its times count from the start of the whole film."""
    change = rotation.change
    if change.kind == "seconds":
        starts = change.starts(_duration(source, read) or MAX_PARTS * change.step)
        return [*zip(starts, in_turn(range(len(rotation.styles)), len(starts), rotation.seed), strict=True)]
    scenes, _ = scenes_of(source, read, pictures=change.kind == "like")
    starts = [(read.start or 0) + each.start for each in scenes[:: int(change.step)]]
    return [*zip(starts, _chosen(scenes, rotation.styles, change, rotation.seed), strict=True)]


def _chosen(
    scenes: Sequence[Scene], choices: Sequence[Style], change: StyleChange, seed: int | None
) -> list[int]:
    """Return the number of a style for each part of a film."""
    if change.kind == "like":
        from vidstyle.explore.matching.scene_styles import suiting_styles

        return [choices.index(style) for style in suiting_styles([each.still for each in scenes], choices)]
    return in_turn(range(len(choices)), -(-len(scenes) // int(change.step)), seed)


def style_list(options: Mapping[str, Any]) -> list[str]:
    """Return the names in --style, which are separated by commas."""
    names = [name.strip() for name in (options["style_name"] or "").split(",")]
    if not all(names):
        raise UsageError("--style", "has a comma without a name", "give several, as in ink,noir,poster")
    return names


def _duration(source: str, read: ReadOptions) -> Fraction | None:
    from vidstyle.media.read.reader import open_source

    if source == "-":
        return None
    with closing(open_source(source, read)) as opened:
        return opened.duration
