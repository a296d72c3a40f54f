"""Networks that find people: wrong ones, what they remember, and a crash."""

from pathlib import Path

import numpy as np
import pytest
from face_network import brightness_judge, gray_and_red, red_people, remembering_people
from media import photograph

from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.errors import InputError, UsageError
from vidstyle.regions.chosen_files import MODEL_VARIABLE, people_model
from vidstyle.regions.frame_masks import FrameMasks
from vidstyle.regions.people import PeopleNetwork
from vidstyle.style import load_style

ONLY_PEOPLE = {"format": 1, "only": "people"}


def test_without_a_model_one_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(MODEL_VARIABLE, raising=False)
    if people_model() is not None:
        pytest.skip("a model is installed")
    with pytest.raises(
        UsageError, match="mask people needs a model .* --no-deps mediapipe==0.10.14, or give --model"
    ):
        FrameMasks(load_style(ONLY_PEOPLE))


def test_wrong_models_are_refused_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = red_people()
    for name, content in {
        "lost.onnx": None,
        "text.txt": b"no model",
        "noise.tflite": bytes(range(256)) * 8,
        "noise.onnx": bytes(range(256)) * 8,
        "cut.onnx": good[:150],
        "judge.onnx": brightness_judge(1),
        "empty.tflite": b"",
        "lost-state.onnx": remembering_people(("r1i", "memory")),
        "other-state.onnx": remembering_people(state_shape=[1, 1, 1, 1]),
        "vast-state.onnx": remembering_people(state_shape=[1, 1, 1 << 20, 1 << 20]),
        "narrow.onnx": remembering_people(size=(16, 8)),
        "wide.onnx": remembering_people(size=(4096, 64)),
    }.items():
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        monkeypatch.setenv(MODEL_VARIABLE, str(path))
        with pytest.raises(InputError, match="give a TFLite or ONNX model") as caught:
            FrameMasks(load_style(ONLY_PEOPLE))
        assert "\n" not in str(caught.value), name


def test_a_model_that_crashes_is_reported(red_model: Path) -> None:
    """It runs in another process, so the program continues."""
    network = PeopleNetwork(red_model)
    color = np.zeros((network.size[1], network.size[0], 3), np.uint8)
    color[:, 100:] = 250, 10, 10
    found = network.find(color)
    assert found[:, 110:].min() > 0.9 and found[:, :90].max() < 0.1
    network._process._process.kill()
    with pytest.raises(InputError, match="red.onnx: crashes the program that runs it") as caught:
        network.find(color)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("state", "result"),
    [(("r1i", "r1o"), "pha"), (("state_in", "state_out"), "people"), (("past", "present"), "a")],
)
def test_a_model_may_remember_earlier_pictures(state: tuple[str, str], result: str, tmp_path: Path) -> None:
    """Its inputs and outputs are found by their names, and what it remembers ends with a scene."""
    path = tmp_path / "matting.onnx"
    path.write_bytes(remembering_people(state, result))
    network, color = PeopleNetwork(path), np.zeros((144, 256, 3), np.uint8)
    color[...] = 250, 10, 10
    found = [network.find(color, is_first).mean() for is_first in (True, False, False, True)]
    assert np.allclose(found, [0.5, 0.75, 0.875, 0.5], atol=0.01)


def test_what_a_model_remembers_ends_at_a_cut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "matting.onnx"
    path.write_bytes(remembering_people())
    monkeypatch.setenv(MODEL_VARIABLE, str(path))
    frames, results = [Picture.from_array(gray_and_red())] * 6, []
    for first in (0, 3):
        masks = FrameMasks(load_style(ONLY_PEOPLE), KnownCuts([0.0, 3 / 25]))
        results.append([masks.of(frames[n], n / 25)["people"] for n in range(first, 6)])
        masks.close()
    assert results[0][2].mean() > 1.2 * results[0][0].mean()
    assert all(map(np.array_equal, results[0][3:], results[1]))


@pytest.mark.skipif(people_model() is None, reason="no model that finds people is installed")
def test_the_installed_model_finds_an_astronaut() -> None:
    color = photograph("astronaut")
    masks = FrameMasks(load_style(ONLY_PEOPLE))
    people = masks.of(Picture.from_array(color), None)["people"]
    masks.close()
    assert people[300:, 150:300].mean() > 240 and people[20:200, 330:].mean() < 40
