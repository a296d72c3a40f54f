"""Key frame selection: sharp, dissimilar, as requested, and in order."""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from faults import remux
from media import make_picture
from stories import PLACES, RATE, dissolve, shot, story, view, write_film

from vidstyle.comic.analyze import film as film_file
from vidstyle.comic.analyze.features import (
    Candidate,
    extract_features,
)
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.picture_folder import PictureFolder
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, similarity
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.select.choose import choose
from vidstyle.comic.select.key_frames import KeyFrameOptions, find_key_frames
from vidstyle.errors import InputError, UsageError
from vidstyle.regions.boxes import Box
from vidstyle.regions.faces import FaceFinder


@pytest.fixture(scope="module")
def six_shots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six shots of 1.2 seconds."""
    return write_film(tmp_path_factory.mktemp("story") / "six_shots.mp4", story(6, 30))


@pytest.fixture(scope="module")
def six_key_frames(six_shots: Path) -> list[KeyFrame]:
    return key_frames_of(six_shots, panels=6)


def key_frames_of(path: Path, **options: object) -> list[KeyFrame]:
    return find_key_frames(open_film(path), KeyFrameOptions(**options))  # type: ignore[arg-type]


def seen_at(path: Path, key_frames: Sequence[KeyFrame]) -> list[Candidate]:
    """Measure the pictures of the key frames again on the full-size frames."""
    frames = open_film(path).frames_at([each.time for each in key_frames])
    return [
        extract_features(frame, each.time, each.shape) for each, frame in zip(key_frames, frames, strict=True)
    ]


def count_doubles(candidates: Sequence[Candidate]) -> int:
    return int(np.triu(similarity([each.thumbnail for each in candidates]) > SAME_SIMILARITY, 1).sum())


def test_key_frames_show_each_shot_in_order(six_shots: Path, six_key_frames: list[KeyFrame]) -> None:
    key_frames = six_key_frames
    assert [each.scene for each in key_frames] == [0, 1, 2, 3, 4, 5]
    assert [int(each.time / 1.2) for each in key_frames] == [0, 1, 2, 3, 4, 5]
    assert all(each.shape == (144, 256) for each in key_frames)
    assert max(each.importance for each in key_frames) == 1
    assert min(each.importance for each in key_frames) > 0
    assert count_doubles(seen_at(six_shots, key_frames)) == 0


def test_the_same_film_gives_the_same_key_frames(
    six_shots: Path, six_key_frames: list[KeyFrame], tmp_path: Path
) -> None:
    """Uses a copy of the film, which is not cached."""
    assert key_frames_of(Path(shutil.copy(six_shots, tmp_path)), panels=6) == six_key_frames


@pytest.mark.parametrize("panels", [1, 8])
def test_the_requested_number_of_panels_is_chosen(six_shots: Path, panels: int) -> None:
    key_frames = key_frames_of(six_shots, panels=panels)
    assert len(key_frames) == panels
    assert all(one.time < other.time for one, other in itertools.pairwise(key_frames))


def test_options_are_followed(six_shots: Path) -> None:
    key_frames = key_frames_of(six_shots, panels=4, at=(0.5, 3.02), skip=((1.0, 2.4), (4.8, 7.2)))
    times = [each.time for each in key_frames]
    assert pytest.approx(0.48) in times  # the frame shown at 0.5
    assert pytest.approx(3.0) in times
    assert len(times) == 4
    assert not any(1.0 <= time < 2.4 or 4.8 <= time for time in times)


def test_a_seed_varies_the_frames_reproducibly(six_shots: Path) -> None:
    """The number of panels differs by at most two: one by the seed, one pruned."""
    with open_film(six_shots) as film:
        found = [find_key_frames(film, KeyFrameOptions(seed=seed)) for seed in (0, *range(9))]
        fixed = [find_key_frames(film, KeyFrameOptions(panels=4, seed=seed)) for seed in range(4)]
    times = [tuple(each.time for each in key_frames) for key_frames in found]
    assert times[0] == times[1] and len(set(times)) >= 6
    assert {len(each) - len(times[0]) for each in times} <= {-2, -1, 0, 1, 2}
    assert [len(key_frames) for key_frames in fixed] == [4] * 4


def test_all_requested_times_are_shown_even_if_they_exceed_the_panels(six_shots: Path) -> None:
    assert [each.time for each in key_frames_of(six_shots, panels=1, at=(6, 0.2, 0.4))] == pytest.approx(
        [0.2, 0.4, 6]
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"at": (9,)}, "--at: 9 s is after the end; the film has 7.2 s"),
        ({"at": (1,), "skip": ((0, 2),)}, "--at: 1 s is in a part that --skip excludes"),
        ({"at": (-1,)}, "--at: -1 s is before the start of the film"),
        ({"skip": ((2, 1),)}, "--skip: 2-1 s is not a valid range"),
        ({"skip": ((0, 100),)}, "--skip leaves no frame of the film"),
        ({"panels": 0}, "--panels: 0 is outside 1 to 300"),
    ],
)
def test_contradictory_options_are_refused(six_shots: Path, options: dict[str, object], message: str) -> None:
    with pytest.raises(UsageError) as error:
        key_frames_of(six_shots, **options)
    assert str(error.value) == message


def test_blurred_black_and_blended_pictures_are_not_chosen(tmp_path: Path) -> None:
    """A third of each shot is blurred; between the shots there are black frames and a dissolve."""

    def partly_blurred(number: int) -> list[np.ndarray]:
        frames = shot(PLACES[number], 60)
        blurred = [cv2.GaussianBlur(frame, (0, 0), 3) for frame in frames[:20]]
        return [*blurred, *frames[20:]] if number % 2 else [*frames[20:], *blurred]

    black = [np.zeros_like(view(PLACES[0]))] * 20
    frames = [*partly_blurred(0), *black, *dissolve(partly_blurred(1), partly_blurred(2), 16)]
    path = write_film(tmp_path / "film.mp4", frames)
    key_frames = key_frames_of(path, panels=3)
    times = [each.time * RATE for each in key_frames]
    assert [time < 40 or 100 <= time < 124 or 140 <= time < 164 for time in times] == [True] * 3, times


def test_a_transition_is_never_chosen(six_shots: Path) -> None:
    survey = open_film(six_shots).survey()
    some = [replace(each, in_transition=number % 3 > 0) for number, each in enumerate(survey.candidates)]
    assert not any(each.in_transition for each in choose(replace(survey, candidates=some), [], 4))
    mixed = [replace(each, in_transition=True) for each in survey.candidates]
    assert choose(replace(survey, candidates=mixed), [], 4) == []


def test_frames_around_a_candidate_know_the_dissolves_of_the_film(tmp_path: Path) -> None:
    """Near its end, too little of a dissolve is decoded to find it again."""
    frames = dissolve(shot(PLACES[0], 3 * RATE), shot(PLACES[1], 4 * RATE), RATE)
    with open_film(write_film(tmp_path / "film.mp4", frames)) as film:
        after = [each for each in film.survey().candidates if each.time > 2.5 and not each.in_transition]
        near = film.around(after[0])
    mixed = {each.time for each in near if each.in_transition}
    assert mixed and max(mixed) < after[0].time


def test_the_sharpest_nearby_frame_is_chosen(tmp_path: Path) -> None:
    frames = shot(PLACES[0], 10, 0.2)
    film = [cv2.GaussianBlur(frame, (0, 0), 2.5) for frame in frames]
    film[6] = frames[6]
    path = write_film(tmp_path / "film.mp4", film)
    assert key_frames_of(path, panels=1)[0].time == pytest.approx(6 / RATE)


def test_equal_pictures_are_shown_once(tmp_path: Path) -> None:
    """Two alternating places, each seen three times."""
    frames = [frame for number in range(6) for frame in shot(PLACES[number % 2], 15, 0.1)]
    path = write_film(tmp_path / "film.mp4", frames)
    assert len(key_frames_of(path)) == 2
    assert len(key_frames_of(path, panels=5)) == 5


@pytest.mark.parametrize(
    ("frames", "most"),
    [
        (lambda: [view(PLACES[0])], 1),
        (lambda: [view(PLACES[0])] * 60, 1),
        (lambda: shot(PLACES[0], 50, 2), 3),
        (lambda: [np.ascontiguousarray(np.rot90(frame)) for frame in shot(PLACES[1], 50)], 3),
    ],
    ids=["one frame", "still", "two seconds", "upright"],
)
def test_short_films_give_few_key_frames(
    tmp_path: Path, frames: Callable[[], list[np.ndarray]], most: int
) -> None:
    pictures = frames()
    path = write_film(tmp_path / "film.mp4", pictures)
    key_frames = key_frames_of(path)
    assert 1 <= len(key_frames) <= most
    assert {each.shape for each in key_frames} == {pictures[0].shape[:2]}
    whole = Box(0, 0, *reversed(key_frames[0].shape))
    assert all(whole.contains(each.saliency) and each.saliency.area > 0 for each in key_frames)


def test_a_black_film_has_nothing_to_show(tmp_path: Path) -> None:
    path = write_film(tmp_path / "film.mp4", [np.zeros_like(view(PLACES[0]))] * 30)
    with pytest.raises(InputError, match="holds only blank frames$"):
        key_frames_of(path)
    assert len(key_frames_of(path, at=(0.5,))) == 1


def test_a_pipe_is_refused() -> None:
    with pytest.raises(UsageError, match="standard input can be read only once; save the film to a file"):
        open_film("-")


def test_a_folder_of_pictures_is_a_film(tmp_path: Path) -> None:
    for number, name in enumerate(["picture 2.png", "picture 10.png", "again.png", "notes.txt"]):
        if name.endswith("png"):
            picture = view(PLACES[number if number < 2 else 0], size=(320, 180))
            cv2.imwrite(str(tmp_path / name), picture[..., ::-1])
        else:
            (tmp_path / name).write_text("no picture")
    film = open_film(tmp_path)
    key_frames = find_key_frames(film)
    assert [each.time for each in key_frames] in ([0, 2], [1, 2])  # "again" is "picture 2"
    frames = list(film.frames_at([2]))
    assert np.array_equal(frames[0], view(PLACES[1], size=(320, 180)))


def test_folders_in_a_folder_are_its_chapters(tmp_path: Path) -> None:
    for name in ("cover.png", "10/1.png", "2/b.png", "2/a.png", "2/deep/1.png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        make_picture(tmp_path / name)
    paths = PictureFolder(tmp_path, FaceFinder())._paths
    names = [each.relative_to(tmp_path).as_posix() for each in paths]
    assert names == ["cover.png", "2/a.png", "2/b.png", "10/1.png"]


def test_a_folder_without_pictures_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no pictures$"):
        open_film(tmp_path)
    (tmp_path / "bad.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match="holds no readable pictures$"):
        find_key_frames(open_film(tmp_path))


def test_pictures_of_a_folder_that_cannot_be_read_are_damage(tmp_path: Path) -> None:
    make_picture(tmp_path / "good.png")
    (tmp_path / "bad.png").write_bytes(b"no picture")
    film = open_film(tmp_path)
    film.survey()
    assert film.damage.report() == "the input is damaged: 1 frame could not be decoded"


def test_one_picture_is_a_film(tmp_path: Path) -> None:
    path = make_picture(tmp_path / "picture.png")
    (key_frame,) = key_frames_of(path)
    assert (key_frame.time, key_frame.shape) == (0, (180, 320))


def test_numbered_pictures_and_animations_are_films(tmp_path: Path) -> None:
    from PIL import Image

    pictures = [Image.fromarray(view(PLACES[number // 5])) for number in range(15)]
    for number, picture in enumerate(pictures):
        picture.save(tmp_path / f"{number:03d}.png")
    pictures[0].save(tmp_path / "film.gif", save_all=True, append_images=pictures[1:], duration=200)
    assert [each.scene for each in key_frames_of(tmp_path / "%03d.png", panels=3)] == [0, 1, 2]
    assert [each.scene for each in key_frames_of(tmp_path / "film.gif", panels=3)] == [0, 1, 2]


def test_only_key_frames_of_a_long_film_are_decoded(six_shots: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit is reduced below this film, which has a key frame each second."""
    monkeypatch.setattr(film_file, "MAX_WHOLE_PIXELS", 0)
    monkeypatch.setattr(film_file, "MAX_CANDIDATES", 8)
    monkeypatch.setattr(film_file, "MIN_KEYS_PER_PANEL", 0.1)
    film = open_film(six_shots)
    times = [each.time for each in film.survey().candidates]
    assert times == pytest.approx(range(8))
    key_frames = find_key_frames(film)
    assert len(key_frames) >= 4
    assert all(abs(each.time - round(each.time)) <= 0.8 for each in key_frames)
    assert count_doubles(seen_at(six_shots, key_frames)) == 0


