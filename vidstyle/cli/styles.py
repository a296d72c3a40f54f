"""vidstyle styles: list styles, describe, preview or draw one."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli import browser
from vidstyle.cli.bench import FORMS as OPENGL_FORMS
from vidstyle.cli.bench import both_sides
from vidstyle.cli.likeness import print_like
from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import SECONDS, SIZE, STYLE, threads_option
from vidstyle.cli.parsing.path_arguments import PATH, PATH_TEXT, parents_option
from vidstyle.cli.terminal.display import display, list_entry, progress_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.cli.terminal.terminal_pictures import protocol_of, sheet_lines
from vidstyle.errors import StyleError, UsageError, printable
from vidstyle.pipeline.progress import StepProgress

if TYPE_CHECKING:
    from vidstyle.gpu.compile.glsl import Form
    from vidstyle.style import Style

FORMS = (*OPENGL_FORMS, "es")
"""The kinds of shaders: two for OpenGL, one for `vidstyle export`."""


@command(
    "List the styles, or describe one.",
    examples=(
        "vidstyle styles",
        "vidstyle styles comic",
        "vidstyle styles --preview in.mp4 -o sheet.html",
    ),
)
@click.argument("name", required=False, type=STYLE)
@option("--json", "as_json", is_flag=True, group=Group.OUTPUT, help="Print JSON.")
@option("--schema", is_flag=True, group=Group.OUTPUT, help="Print the JSON Schema of style files.")
@option("--preview", metavar="INPUT", type=PATH_TEXT, group=Group.INPUT,
        help="Render a picture, or a frame of a film, in all styles or in NAME; needs -o.")  # fmt: skip
@option("--like", metavar="PICTURE", type=PATH_TEXT, group=Group.INPUT,
        help="Rank the styles by similarity to PICTURE when applied to NAME, a picture or film.")  # fmt: skip
@option("--at", type=SECONDS, group=Group.INPUT,
        help="Time of the frame for --preview.  [default: the middle]")  # fmt: skip
@option("--allow-url", is_flag=True, group=Group.INPUT, help="Allow INPUT to be a URL.")
@option("-o", "--output", type=PATH, metavar="FILE", group=Group.OUTPUT,
        help="Output of --preview (.html, .png or .jpg), --svg (.svg) or --like (.toml).")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite FILE if it exists.")
@browser.open_option
@parents_option("output")
@option("--svg", is_flag=True, group=Group.OUTPUT, help="Draw the graph of the style NAME as SVG.")
@option("--plan", is_flag=True, group=Group.OUTPUT,
        help="Print the GPU passes of the style NAME and the bytes that they transfer.")  # fmt: skip
@option("--size", type=SIZE, default="1920x1080", callback=both_sides, group=Group.OUTPUT,
        help="Picture size for --plan.")  # fmt: skip
@option("--form", type=click.Choice(FORMS), default=FORMS[0], group=Group.OUTPUT,
        help="Kind of shaders for --plan.")  # fmt: skip
@threads_option
@progress_option
@reporting_options
def styles(name: str | None, as_json: bool, schema: bool, **options: Any) -> None:
    """List the styles, or describe the steps and parameters of one: a NAME or a style file.

    NAME:VARIANT is a variant of a style. Put your own styles into ~/.config/vidstyle/styles
    (XDG_CONFIG_HOME; on macOS ~/Library/Application Support, on Windows %APPDATA%) to use them by name.
    """
    from vidstyle.style import describe, load_style, style_names, style_schema

    _reject_unused_options(options)
    if options["like"] is not None:
        print_like(options["like"], name, options, as_json)
    elif schema:
        click.echo(json.dumps(style_schema(), indent=2))
    elif options["preview"] is not None:
        _write_preview(name, options)
    elif options["svg"]:
        _write_svg(name, options["output"], options["overwrite"])
    elif options["plan"]:
        _print_plan(name, options["size"], options["form"], as_json)
    elif name is not None and as_json:
        click.echo(json.dumps(describe(load_style(name)), indent=2))
    elif name is not None:
        style = load_style(name)
        _print_thumbnails({"": style})
        click.echo("\n".join(_details(style, describe(style))))
    elif as_json:
        click.echo(json.dumps([describe(load_style(each)) for each in style_names()], indent=2))
    else:
        _print_list()


def _print_list() -> None:
    from vidstyle.style import load_style, style_names

    styles: dict[str, Style] = {}
    for name in style_names():
        try:
            styles[name] = load_style(name)
        except StyleError as error:  # one of the user's own, which hides no other
            say(str(error))
    _print_thumbnails(styles)
    for name, style in styles.items():
        variants = ", ".join(f"{name}:{variant}" for variant in style.variants)
        variants = f" Variants: {variants}." if variants else ""
        click.echo(list_entry(f"{name:16}", f"{style.summary}{variants}"))


def _print_thumbnails(styles: Mapping[str, Style]) -> None:
    """Show each style applied to a photograph, if the terminal shows pictures."""
    protocol = protocol_of()
    if protocol:
        from vidstyle.gallery.thumbnail import thumbnail

        named = [(name, thumbnail(style)) for name, style in styles.items()]
        click.echo("\n".join([*sheet_lines(named, protocol, get_terminal_size((80, 0)).columns), ""]))


def _reject_unused_options(options: dict[str, Any]) -> None:
    """Reject options that would have no effect."""
    preview, output = options["preview"] is not None, options["output"] is not None
    if options["at"] is not None and not preview:
        raise click.UsageError("--at needs --preview INPUT")
    if output and not (preview or options["svg"] or options["like"]):
        raise click.UsageError("--output needs --preview INPUT, --svg or --like PICTURE")
    if preview and not output:
        raise click.UsageError("--preview needs -o FILE.html, FILE.png or FILE.jpg")


def _write_preview(name: str | None, options: dict[str, Any]) -> None:
    from vidstyle.gallery.preview import write_preview
    from vidstyle.media.read.reader import ReadOptions
    from vidstyle.style import PLAIN, load_style, popular_first

    wanted = popular_first() if name is None else [name]
    names = [PLAIN, *(each for each in wanted if each != PLAIN)]
    read = ReadOptions(start=options["at"], allow_url=options["allow_url"])
    chosen, output = [load_style(each) for each in names], options["output"]
    with display(options["progress"]) as show:
        step = StepProgress(show)
        heading = write_preview(options["preview"], output, chosen, read, options["overwrite"], step)
    say(printable(f"{output}: {heading}"), {"files": [str(output)], "styles": names})
    if output.suffix.lower() == ".html" and browser.is_wanted(options["no_open"]):
        browser.open_page(output.resolve().as_uri())


def _write_svg(name: str | None, output: Path | None, overwrite: bool) -> None:
    from vidstyle.diagram.graph import graph_of
    from vidstyle.diagram.svg import graph_svg
    from vidstyle.media.write.atomic import atomic_file
    from vidstyle.style import load_style

    if name is None:
        raise click.UsageError("--svg needs the NAME of a style")
    style = load_style(name)
    text = graph_svg(graph_of(style), style.name)
    if output is None:
        click.echo(text.encode(), nl=False)
        return
    if output.suffix.lower() != ".svg":
        raise UsageError(output, "cannot be an SVG file", "end it in .svg")
    with atomic_file(output, name, overwrite) as write:
        write(text.encode())


def _print_plan(name: str | None, size: tuple[int, int], form: Form, as_json: bool) -> None:
    from vidstyle.gpu.compile.explain import explain, lines_of
    from vidstyle.gpu.compile.plan import plan_for_video
    from vidstyle.style import load_style

    if name is None:
        raise click.UsageError("--plan needs the NAME of a style")
    style = load_style(name)
    explained = explain(plan_for_video(style, *size, form))
    if as_json:
        click.echo(json.dumps({"style": style.name} | explained, indent=2))
    else:
        click.echo("\n".join([style.name, *lines_of(explained)]))


def _details(style: Style, described: dict[str, Any]) -> Iterator[str]:
    from vidstyle.diagram.graph import graph_of
    from vidstyle.diagram.text import graph_text
    from vidstyle.style import LAYERS, table_from_style
    from vidstyle.style.knobs import knobs_of

    layers = {layer: described[layer] for layer in LAYERS}
    yield f"{described['name']}: {described['note']}" if described["note"] else described["name"]
    yield ""
    yield from graph_text(graph_of(style), get_terminal_size((100, 0)).columns, sys.stdout.encoding)
    yield ""
    for key, value in described.items():
        if key not in layers and key not in ("name", "note", "knobs", "labels", "variants"):
            yield f"  {key} = {json.dumps(value)}"
    for path, knob in knobs_of(style, table_from_style(style)).items():
        yield f"  knob {path}: {knob.label}"
    for name, values in described["variants"].items():
        changes = ", ".join(f"{path} = {json.dumps(value)}" for path, value in values.items())
        yield f"  variant {name}: {changes}"
    for layer, steps in layers.items():
        for step in steps:
            yield from _step_details(layer, step)


def _step_details(layer: str, step: dict[str, Any]) -> Iterator[str]:
    names = "".join(f", {word} {step[word]}" for word in ("from", "save") if step[word])
    yield f"  {layer}: {step['block'] or 'no block'}{names}"
    for name, parameter in step["parameters"].items():
        value = json.dumps(parameter["value"])
        yield f"    {name} = {value:10} {parameter['label']}: {parameter['help']} ({parameter['range']})"
