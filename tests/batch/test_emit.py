"""Jobs for other managers."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import faults
import media
import pytest

from vidstyle import cli
from vidstyle.batch.emit import job_text
from vidstyle.batch.journal import JOURNAL

PHASES = [["touch 'a b'", "touch c"], ["mv 'a b' d"]]
SBATCH = """#!/bin/sh
# Runs an array at once, as Slurm does later: sbatch --parsable --array=0-N [--dependency=afterok:N] < script
echo "$@" >> calls
cat > script
for number in $(seq 0 "$(echo "$2" | cut -d- -f4)"); do SLURM_ARRAY_TASK_ID=$number sh script || exit 1; done
echo 7
"""
needs_sh = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no sh")


@needs_sh
def test_a_slurm_script_submits_arrays_that_wait_for_each_other(tmp_path: Path) -> None:
    (tmp_path / "sbatch").write_text(SBATCH)
    (tmp_path / "sbatch").chmod(0o700)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    script = job_text(PHASES, "slurm")
    subprocess.run(["sh"], input=script, text=True, cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "d").exists() and (tmp_path / "c").exists() and not (tmp_path / "a b").exists()
    first, second = (tmp_path / "calls").read_text().splitlines()
    assert first == "--parsable --array=0-1" and second == "--parsable --array=0-0 --dependency=afterok:7"


@needs_sh
def test_an_openjd_template_has_a_step_for_each_phase(tmp_path: Path) -> None:
    job = json.loads(job_text(PHASES, "openjd"))
    segments, films = job["steps"]
    assert films["dependencies"] == [{"dependsOn": segments["name"]}]
    for step, count in ((segments, 2), (films, 1)):
        (parameter,) = step["parameterSpace"]["taskParameterDefinitions"]
        assert parameter["range"] == f"0-{count - 1}"
        for number in range(count):
            commands = step["script"]["embeddedFiles"][0]["data"]
            subprocess.run(["sh", "-s", str(number)], input=commands, text=True, cwd=tmp_path, check=True)
    assert (tmp_path / "d").exists()
    assert [step["name"] for step in json.loads(job_text(PHASES[1:], "openjd"))["steps"]] == ["Films"]


def test_an_openjd_template_is_valid() -> None:
    model = pytest.importorskip("openjd.model")
    template = model.decode_job_template(template=json.loads(job_text(PHASES, "openjd")))
    assert len(template.steps) == 2


def test_the_commands_of_a_job_make_the_film_that_the_batch_makes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("a.mp4"), size=(64, 48), frames=40, scene_frames=20, audio_tracks=1)
    batch = ["batch", "a.mp4", "-s", "plain", "-o", "out/{name}.mp4", "--segment", "0.5", "--threads", "1"]
    assert cli.main([*batch, "--emit", "shell"]) == 0
    lines = capfd.readouterr().out.splitlines()
    ranges = [word for line in lines for word in shlex.split(line) if "--range" in word]
    assert ranges == ["--range=0:15", "--range=15:30", "--range=30:40"]
    monkeypatch.chdir("/")
    for line in lines:
        program, *words = shlex.split(line)
        assert program == "vidstyle" and cli.main(words) == 0, capfd.readouterr().err
    monkeypatch.chdir(tmp_path)
    assert len(media.read_all(Path("out/a.mp4"))) == 40
    assert sorted(path.name for path in Path("out").iterdir()) == [JOURNAL, "a.mp4"]
    assert cli.main([*batch, "--emit", "shell"]) == 2
    assert "all films are finished" in capfd.readouterr().err
    made = Path("out/a.mp4").rename("emitted.mp4")
    assert cli.main(batch) == 0
    for kind in ("video", "audio"):
        one, other = faults.packets(Path("out/a.mp4"), kind), faults.packets(made, kind)
        pairs = enumerate(zip(one, other, strict=True))
        # The sizes of packets, not their bytes, show which side is wrong.
        assert [(number, len(each[1]), len(same[1])) for number, (each, same) in pairs if each != same] == []


def test_a_name_that_a_job_cannot_hold_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("a{b.mp4"), size=(64, 48), frames=2)
    words = ["batch", "a{b.mp4", "-s", "plain", "-o", "out/{name}.mp4", "--emit", "openjd"]
    assert cli.main(words) == 2 and "rename the film" in capfd.readouterr().err
