"""Masks of styles: where they are, that steps read them, and that films keep them steady."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from covering import in_one_test
from face_network import gray_and_red, red_people
from films import page, picture
from media import photograph
from pictures import FLOAT, SOURCES, VIDEO, codes, noise, picture_with_face, same_bits

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.design.restyling import StepPictures
from vidstyle.errors import StyleError
from vidstyle.export.export_style import export_style
from vidstyle.gpu.compile.es import es_plan
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.pipeline.resume import setting_parts
from vidstyle.regions.chosen_files import MODEL_VARIABLE
from vidstyle.regions.frame_masks import FrameMasks
from vidstyle.regions.mask_edges import refine
from vidstyle.regions.steady_mask import SteadyMask
from vidstyle.renderer import open_renderer, stylize
from vidstyle.style import Style, load_style, style_from_table, table_from_style
from vidstyle.style.behind import style_behind
from vidstyle.style.resolve import masks_read

BLACK = [{"block": "to_gray"}, {"block": "brightness", "factor": 0}]
GREEN = {"screen": {"color": "#00b140"}}


def table(**more: object) -> dict[str, object]:
    return {"format": 1, "background": BLACK, **more}


def green_screen(height: int = 120, width: int = 160) -> np.ndarray:
    """A photograph with a green right half."""
    color = np.array(cv2.resize(photograph(), (width, height), interpolation=cv2.INTER_AREA))
    color[:, width // 2 :] = 0, 177, 64
    return color


def masks_of(style: dict[str, object] | Style, color: np.ndarray) -> dict[str, np.ndarray]:
    masks = FrameMasks(load_style(style))
    try:
        return masks.of(Picture.from_array(color), None)
    finally:
        masks.close()


def test_a_color_is_a_mask() -> None:
    found = masks_of(table(masks=GREEN, only="screen"), green_screen())["screen"]
    assert found.dtype == np.uint8 and found.shape == (120, 160)
    assert not found[:, :80].any() and (found[:, 80:] == 255).all()


def test_softness_is_the_width_of_the_edge() -> None:
    ramp = np.zeros((4, 256, 3), np.uint8)
    ramp[..., 2] = np.arange(256)
    widths = []
    for softness in (0.0, 0.1, 0.4):
        masks = {"blue": {"color": "#0000ff", "tolerance": 0.1, "softness": softness}}
        found = masks_of(table(masks=masks, only="blue"), ramp)["blue"][0]
        assert (np.diff(found.astype(int)) >= 0).all() and found[-1] == 255
        widths.append(np.count_nonzero((found > 0) & (found < 255)))
    assert widths[0] == 0 < widths[1] < widths[2]


@pytest.mark.parametrize("device", ["cpu", "gpu"])
def test_only_restyles_inside_and_keep_outside(device: str) -> None:
    color = green_screen()
    only = stylize(color, table(masks=GREEN, only="screen"), device)
    keep = stylize(color, table(masks=GREEN, keep="screen"), device)
    assert np.array_equal(only[:, :80], color[:, :80]) and not only[:, 80:].any()
    assert np.array_equal(keep[:, 80:], color[:, 80:]) and not keep[:, :80].any()


@pytest.mark.parametrize("device", ["cpu", "gpu"])
def test_steps_read_masks_like_saved_pictures(device: str) -> None:
    """As their input, as another picture, and as the mask of `blend`; inverted too."""
    masks = {"screen": GREEN["screen"] | {"invert": True}}
    color = green_screen()
    shown = {"format": 1, "masks": masks, "background": [{"from": "screen"}]}
    blended = {"block": "blend", "other": "source", "mask": "screen", "opacity": 1}
    assert (stylize(color, shown, device)[..., 0] == np.repeat([255, 0], 80)).all()
    result = stylize(color, table(masks=masks, background=[*BLACK, blended]), device)
    gray = stylize(color, {"format": 1, "background": [{"block": "to_gray"}]}, device)
    assert np.array_equal(result[:, :80], gray[:, :80]) and not result[:, 80:].any()


def test_a_mask_is_scaled_to_the_size_of_a_step() -> None:
    small = [{"block": "scale", "factor": 0.5}, *BLACK]
    blended = {"block": "blend", "other": "source", "mask": "screen", "opacity": 1}
    result = stylize(green_screen(), table(masks=GREEN, background=[*small, blended]), "cpu")
    assert (result[:, 84:] == 131).all() and result[:, :76].max() < 3, "luma of green, and black"


def test_people_stand_before_another_style(red_model: Path) -> None:
    color = np.full((144, 256, 3), 120, np.uint8)
    color[40:100, 60:140] = 250, 10, 10
    for name in ("plain", "ink"):
        style = replace(load_style(name), focus=0.0, behind=style_behind("#102030"))
        result = stylize(color, style, "cpu")
        assert (result[:, 180:] == (16, 32, 48)).all() and (result[:30] == (16, 32, 48)).all()
        person = stylize(color, replace(style, behind=None), "cpu")
        assert np.abs(result[50:90, 70:130].astype(int) - person[50:90, 70:130]).max() <= 1


def test_styles_behind_have_names_and_measurements_of_their_own(red_model: Path) -> None:
    """Both save pictures under the same names, and both measure percentiles."""
    color = gray_and_red()
    one, other = (replace(load_style(name), focus=0.0, steady=0.0) for name in ("comic", "poster"))
    result = stylize(color, replace(one, behind=replace(other)), "cpu").astype(int)
    assert np.abs(result[:, :96] - stylize(color, other, "cpu")[:, :96]).mean() < 0.5
    assert np.abs(result[:, 160:] - stylize(color, one, "cpu")[:, 160:]).mean() < 0.5


@pytest.mark.parametrize("device", ["cpu", "gpu"])
def test_people_do_not_glow_in_the_blur_behind_them(device: str, red_model: Path) -> None:
    color = gray_and_red()
    out = stylize(color, replace(load_style("plain"), behind=style_behind("blur")), device).astype(int)
    redness = out[..., 0] - out[..., 1:].mean(axis=2)
    assert redness[:, 140:].min() > 200
    assert redness[:, :127].max() < 20
    # It is blurred: neighbouring pixels differ less.
    assert (
        np.abs(np.diff(out[:, :110, 1])).mean() < 0.5 * np.abs(np.diff(color[:, :110, 1].astype(int))).mean()
    )


def test_background_is_everything_but_people(red_model: Path) -> None:
    color = gray_and_red()
    blended = {"block": "blend", "mask": "background"}
    masks = masks_of(table(background=[blended], only="people"), color)
    assert (masks["people"] + masks["background"] == 255).all()
    assert masks["people"][:, 150:].mean() > 230 and masks["people"][:, :100].mean() < 25


def test_faces_and_skin() -> None:
    color = picture_with_face()
    faces = masks_of(table(only="faces"), color)["faces"]
    assert faces[150 + 35, 250 + 80] > 200 and faces[:, :200].max() == 0
    skin = masks_of(table(only="skin"), color)["skin"]
    assert skin[150 + 40, 250 + 80] > 128 > skin[:100].mean()


def saved_mask(folder: Path, mask: np.ndarray, name: str = "mask.png") -> None:
    assert cv2.imwrite(str(folder / name), mask)


def test_a_picture_is_a_mask_of_any_size(tmp_path: Path) -> None:
    saved_mask(tmp_path, np.repeat(np.uint8([[0, 255]]), 3, axis=0))
    style = style_from_table(table(masks={"right": {"file": "mask.png"}}, only="right"), "t", folder=tmp_path)
    for height, width in ((120, 160), (31, 17), (1, 1)):
        masks = FrameMasks(style).of(Picture.from_array(np.zeros((height, width, 3), np.uint8)), None)
        assert masks["right"].shape == (height, width)
        assert masks["right"][0, -1] >= masks["right"][0, 0]


def test_hostile_mask_files_are_refused_in_one_line(tmp_path: Path) -> None:
    folder = tmp_path / "style"
    folder.mkdir()
    saved_mask(tmp_path, np.zeros((2, 2), np.uint8), "outside.png")
    saved_mask(folder, np.zeros((2, 2), np.uint8))
    (folder / "link.png").symlink_to(tmp_path / "outside.png")
    (folder / "text.png").write_text("no picture")
    content = (folder / "mask.png").read_bytes()
    (folder / "cut.png").write_bytes(content[:30])
    (folder / "huge.png").write_bytes(content[:16] + b"\x00\x10\x00\x00" * 2 + content[24:])
    for name, reason in {
        "lost.png": "is not in the style's folder",
        "../outside.png": "a path inside the style's folder",
        "link.png": "leads out of the style's folder",
        "text.png": "is not a PNG of at most 8192 x 8192 pixels",
        "huge.png": "is not a PNG of at most 8192 x 8192 pixels",
        "cut.png": "is damaged",
    }.items():
        with pytest.raises(StyleError, match=reason) as caught:
            FrameMasks(style_from_table(table(masks={"m": {"file": name}}, only="m"), "t", folder=folder))
        assert "\n" not in str(caught.value)


@in_one_test(
    "masks",
    [
        ({"m": {}}, "a mask has either color or file"),
        ({"m": {"color": "#000", "file": "a.png"}}, "a mask has either color or file"),
        ({"m": {"color": "gren"}}, "is not a colour"),
        ({"m": {"color": "#000", "size": 2}}, "is not a value of a mask"),
        ({"m": {"color": "#000", "tolerance": 2}}, "outside 0 to 1"),
        ({"people": {"color": "#000"}}, "is a picture of every style"),
        ({"two words": {"color": "#000"}}, "is not a name"),
        ({"m": 3}, "is not a table"),
        (3, "is not a table"),
        ({f"m{number}": {"color": "#000"} for number in range(9)}, "at most 8 masks"),
    ],
)
def test_mistakes_in_masks_are_named(masks: tuple[object, str]) -> None:
    with pytest.raises(StyleError, match=masks[1]):
        load_style(table(masks=masks[0]))


@in_one_test(
    "fields",
    [
        ({"only": "peopel"}, "did you mean 'people'"),
        ({"keep": "screen"}, "is not a mask"),
        ({"masks": GREEN, "background": [{"block": "hue", "save": "screen"}]}, "is a mask"),
        ({"behind": 3}, "is not a table like a style"),
        ({"behind": {"background": [{"block": "lost"}]}}, "behind: background step 1"),
        ({"behind": {"steady": 0.5}}, "has no effect"),
        ({"behind": {"behind": {}}}, "has no effect"),
    ],
)
def test_mistakes_about_regions_are_named(fields: tuple[dict[str, object], str]) -> None:
    with pytest.raises(StyleError, match=fields[1]):
        load_style(table(**fields[0]))


def test_styles_with_regions_survive_their_table() -> None:
    style = load_style(table(masks=GREEN, keep="screen", only="people", behind={"background": BLACK}))
    assert load_style(table_from_style(style)) == style
    assert masks_read(style) == ["people", "screen"]


def test_old_styles_may_save_pictures_under_the_names_of_regions() -> None:
    steps = [{"block": "hue", "save": "people"}, {"block": "blend", "other": "people"}]
    assert masks_read(load_style(table(background=steps))) == []


@pytest.mark.parametrize("kind", SOURCES)
def test_every_kind_of_picture_has_masks(kind: str, red_model: Path) -> None:
    source = SOURCES[kind]
    style = load_style(table(masks=GREEN, only="screen", keep="people"))
    with open_renderer(style, "cpu") as renderer:
        result = renderer.run(source, 0.0)
        assert result.shape == source.shape and result.encoding == source.encoding
        assert same_bits(result, renderer.run(source, None)), "the first frame is like a picture alone"


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (37, 41)])
def test_any_size_is_like_with_all_threads(shape: tuple[int, int], red_model: Path) -> None:
    style = load_style(table(masks=GREEN, only="screen", behind={"background": [{"block": "gaussian"}]}))
    for source in (codes(VIDEO, *shape), Picture(FLOAT, color=noise(*shape, 3))):
        with open_renderer(style, "cpu") as renderer:
            one = renderer.run(source, 0.0)
            assert same_bits(one, renderer.begin(FrameRequest(source, 0.0)).result()) and one.shape == shape


def test_a_refined_mask_follows_the_edges_of_luma() -> None:
    """A coarse mask that is a few pixels off."""
    luma = np.zeros((360, 640), np.float32)
    luma[:, 323:] = 0.8
    coarse = np.zeros((45, 80), np.float32)
    coarse[:, 40:] = 1
    refined = refine(coarse, luma)
    assert refined.shape == luma.shape
    assert (refined[:, 318:323] < 100).all() and (refined[:, 323:328] > 155).all()
    assert not refined[:, :300].any() and (refined[:, 345:] == 255).all()


def bright_half(shown: Picture) -> np.ndarray:
    """Return a mask of pixels brighter than medium gray, h x w float32."""
    assert shown.luma is not None
    return (cv2.resize(shown.luma, (64, 36), interpolation=cv2.INTER_AREA) > 126).astype(np.float32)


def panned(count: int, pixels: int) -> Iterator[Picture]:
    wide = page(180, 320 + pixels * count)
    return (picture(wide[:, number * pixels : number * pixels + 320]) for number in range(count))


def test_a_mask_moves_with_the_picture_between_searches() -> None:
    calls: list[Picture] = []

    def find(shown: Picture, _: bool) -> np.ndarray:
        calls.append(shown)
        return bright_half(shown)

    mask, moved, still = SteadyMask(find), [], []
    for number, shown in enumerate(panned(9, 10)):
        found = mask.follow(shown, number / 25, number == 0)
        if number % 2:
            moved.append(np.abs(found - bright_half(shown)).mean())
            still.append(np.abs(before - bright_half(shown)).mean())  # noqa: F821
        before = found  # noqa: F841
    assert len(calls) == 5, "every second frame"
    assert np.mean(moved) < 0.6 * np.mean(still)


def test_a_mask_does_not_flicker_and_starts_again_at_a_cut() -> None:
    random = np.random.default_rng(1)
    shown = picture(page(180, 320))
    mask = SteadyMask(lambda *_: random.uniform(0.4, 0.6, (36, 64)).astype(np.float32))
    frames = [mask.follow(shown, number / 25, False) for number in range(41)]
    raw = 0.2 / 3  # the mean difference of two numbers of that range
    assert (
        np.mean([np.abs(one - two).mean() for one, two in zip(frames, frames[2:], strict=False)]) < 0.6 * raw
    )
    empty = SteadyMask(lambda shown, _: bright_half(shown))
    dark = Picture(VIDEO, luma=np.full((180, 320), 16, np.uint8))
    empty.follow(shown, 0.0, True)
    assert not empty.follow(dark, 0.04, True).any(), "no ghost after a cut"


def test_films_repeat_exactly(red_model: Path) -> None:
    """Masks are reset at each known cut."""
    style = replace(load_style("poster"), focus=0.0, steady=0.0, only="people")
    frames = list(panned(8, 6))

    def restyled(first: int) -> list[Picture]:
        with open_renderer(style, "cpu", cuts=KnownCuts([0.0, 4 / 25])) as renderer:
            pending = [
                renderer.begin(FrameRequest(each, (first + number) / 25))
                for number, each in enumerate(frames[first:])
            ]
            return [each.result() for each in pending]

    whole = restyled(0)
    assert all(same_bits(*pair) for pair in zip(whole, restyled(0), strict=True))
    assert all(same_bits(*pair) for pair in zip(whole[4:], restyled(4), strict=True))


def test_focus_and_masks_work_together() -> None:
    """A small face inside a kept region stays the source."""
    color = picture_with_face()
    style = replace(load_style("comic"), keep="faces")
    result = stylize(color, style, "cpu")
    place = slice(175, 195), slice(325, 340)
    assert np.abs(result[place].astype(int) - color[place]).max() <= 1
    assert np.abs(result[:100].astype(int) - color[:100]).mean() > 5


def test_the_designer_shows_masks(red_model: Path) -> None:
    """In thumbnails of steps, in previews that began without masks, and exactly."""
    style = load_style({"format": 1, "background": [{"from": "people"}, {"block": "hue"}], "keep": "people"})
    color = gray_and_red()
    steps = StepPictures()
    shown = steps.of(style, color)["background", 0]
    steps.close()
    assert shown[:, 160:].mean() > 230 and shown[:, :90].mean() < 25
    exact = stylize(color, replace(style, steady=0.0), "cpu")
    assert np.abs(exact[:, 160:].astype(int) - color[:, 160:]).mean() < 3
    with open_renderer("plain", "cpu") as renderer:
        renderer.run(Picture.from_array(color))
        renderer.change_style(style)
        result = renderer.run(Picture.from_array(color), None, rgb=True).color
    assert result is not None and np.array_equal(result, exact)


@pytest.mark.parametrize("kind", ["html", "hook"])
def test_exported_styles_have_fixed_masks(
    kind: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "vidstyle")
    style = replace(load_style("poster"), only="people", keep="faces")
    export_style(style, tmp_path / f"a.{kind}")
    assert "masks are not exported (people, faces): people fill the picture" in caplog.text
    assert "masks" in es_plan(style, 32, 18)["server"]
    assert "masks" not in es_plan(load_style("poster"), 32, 18)["server"]


def test_an_interrupted_run_continues_only_with_the_same_regions(
    red_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def digest(style: dict[str, object]) -> str:
        return setting_parts(load_style(style), ReadOptions(), WriteOptions())["style"]

    blur = {"background": [{"block": "gaussian"}]}
    styles = [table(), table(only="people"), table(keep="people"), table(behind=blur), table(behind={})]
    styles += [table(masks=GREEN), table(masks={"screen": {"color": "#00b141"}})]
    digests = [digest(each) for each in styles]
    assert len(set(digests)) == len(styles)
    other = tmp_path / "other.onnx"
    other.write_bytes(red_people())
    monkeypatch.setenv(MODEL_VARIABLE, str(other))
    changed = [one != digest(style) for one, style in zip(digests, styles, strict=True)]
    assert changed == [False, True, True, True, True, False, False], "styles that read people"
