"""Films and sequences that are continued after an interruption."""

from __future__ import annotations

import os
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from face_network import red_people
from faults import Program, packets, video
from media import make_clip, make_picture
from pictures import film_with_face
from stories import PLACES, RATE, shot, story

from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.write import atomic, film_writer, run_record
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.media.write.images import PictureWriter
from vidstyle.media.write.memory import write_film
from vidstyle.media.write.resume_source import count_frames
from vidstyle.media.write.writer import WriteOptions
from vidstyle.pipeline.progress import Progress, Summary
from vidstyle.pipeline.render import render
from vidstyle.pipeline.resume import warm_up_frames
from vidstyle.regions.chosen_files import MODEL_VARIABLE
from vidstyle.style import load_style, style_from_table

SHOT, SHOTS = 30, 4
"""Frames in a shot of the film, whose cuts are where an encoder begins groups of pictures."""


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A film of some shots, with sound."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    pictures = (convert(Picture.from_array(rgb), Encoding()) for rgb in story(SHOTS, SHOT))
    sound = np.sin(np.arange(48000 * SHOTS * SHOT // RATE) / 20).astype(np.float32)
    write_film(path, pictures, Fraction(RATE), sound)
    return path


Interrupt = Callable[..., None]


@pytest.fixture
def interrupt(monkeypatch: pytest.MonkeyPatch) -> Interrupt:
    """Render up to a frame, and fail there."""

    def run(at: int, source: Path, target: Path, style: object = "plain", **options: object) -> None:
        taken = iter(range(at))

        def failing(original):  # type: ignore[no-untyped-def]
            def write(self, item):  # type: ignore[no-untyped-def]
                if isinstance(item, Frame) and next(taken, None) is None:
                    raise RuntimeError("interrupted")
                original(self, item)

            return write

        with monkeypatch.context() as patch:
            # However slow the machine is, all that was encoded is stored.
            patch.setattr("vidstyle.media.write.film_writer.MAX_FLUSH_SECONDS", 1e6)
            patch.setattr("vidstyle.pipeline.stages.END_SECONDS", 1e6)
            for writer in (FilmWriter, PictureWriter):
                patch.setattr(writer, "write", failing(writer.write))
            with pytest.raises(RuntimeError, match="interrupted"):
                render(source, target, style, **options)  # type: ignore[arg-type]

    return run


def shown(path: Path) -> list[tuple[Fraction, np.ndarray]]:
    """Time and luma of every frame."""
    return [(frame.pts * frame.time_base, frame.to_ndarray()[: frame.height]) for frame in video(path)]


@pytest.mark.parametrize(
    ("ending", "options"),
    [
        (".mp4", WriteOptions()),
        (".mkv", WriteOptions()),
        (".mov", WriteOptions(codec="mpeg4")),
        pytest.param(".mov", WriteOptions(codec="prores_ks"), marks=pytest.mark.thorough),
        pytest.param(".mp4", WriteOptions(codec="libx265"), marks=pytest.mark.thorough),
    ],
)
def test_a_continued_film_is_that_of_one_run(film, tmp_path, interrupt: Interrupt, ending, options):
    whole, target = tmp_path / f"whole{ending}", tmp_path / f"out{ending}"
    render(film, whole, "plain", write=options)
    interrupt(75, film, target, write=options)
    interrupt(96, film, target, write=options, resume=True)
    summary = render(film, target, "plain", write=options, resume=True)
    assert summary.kept >= 84 and summary.frames == SHOTS * SHOT
    before, after = shown(whole), shown(target)
    assert [time for time, _ in after] == [time for time, _ in before]
    for (_, one), (_, other) in zip(before[:60], after, strict=False):
        assert np.array_equal(one, other)
    for (_, one), (_, other) in zip(before, after, strict=True):
        assert np.abs(one - other.astype(int)).mean() < 2
    assert packets(target, "audio") == packets(whole, "audio") != []
    assert sorted(os.listdir(tmp_path)) == sorted([whole.name, target.name])


def test_what_an_earlier_run_has_made_stays_until_there_is_more(
    film, tmp_path, interrupt: Interrupt, monkeypatch
):
    target, partial = tmp_path / "out.mkv", tmp_path / "out.partial.mkv"
    interrupt(40, film, target)
    content = partial.read_bytes()
    assert count_frames(partial) == 40
    interrupt(10, film, target, resume=True)
    interrupt(36, film, target, resume=True)
    assert partial.read_bytes() == content
    assert sorted(os.listdir(tmp_path)) == ["out.mkv.partial.jsonl", "out.partial.mkv"]
    monkeypatch.setattr(atomic, "POLL_SECONDS", 0)
    held = []

    def watch(*_: object) -> bool:
        held.append(count_frames(partial))
        return True

    monkeypatch.setattr(atomic.PartialFile, "check", watch)
    interrupt(46, film, target, resume=True)
    assert min(held) == 40 < count_frames(partial) == 46


REMEMBERS = {
    "format": 1,
    "steady": 0.5,
    "background": [{"block": "equalize", "settle": 0.1}, {"block": "posterize"}],
}


@pytest.mark.parametrize(
    ("style", "size", "frames"),
    [(REMEMBERS, 32, 160), pytest.param("comic", 72, 230, marks=pytest.mark.thorough)],
)
def test_a_style_that_remembers_settles_before_the_border(
    tmp_path, interrupt: Interrupt, style, size, frames
):
    """State is warmed up in mid-scene, and reset by the next cut."""
    source, lossless = tmp_path / "source.mp4", WriteOptions(codec="ffv1", audio="none")
    shape = size * 16 // 9 // 2 * 2, size
    rgbs = [*shot(PLACES[0], frames), *shot(PLACES[1], 12)]
    pictures = (convert(Picture.from_array(cv2.resize(rgb, shape)), Encoding()) for rgb in rgbs)
    write_film(source, pictures, Fraction(RATE), np.zeros(48000 * len(rgbs) // RATE, np.float32))
    render(source, tmp_path / "whole.mkv", style, write=lossless)
    interrupt(frames - 5, source, tmp_path / "out.mkv", style, write=lossless)
    summary = render(source, tmp_path / "out.mkv", style, write=lossless, resume=True)
    assert warm_up_frames(load_style(style), RATE) + 20 < summary.kept < frames
    whole, continued = shown(tmp_path / "whole.mkv"), shown(tmp_path / "out.mkv")
    worst = [
        np.abs(one.astype(int) - other).max() for (_, one), (_, other) in zip(whole, continued, strict=True)
    ]
    assert max(worst[:frames]) <= 1 and max(worst[frames:]) == 0


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"style": "ink"}, "another style; "),
        ({"write": WriteOptions(crf=30), "frames": 100}, "another crf, frames, encoder headers; "),
        ({"write": WriteOptions(codec="mpeg4")}, "another codec, encoder headers; "),
    ],
)
def test_another_job_is_refused_and_the_difference_named(
    film, tmp_path, interrupt: Interrupt, changed, named
):
    interrupt(50, film, tmp_path / "out.mp4")
    left = tmp_path / "out.partial.mp4"
    content = left.read_bytes()
    with pytest.raises(UsageError, match=f"out.partial.mp4 was started with {named}"):
        render(film, tmp_path / "out.mp4", **{"style": "plain", "resume": True} | changed)
    assert left.read_bytes() == content
    assert sorted(os.listdir(tmp_path)) == ["out.mp4.partial.jsonl", left.name]


