"""--threads and VIDSTYLE_THREADS: pools and codecs use the number, and the pictures do not depend on it."""

from __future__ import annotations

import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import av
import click
import media
import pytest
from av.codec.context import CodecContext

import vidstyle
from vidstyle import cli
from vidstyle.cli import commands
from vidstyle.core.machine.cores import THREADS_VARIABLE, process_cores
from vidstyle.media.read import decoder
from vidstyle.media.write.video_plan import VideoPlan

COMPUTING = ("bench", "comic", "demo", "design", "explore", "export", "live", "render", "styles", "train")


@pytest.fixture(autouse=True)
def without_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(THREADS_VARIABLE, raising=False)


def test_every_command_that_computes_has_the_option() -> None:
    context = click.Context(commands)
    for name in (*COMPUTING, "doctor"):
        command = commands.get_command(context, name)
        assert command is not None and any("--threads" in each.opts for each in command.params), name


@pytest.mark.parametrize("style", ["ink", "comic"])
def test_pictures_do_not_depend_on_the_number_of_threads(tmp_path: Path, style: str) -> None:
    film = media.make_clip(tmp_path / "film.mp4", size=(320, 200), frames=4)
    made = []
    for number in (1, 2, 5, 16):
        target = tmp_path / f"{number}.y4m"
        arguments = ["render", film, target, "-s", style, "--threads", number, "--progress", "none"]
        assert cli.main([str(each) for each in arguments]) == 0
        made.append(target.read_bytes())
    assert len(set(made)) == 1


def test_pools_and_codecs_of_a_film_use_the_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    number = process_cores().number + 2
    pools, encoders, decoders = [], [], []
    start, configure = ThreadPoolExecutor.__init__, VideoPlan.configure
    create: Callable[..., Any] = decoder._open_context

    def noted_pool(self: Any, max_workers: int | None = None, *rest: Any, **named: Any) -> None:
        pools.append(max_workers)
        start(self, max_workers, *rest, **named)

    def noted_encoder(self: VideoPlan, context: av.VideoCodecContext) -> None:
        configure(self, context)
        encoders.append(context.thread_count)

    def noted_decoder(*arguments: Any, **named: Any) -> CodecContext:
        context: CodecContext = create(*arguments, **named)
        decoders.append(context.thread_count)
        return context

    monkeypatch.setattr(ThreadPoolExecutor, "__init__", noted_pool)
    monkeypatch.setattr(VideoPlan, "configure", noted_encoder)
    monkeypatch.setattr(decoder, "_open_context", noted_decoder)
    film = media.make_clip(tmp_path / "film.mp4", frames=2)
    arguments = ["render", film, tmp_path / "out.mp4", "-s", "cartoon", "--threads", number]
    assert cli.main([str(each) for each in arguments]) == 0
    assert number in pools and encoders and decoders
    assert set(encoders) == set(decoders) == {number}


def test_a_wrong_number_is_a_usage_error(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cli.main(["render", "in.mp4", "out.mp4", "-s", "plain", "--threads", "0"]) == 2
    assert capfd.readouterr().err == "vidstyle: --threads: 0 is outside 1 to 1024\n"
    monkeypatch.setenv(THREADS_VARIABLE, "many")
    assert cli.main(["render", "in.mp4", "out.mp4", "-s", "plain"]) == 2
    said = capfd.readouterr().err
    assert said.startswith("vidstyle: VIDSTYLE_THREADS: 'many' is not a number") and said.count("\n") == 1


def test_the_doctor_says_the_number_and_its_reason(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    number = process_cores().machine + 1
    assert cli.main(["doctor", "--threads", str(number)]) == 0
    assert re.search(rf"^cores +{number}: --threads$", capfd.readouterr().out, re.MULTILINE)
    monkeypatch.setenv(THREADS_VARIABLE, str(number))
    assert cli.main(["doctor"]) == 0
    assert re.search(rf"^cores +{number}: {THREADS_VARIABLE}$", capfd.readouterr().out, re.MULTILINE)


def test_memory_limits_the_frames_of_a_film(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    film, target = str(media.make_clip(tmp_path / "film.mp4", frames=2)), str(tmp_path / "out.mp4")
    arguments = ["render", film, target, "-s", "cartoon", "-d", "cpu", "--threads", "2", "--progress", "none"]
    assert cli.main([*arguments, "--memory", "1T"]) == 0
    assert capfd.readouterr().err == ""
    assert cli.main([*arguments, "-y", "--memory", "1M"]) == 0
    said = capfd.readouterr().err
    assert said.startswith("vidstyle: --memory: a frame of ") and said.count("\n") == 1
    assert cli.main([*arguments, "-y", "--memory", "5"]) == 2
    assert capfd.readouterr().err == "vidstyle: --memory: 5 is outside 1M to 16T\n"


def test_the_configuration_file_sets_the_memory(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    film, config = media.make_clip(tmp_path / "film.mp4", frames=2), tmp_path / "config.toml"
    config.write_text('[render]\nmemory = "1M"\n')
    arguments = ["render", film, tmp_path / "out.mp4", "-s", "cartoon", "-d", "cpu", "--progress", "none"]
    assert cli.main(["--config", str(config), *map(str, arguments)]) == 0
    assert "--memory: a frame of " in capfd.readouterr().err


def test_no_other_file_counts_the_cores() -> None:
    package = Path(vidstyle.__file__).parent
    counting = re.compile(r"cpu_count|sched_getaffinity|setNumThreads|PoolExecutor\(\)")
    found = [path for path in package.rglob("*.py") if counting.search(path.read_text(encoding="utf-8"))]
    # Separate processes, which get a number of threads.
    own = {package / "network" / "network_program.py", package / "cpu" / "style_worker.py"}
    assert [path for path in found if path not in own] == [package / "core" / "machine" / "cores.py"]
