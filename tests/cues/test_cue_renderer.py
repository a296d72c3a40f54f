"""Films in several styles: each part as in its own style, mixed during transitions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import moderngl
import numpy as np
import pytest
from films import RATE, VIDEO, panned_film
from gpu import disagreements, named_planes
from pictures import film_with_face, same_bits, step, style

from vidstyle.backend import Backend, FrameRequest
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.cues.cue_list import Cue, CueList, Moment
from vidstyle.cues.cue_renderer import CueRenderer
from vidstyle.cues.transitions import mixed_picture
from vidstyle.renderer import open_renderer
from vidstyle.style import Style, set_values

STEADY = style(step("posterize", levels=4), steady=0.6, focus=0)
MEASURED = style(step("equalize", settle=0.5), focus=0)
PLAIN = Style("plain")
DEEP = Encoding("bt2020", depth=10, subsampling=(2, 1))
FRAMES = 12


def cues(*parts: tuple[int, Style], **last: object) -> CueList:
    """Cues at the times of frames; `last`: fields of the last one."""
    made = [Cue(Fraction(frame, RATE), chosen) for frame, chosen in parts]
    final = Cue(made[-1].time, made[-1].style, **last)  # type: ignore[arg-type]
    return CueList((*made[:-1], final))


def film(encoding: Encoding = VIDEO) -> list[FrameRequest]:
    pictures = panned_film(FRAMES, encoding=encoding)
    return [FrameRequest(picture, number / RATE) for number, picture in enumerate(pictures)]


def restyled(renderer: Backend, frames: Sequence[FrameRequest]) -> list[Picture]:
    """Several frames at a time, as in a film."""
    with renderer:
        pending, done = [], []
        for frame in frames:
            pending.append(renderer.begin(frame))
            while len(pending) > renderer.frames_in_flight:
                done.append(pending.pop(0).result())
        return [*done, *(each.result() for each in pending)]


def open_cpu(threads: int):  # type: ignore[no-untyped-def]
    return lambda chosen, cuts: CpuRenderer(chosen, threads, cuts)


def alone(chosen: Style, frames: Sequence[FrameRequest]) -> list[Picture]:
    """As in a film of these frames alone: the first begins a scene, and no other does."""
    return restyled(CpuRenderer(chosen, 2, KnownCuts([frames[0].time or 0])), frames)


@pytest.mark.parametrize("threads", [1, 4])
@pytest.mark.parametrize("order", [(STEADY, MEASURED), (MEASURED, PLAIN), (PLAIN, STEADY)])
def test_each_part_is_as_in_its_own_style(order: tuple[Style, Style], threads: int) -> None:
    frames = film()
    made = restyled(CueRenderer(cues((0, order[0]), (7, order[1])), open_cpu(threads)), frames)
    right = alone(order[0], frames[:7]) + alone(order[1], frames[7:])
    assert all(same_bits(one, other) for one, other in zip(made, right, strict=True))


@pytest.mark.parametrize("encoding", [VIDEO, DEEP], ids=["8 bits", "10 bits"])
@pytest.mark.parametrize("transition", ["fade", "wipe"])
def test_a_transition_mixes_both_styles(transition: str, encoding: Encoding) -> None:
    frames, seconds = film(encoding), Fraction(4, RATE)
    chosen = cues((0, STEADY), (5, MEASURED), transition=transition, seconds=seconds)
    made = restyled(CueRenderer(chosen, open_cpu(2)), frames)
    before, after = alone(STEADY, frames[:9]), alone(MEASURED, frames[5:])
    for number in range(5, 9):
        right = mixed_picture(before[number], after[number - 5], chosen.at(number / RATE))
        assert same_bits(made[number], right), number
    assert all(same_bits(one, other) for one, other in zip(made[9:], after[4:], strict=True))


def test_a_style_that_comes_back_remembers_nothing() -> None:
    frames = film()
    chosen = cues((0, STEADY), (3, MEASURED), (6, STEADY))
    made = restyled(CueRenderer(chosen, open_cpu(2)), frames)
    right = alone(STEADY, frames[6:])
    assert all(same_bits(one, other) for one, other in zip(made[6:], right, strict=True))


def test_a_renderer_that_is_used_again_remembers_nothing() -> None:
    """The third style has the renderer of the first, which has the same steps."""
    frames, fade = film(), Fraction(1, RATE)
    parts = [(0, STEADY), (3, set_values(STEADY, {"posterize.levels": 6})), (6, STEADY)]
    made = CueList(tuple(Cue(Fraction(at, RATE), each, "fade", fade) for at, each in parts))
    right = alone(STEADY, frames[6:])
    found = restyled(CueRenderer(made, open_cpu(2)), frames)[7:]
    assert all(same_bits(one, other) for one, other in zip(found, right[1:], strict=True))


@pytest.mark.parametrize("threads", [1, 4])
def test_moving_values_keep_the_memory_of_a_style(threads: int) -> None:
    frames = film()
    ends = [set_values(STEADY, {"posterize.levels": levels, "steady": 0.4}) for levels in (3, 9)]
    first, last = (
        Cue(Fraction(at, RATE), end, curve="linear") for at, end in zip((0, 11), ends, strict=True)
    )
    chosen = CueList((first, last))
    made = restyled(CueRenderer(chosen, open_cpu(threads)), frames)
    with CpuRenderer(ends[0], 1, KnownCuts([0.0])) as renderer:
        for frame, picture in zip(frames, made, strict=True):
            renderer.change_style(chosen.at(frame.time or 0).active.style)
            assert same_bits(renderer.restyle(frame), picture)


def test_a_fade_lies_between_its_ends_and_a_wipe_has_an_edge() -> None:
    dark, light = (Picture(VIDEO, luma=np.full((4, 10), tone, np.uint8)) for tone in (40, 200))
    assert mixed_picture(dark, light, Moment(None, None, "fade", 0.25)).luma.max() == 80  # type: ignore[arg-type,union-attr]
    wiped = mixed_picture(dark, light, Moment(None, None, "wipe", 0.3)).luma  # type: ignore[arg-type]
    assert wiped is not None and wiped[0].tolist() == [200] * 3 + [40] * 7


def test_the_gpu_agrees_in_a_transition() -> None:
    chosen = cues(
        (0, style(step("gaussian", sigma=2))), (2, MEASURED), transition="fade", seconds=Fraction(3, RATE)
    )
    frames = film()[:6]
    right, made = (restyled(open_renderer(chosen, device), frames) for device in ("cpu", "gpu"))
    assert [disagreements(one, other) for one, other in zip(right, made, strict=True)] == [[]] * 6


def test_nothing_is_compiled_after_the_first_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """A change of style delays no picture: also the second renderer of a transition has its programs."""
    counts: list[str] = []
    for name in ("compute_shader", "program"):
        original = getattr(moderngl.Context, name)

        def compiled(*given: object, _original: object = original, **named: object) -> object:
            counts.append("")
            return _original(*given, **named)  # type: ignore[operator]

        monkeypatch.setattr(moderngl.Context, name, compiled)
    fade = {"transition": "fade", "seconds": Fraction(2, RATE)}
    blurred = style(step("gaussian", sigma=2), focus=0)
    chosen = cues((1, MEASURED), (3, STEADY), (5, blurred), **fade)
    frames = film()
    with open_renderer(chosen, "gpu") as renderer:
        renderer.restyle(frames[0])
        before = len(counts)
        for frame in frames[1:]:
            renderer.restyle(frame)
    assert before > 0 and len(counts) == before


@pytest.mark.parametrize("shape", [(1, 1), (3, 7)])
def test_small_and_gray_pictures_have_transitions(shape: tuple[int, int]) -> None:
    chosen = cues((0, PLAIN), (1, STEADY), transition="wipe", seconds=Fraction(2, RATE))
    picture = Picture(VIDEO, luma=np.full(shape, 90, np.uint8))
    results = restyled(open_renderer(chosen, "cpu"), [FrameRequest(picture, n / RATE) for n in range(4)])
    for result in results[1:]:
        sizes = {name: plane.shape for name, plane in named_planes(result).items()}
        assert sizes["luma"] == shape and len(sizes) == 3


def test_faces_are_followed_through_skipped_frames() -> None:
    """A film that is continued in the second cue has the windows of the whole film."""
    frames = [FrameRequest(*each) for each in film_with_face(lambda number: 100 + 4 * number, 30)]
    dots = style(step("dither"), height=720.0)
    results = []
    for skipped, begun in ((0, 0), (26, 26), (0, 26)):
        renderer = open_renderer(cues((0, style(step("posterize"), height=720.0)), (6, dots)), "cpu")
        for frame in frames[:skipped]:
            renderer.skip(frame)
        results.append([named_planes(each) for each in restyled(renderer, frames[begun:])][-4:])
    whole, continued, fresh = ([planes["luma"] for planes in each] for each in results)
    assert all(map(np.array_equal, whole, continued)) and not all(map(np.array_equal, whole, fresh))