def test_another_source_or_a_lost_record_is_refused(film, tmp_path, interrupt: Interrupt):
    source = make_clip(tmp_path / "source.mp4", frames=40, options={"g": "5"})
    interrupt(30, source, tmp_path / "out.mp4")
    os.utime(source, ns=(0, 0))
    with pytest.raises(UsageError, match="another source; use the same"):
        render(source, tmp_path / "out.mp4", "plain", resume=True)
    (tmp_path / "out.mp4.partial.jsonl").unlink()
    with pytest.raises(UsageError, match="out.partial.mp4 exists and is not an unfinished output"):
        render(source, tmp_path / "out.mp4", "plain", resume=True)
    assert count_frames(tmp_path / "out.partial.mp4") == 30


def foreign_film(film: Path, left: Path, whole: Path) -> None:
    """Another film of the same size, codec and options."""
    render(film, whole.with_name(f"foreign{left.suffix}"), "ink")
    whole.with_name(f"foreign{left.suffix}").replace(left)


def cut_off(film: Path, left: Path, whole: Path) -> None:
    """The file ends amid its last pictures."""
    os.truncate(left, left.stat().st_size - 20000)


def later_byte(film: Path, left: Path, whole: Path) -> None:
    """A byte of a picture after the first group is another."""
    content = bytearray(left.read_bytes())
    content[len(content) * 2 // 3] ^= 1
    left.write_bytes(content)


def other_byte(film: Path, left: Path, whole: Path) -> None:
    """A byte amid the first pictures is another."""
    content = bytearray(left.read_bytes())
    content[3000] ^= 1
    left.write_bytes(content)


@pytest.mark.parametrize("ending", [".mp4", ".mkv", ".mov"])
@pytest.mark.parametrize("change", [foreign_film, other_byte])
@pytest.mark.parametrize("options", [{"resume": True}, {"write": WriteOptions(overwrite=True)}])
def test_a_film_that_the_run_has_not_left_is_refused(
    film, tmp_path, interrupt: Interrupt, ending, change, options
):
    target, left = tmp_path / f"out{ending}", tmp_path / f"out.partial{ending}"
    interrupt(100, film, target)
    change(film, left, target)
    content = left.read_bytes()
    with pytest.raises(
        UsageError, match=r"out.partial.* exists and is not an unfinished output of this name"
    ):
        render(film, target, "plain", **options)
    assert left.read_bytes() == content and not target.exists()


@pytest.mark.parametrize("ending", [".mp4", ".mov"])
def test_a_whole_film_that_has_not_got_its_name_is_continued(film, tmp_path, monkeypatch, ending):
    """Its index is first already, so that it no longer has the bytes that were written to it."""

    def kill(file: atomic.PartialFile) -> None:
        file.release()
        raise KeyboardInterrupt

    target = tmp_path / f"out{ending}"
    with monkeypatch.context() as patch:
        patch.setattr(atomic.PartialFile, "finish", kill)
        patch.setattr(FilmWriter, "abandon", lambda writer: writer.partial)
        with pytest.raises(KeyboardInterrupt):
            render(film, target, "plain")
    assert count_frames(tmp_path / f"out.partial{ending}") == SHOTS * SHOT
    summary = render(film, target, "plain", resume=True)
    assert summary.kept == SHOT * (SHOTS - 1) and len(video(target)) == SHOTS * SHOT
    assert os.listdir(tmp_path) == [target.name]


def test_a_film_without_its_index_is_refused_unless_told_so(film, tmp_path, interrupt: Interrupt):
    target, left = tmp_path / "out.mp4", tmp_path / "out.partial.mp4"
    interrupt(100, film, target)
    cut_off(film, left, target)
    content = left.read_bytes()
    with pytest.raises(UsageError, match=r"out.partial.mp4 cannot be resumed: .*; -y starts again"):
        render(film, target, "plain", resume=True)
    assert left.read_bytes() == content
    render(film, target, "plain", frames=5, write=WriteOptions(overwrite=True))
    assert os.listdir(tmp_path) == [target.name]


@pytest.mark.parametrize("change", [cut_off, later_byte])
def test_a_damaged_film_is_continued_before_the_damage(
    film, tmp_path, interrupt: Interrupt, monkeypatch, change
):
    monkeypatch.setattr(run_record, "CHECKPOINT_SECONDS", 0)
    whole, target, left = (tmp_path / f"{name}.mkv" for name in ("whole", "out", "out.partial"))
    render(film, whole, "plain")
    interrupt(100, film, target)
    change(film, left, target)
    summary = render(film, target, "plain", resume=True)
    assert 0 < summary.kept < 90 and summary.frames == SHOTS * SHOT
    before, after = shown(whole), shown(target)
    assert [time for time, _ in after] == [time for time, _ in before]
    for (_, one), (_, other) in zip(before[: summary.kept], after, strict=False):
        assert np.array_equal(one, other)
    for (_, one), (_, other) in zip(before, after, strict=True):
        assert np.abs(one - other.astype(int)).mean() < 2
    assert sorted(os.listdir(tmp_path)) == sorted([whole.name, target.name])


def test_another_header_is_refused(film, tmp_path, interrupt: Interrupt, monkeypatch):
    interrupt(50, film, tmp_path / "out.mkv")
    monkeypatch.setattr(film_writer, "video_format", lambda _: ("h264", 640, 360))
    with pytest.raises(UsageError, match="out.partial.mkv exists and is not an unfinished output"):
        render(film, tmp_path / "out.mkv", "plain", resume=True)


def test_pictures_of_others_are_not_counted(film, tmp_path, interrupt: Interrupt):
    target = tmp_path / "%03d.png"
    interrupt(12, film, target, frames=20)
    (tmp_path / "007.png").write_bytes(b"mine")
    (tmp_path / "013.png").write_bytes(b"mine")
    with pytest.raises(UsageError, match="007.png already exists"):
        render(film, target, "plain", frames=20, resume=True)
    assert (tmp_path / "007.png").read_bytes() == (tmp_path / "013.png").read_bytes() == b"mine"


def test_numbered_pictures_are_continued(film, tmp_path, interrupt: Interrupt):
    for folder in ("whole", "out"):
        (tmp_path / folder).mkdir()
    render(film, tmp_path / "whole" / "%03d.png", "plain", frames=20)
    target = tmp_path / "out" / "%03d.png"
    for number in range(1, 20):  # of another run, and older
        (tmp_path / "out" / f"{number:03}.png").write_bytes(b"old")
    again = WriteOptions(overwrite=True)
    interrupt(12, film, target, frames=20, write=again)
    with pytest.raises(UsageError, match="holds the first 12 pictures of an earlier run; --resume continues"):
        render(film, target, "plain", frames=20)
    (tmp_path / "out" / "012.png").write_bytes(b"cut")
    interrupt(15, film, target, frames=20, resume=True, write=again)
    summary = render(film, target, "plain", frames=20, resume=True, write=again)
    assert (summary.frames, summary.kept) == (20, 14)
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == {
        path.name: path.read_bytes() for path in (tmp_path / "whole").iterdir()
    }


def test_33_what_was_saved_is_kept_and_continued(program: Program, film, interrupt: Interrupt):
    partial = program.folder / "out.partial.mp4"
    interrupt(50, film, program.folder / "out.mp4")
    content = partial.read_bytes()
    outcome = program(film)
    assert outcome.exit_code == 2 and len(outcome.lines) == 1
    assert "holds the first 2.0 s of an earlier run; --resume continues it, -y starts again" in outcome.said
    assert partial.read_bytes() == content
    outcome = program(film, "out.mp4", "--resume")
    assert outcome.exit_code == 0 and "30 of 50 frames are kept" in outcome.said
    assert len(video(outcome.target)) == SHOTS * SHOT
    outcome = program(film, "out.mp4", "--resume")
    assert outcome.exit_code == 0 and "is already finished" in outcome.said and len(outcome.lines) == 1


def test_33_told_so_a_run_begins_anew(program: Program, film, interrupt: Interrupt):
    interrupt(50, film, program.folder / "out.mp4")
    outcome = program(film, "out.mp4", "-y", "--frames", "5")
    assert outcome.exit_code == 0 and outcome.left == ["out.mp4"]
    assert len(video(outcome.target)) == 5


def test_what_cannot_be_continued_is_said_in_a_line(program: Program, film):
    picture = make_picture(program.folder / "one.png")
    for source, target in (
        (film, "out.gif"),
        (film, "out.y4m"),
        (picture, "out.png"),
        (film, "-"),
        ("-", "out.mp4"),
    ):
        program.refused(2, "--resume", source, target, "--resume")


def test_a_run_with_nothing_to_continue_begins_at_the_start(film, tmp_path):
    summary = render(film, tmp_path / "out.mp4", "plain", frames=5, resume=True)
    assert (summary.frames, summary.kept) == (5, 0) and os.listdir(tmp_path) == ["out.mp4"]


def test_pace_and_time_left_are_those_of_the_new_frames():
    progress = Progress(60, 2.4, 5.0, duration=3.2, since=Progress(40, 1.6, 1.0))
    assert (progress.rate, progress.fraction, progress.remaining) == (
        5.0,
        pytest.approx(0.75),
        pytest.approx(4.0),
    )
    assert Progress(30, 1.2, 0.5, duration=3.2, since=Progress(30, 1.2, 0.5)).remaining is None
    assert Summary("a", "b", 60, 2.4, 5.0, kept=40).as_dict()["fps"] == 4.0


def test_faces_of_a_continued_film_have_the_same_windows(tmp_path, interrupt: Interrupt):
    """A face moves through its windows from the first frame on, long before the film is continued."""
    style = style_from_table({"format": 1, "height": 720, "background": [{"block": "dither"}]}, "dots")
    frames, lossless = warm_up_frames(style, RATE) + 60, WriteOptions(codec="ffv1", audio="none")
    places = film_with_face(lambda number: 40 + 2 * number, frames)
    pictures = (
        convert(Picture.from_array(cv2.resize(picture.color, (320, 240))), Encoding())
        for picture, _ in places
    )
    write_film(
        tmp_path / "source.mkv", pictures, Fraction(RATE), np.zeros(48000 * frames // RATE, np.float32)
    )
    render(tmp_path / "source.mkv", tmp_path / "whole.mkv", style, write=lossless)
    interrupt(frames - 5, tmp_path / "source.mkv", tmp_path / "out.mkv", style, write=lossless)
    summary = render(tmp_path / "source.mkv", tmp_path / "out.mkv", style, write=lossless, resume=True)
    assert warm_up_frames(style, RATE) + 20 < summary.kept < frames
    whole, continued = shown(tmp_path / "whole.mkv"), shown(tmp_path / "out.mkv")
    worst = [np.mean(one != other) for (_, one), (_, other) in zip(whole, continued, strict=True)]
    assert max(worst) < 1e-4


def test_masks_of_a_continued_film_are_those_of_one_run(tmp_path, interrupt: Interrupt, monkeypatch):
    """The network is asked for every second frame, from the beginning of the film on."""
    model = tmp_path / "red.onnx"
    model.write_bytes(red_people())
    monkeypatch.setenv(MODEL_VARIABLE, str(model))
    style = load_style({"format": 1, "only": "people", "background": [{"block": "brightness"}]})
    source = make_clip(tmp_path / "source.mkv", frames=150, codec="ffv1", pix_fmt="yuv420p")
    lossless = WriteOptions(codec="ffv1", audio="none")
    render(source, tmp_path / "whole.mkv", style, write=lossless)
    interrupt(131, source, tmp_path / "out.mkv", style, write=lossless)
    assert render(source, tmp_path / "out.mkv", style, write=lossless, resume=True).kept > 100
    whole, continued = shown(tmp_path / "whole.mkv"), shown(tmp_path / "out.mkv")
    assert all(np.array_equal(one, other) for (_, one), (_, other) in zip(whole, continued, strict=True))