@pytest.mark.parametrize("kind", ["mkv", "mp4"])
def test_key_frames_show_that_a_long_film_is_truncated(
    kind: str, six_shots: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An MP4 has its index in front; the frames between key frames are not decoded."""
    monkeypatch.setattr(film_file, "MAX_WHOLE_PIXELS", 0)
    monkeypatch.setattr(film_file, "MIN_KEYS_PER_PANEL", 0.1)
    whole, cut = remux(six_shots, tmp_path / f"whole.{kind}", movflags="faststart"), tmp_path / f"cut.{kind}"
    cut.write_bytes(whole.read_bytes()[:-20000])
    for path, is_cut in ((whole, False), (cut, True)):
        with open_film(path) as film:
            film.survey()
            assert film.damage.cut_off == film.damage.is_significant == is_cut


def test_exact_frames_are_fetched(six_shots: Path) -> None:
    frames = list(story(6, 30))
    times = [3 / RATE, 100.5 / RATE, 179 / RATE]
    for number, fetched in zip((3, 100, 179), open_film(six_shots).frames_at(times), strict=True):
        distances = [
            np.abs(frames[other].astype(int) - fetched).mean() for other in range(number - 2, number + 1)
        ]
        assert int(np.argmin(distances)) == 2


def test_memory_does_not_grow_with_the_film(six_shots: Path) -> None:
    """A candidate keeps little memory, however large the picture."""
    candidate = open_film(six_shots).survey().candidates[0]
    kept = [getattr(candidate, name) for name in candidate.__dataclass_fields__]
    assert sum(array.nbytes for array in kept if isinstance(array, np.ndarray)) < 7168
    assert all(
        array.base is None or array.base.nbytes < 4096 for array in kept if isinstance(array, np.ndarray)
    )


def test_a_long_film_with_too_few_key_frames_is_decoded_whole(
    six_shots: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has eight key frames and would get five panels."""
    monkeypatch.setattr(film_file, "MAX_WHOLE_PIXELS", 0)
    counts = []
    for spare in (1.5, 2.5):
        monkeypatch.setattr(film_file, "MIN_KEYS_PER_PANEL", spare)
        counts.append(len(open_film(six_shots).survey().candidates))
    assert counts[0] == 8 < counts[1]
