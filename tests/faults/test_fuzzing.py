"""The mutations of tools/fuzz.py do what they say, and its judgments notice what they are for."""

from __future__ import annotations

import struct
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from random import Random

import av
import numpy as np
import pytest
import tomlkit
from onnx_model import negative
from PIL import Image

from tools.fuzzing.arrays import VIEWS, to_native
from tools.fuzzing.attempts import attempt
from tools.fuzzing.cases import make_file
from tools.fuzzing.commands import check_end
from tools.fuzzing.film_times import TIMED, concatenate, shift_times
from tools.fuzzing.formats import FAMILIES
from tools.fuzzing.frame_counts import check_frames, count_ffmpeg_frames
from tools.fuzzing.kernel_caches import damage_files
from tools.fuzzing.metadata import PLACERS, add_metadata, profile
from tools.fuzzing.originals import write_originals
from tools.fuzzing.pages import CUE_FILE
from tools.fuzzing.processes import BrokenPromiseError, Ended, run_apart, run_here
from tools.fuzzing.restructure import restructure
from tools.fuzzing.structure import part_lists
from vidstyle.errors import InputError, VidstyleError


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    whole = write_originals(tmp_path_factory.mktemp("originals"), ["film", "picture"])
    return {path.name: path for paths in whole.values() for path in paths}


def frames(content: bytes, path: Path) -> list[av.VideoFrame]:
    path.write_bytes(content)
    with av.open(str(path)) as container:
        return list(container.decode(video=0))


PARTS = {
    "film.mp4": [b"moov", b"stts", b"elst", b"avc1"],
    "film.mov": [b"moov", b"stts"],
    "film.mkv": [b"\x1f\x43\xb6\x75", b"\xe7", b"\xa3", b"\xae"],
    "film.webm": [b"\x1f\x43\xb6\x75", b"\xa3"],
    "film.avi": [b"avih", b"strh", b"00dc"],
    "film.flv": [b"\x08", b"\x09", b"\x12"],
    "film.ts": [b"\x47"],
    "rgb.png": [b"IHDR", b"IDAT", b"IEND"],
    "usual.jpg": [b"\xff\xe1", b"\xff\xc0", b"\xff\xda"],
    "lossless.webp": [b"RIFF", b"VP8L"],
    "plain.tif": [struct.pack("<H", 256), struct.pack("<H", 273)],
    "profile.avif": [b"meta", b"iprp", b"colr"],
}
"""Some of the parts of a file."""


@pytest.mark.parametrize("name", PARTS)
def test_a_file_is_read_as_its_parts_and_written_again(
    name: str, originals: dict[str, Path], tmp_path: Path
) -> None:
    path = originals[name]
    family, content = FAMILIES[path.suffix], path.read_bytes()
    parts = family.read(content)
    found = {part.name for siblings in part_lists(parts) for part in siblings}
    assert set(PARTS[name]) <= found
    before, after = frames(content, tmp_path / name), frames(family.write(parts), tmp_path / name)
    assert len(before) == len(after) > 0
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one.to_ndarray(format="rgb24"), other.to_ndarray(format="rgb24"))


@pytest.mark.parametrize("name", PARTS)
def test_structures_are_changed_in_many_ways(name: str, originals: dict[str, Path]) -> None:
    path = originals[name]
    content, family = path.read_bytes(), FAMILIES[path.suffix]
    made = {restructure(Random(seed), content, family, content) for seed in range(100)}
    assert len(made) > 40
    assert {len(each) > len(content) for each in made} == {True, False}


@pytest.mark.parametrize("suffix", TIMED)
def test_times_jump_by_hours(suffix: str, originals: dict[str, Path], tmp_path: Path) -> None:
    content = originals[f"film{suffix}"].read_bytes()
    longest = 0.0
    for seed in range(40):
        (tmp_path / f"film{suffix}").write_bytes(shift_times(Random(seed), content, suffix))
        try:
            with av.open(str(tmp_path / f"film{suffix}")) as container:
                times = [
                    packet.dts * packet.time_base for packet in container.demux() if packet.dts is not None
                ]
        except av.FFmpegError:
            continue
        longest = max(longest, float(max(times, default=0) - min(times, default=0)))
    assert longest > 3600


def test_films_are_joined_with_other_pids(originals: dict[str, Path], tmp_path: Path) -> None:
    contents = [originals[name].read_bytes() for name in ("film.ts", "other-pids.ts")]
    path = tmp_path / "joined.ts"
    path.write_bytes(b"".join(contents))
    with av.open(str(path)) as container:
        assert len(container.streams.video) == 2
    assert {concatenate(Random(seed), contents) for seed in range(20)} >= {b"".join(contents)}


@pytest.mark.filterwarnings("ignore")  # Pillow warns of damaged metadata
@pytest.mark.parametrize("suffix", PLACERS)
def test_metadata_is_where_readers_look_for_it(
    suffix: str, originals: dict[str, Path], tmp_path: Path
) -> None:
    name = {".png": "rgb.png", ".jpg": "progressive.jpg", ".webp": "lossy.webp", ".tif": "plain.tif"}[suffix]
    content, has_profile, turns = originals[name].read_bytes(), False, set[object]()
    for seed in range(100):
        (tmp_path / name).write_bytes(add_metadata(Random(seed), content, suffix))
        try:
            with Image.open(tmp_path / name) as picture:
                has_profile |= picture.info.get("icc_profile") == profile()
                turns.add(picture.getexif().get(0x112))
        except Exception:  # Pillow has many for damaged pictures
            continue
    assert has_profile and len(turns & {2, 3, 4, 5, 6, 7, 8}) > 2


@pytest.mark.parametrize("view", VIEWS)
def test_views_have_the_values_of_their_native_copies(view: Callable[[np.ndarray], np.ndarray]) -> None:
    made = view(np.random.default_rng(1).uniform(size=(6, 7, 3)).astype(np.float32))
    copy = to_native(made)
    np.testing.assert_array_equal(copy, made)
    assert copy.flags.c_contiguous and copy.dtype.isnative


@pytest.mark.parametrize(
    ("exit_code", "lines", "written", "wrong"),
    [
        (1, ["internal error"], [], "exit 1: internal error"),
        (5, ["cannot be written"], [], "exit 5"),
        (3, ["one", "two"], [], "2 lines"),
        (3, [], [], "0 lines"),
        (3, ["one"], ["out.mkv"], "with the files"),
        (0, [], [], "with the files"),
        (0, [], ["out.partial.mkv"], "with the files"),
        (4, ["damaged"], [], "with the files"),
    ],
)
def test_a_command_must_keep_to_the_rules(
    exit_code: int, lines: list[str], written: list[str], wrong: str, tmp_path: Path
) -> None:
    for name in written:
        (tmp_path / name).touch()
    with pytest.raises(BrokenPromiseError, match=wrong):
        check_end(Ended(exit_code, lines, ""), tmp_path)


def test_a_command_that_keeps_to_the_rules_is_accepted(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="was refused: no film"):
        check_end(Ended(3, ["no film"], ""), tmp_path)
    (tmp_path / "out.mkv").touch()
    check_end(Ended(0, [], ""), tmp_path)
    check_end(Ended(4, ["damaged"], ""), tmp_path)


@pytest.mark.parametrize("kind", ["cue", "network"])
def test_cue_files_and_networks_are_used_as_films_are(tmp_path: Path, kind: str) -> None:
    """Intact files are used, and damaged ones are refused."""
    whole = {"cue": (".cues.toml", tomlkit.dumps(CUE_FILE).encode()), "network": (".onnx", negative())}[kind]
    path = tmp_path / f"case{whole[0]}"
    for number, content in enumerate((whole[1], whole[1][: len(whole[1]) // 2])):
        path.write_bytes(content)
        (folder := tmp_path / str(number)).mkdir()
        with pytest.raises(VidstyleError) if number else nullcontext():
            attempt(path, folder)
    first, second = ([make_file(kind, 5, number, {}) for number in range(5)] for _ in range(2))
    assert first == second and len({*first, whole}) > 4


def test_programs_are_run_and_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    assert run_apart(["-m", "vidstyle", "styles", "nothing"]).exit_code == 3
    assert run_here(["styles", "nothing"]).exit_code == 3
    with pytest.raises(BrokenPromiseError, match="signal 6"):
        run_apart(["-c", "import os; os.abort()"])
    monkeypatch.setattr("tools.fuzzing.processes.MAX_PROCESSOR_SECONDS", 0.2)
    with pytest.raises(BrokenPromiseError, match="hang"):
        run_apart(["-c", "import threading; threading.Event().wait()"])


def test_missing_frames_are_noticed(originals: dict[str, Path]) -> None:
    if not count_ffmpeg_frames(originals["film.mkv"]):
        pytest.skip("ffprobe is not installed")
    check_frames(originals["film.mkv"], 10)
    with pytest.raises(BrokenPromiseError, match="fewer frames: 9 of 10"):
        check_frames(originals["film.mkv"], 9)


def test_a_recording_that_follows_another_counts(originals: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "joined.ts"
    path.write_bytes(originals["film.ts"].read_bytes() + originals["other-pids.ts"].read_bytes())
    assert count_ffmpeg_frames(path) in (0, 20)


def test_caches_are_damaged(tmp_path: Path) -> None:
    faults = set()
    for seed in range(60):
        files = [tmp_path / f"{seed}-{number}.o" for number in range(3)]
        for file in files:
            file.write_bytes(file.name.encode() * 100)
        damage_files(Random(seed), files)
        faults |= {
            "link" if file.is_symlink() else "folder" if file.is_dir() else "lost" if not file.exists()
            else "bytes" if file.read_bytes() != file.name.encode() * 100 else ""
            for file in files
        }  # fmt: skip
    assert faults == {"link", "folder", "lost", "bytes", ""}


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["film.mkv", "rgb.png"])
def test_undamaged_files_are_used(name: str, originals: dict[str, Path], tmp_path: Path) -> None:
    """By the API and by each command, whichever the checksum of the file leads to."""
    for number in range(60):
        path = tmp_path / f"{number}{originals[name].suffix}"
        path.write_bytes(originals[name].read_bytes() + bytes(number))
        (tmp_path / str(number)).mkdir()
        try:
            attempt(path, tmp_path / str(number))
        except VidstyleError as error:
            pytest.fail(str(error))
