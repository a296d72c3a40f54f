"""PictureMetrics, gates, pruning and score of random styles."""

from __future__ import annotations

import math
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from face_network import brightness_judge
from skimage import data

from vidstyle.errors import InputError
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.gates import (
    DOUBTFUL_FAULT,
    FULL_SIZE_GATES,
    MAX_UNSTEADY,
    MIN_SCORES,
    PAPER_GATES,
    Gate,
    fault,
    is_like_another,
    prune,
)
from vidstyle.explore.generate import mutate
from vidstyle.explore.measure import MAX_MEASURED_SIDE_PX, Original, PictureMetrics
from vidstyle.explore.score import MEASURES, WORDS, Judge, spread_out
from vidstyle.media.resize import reduce_picture
from vidstyle.style import Step, Style, load_style

PHOTOGRAPHS = ("astronaut", "coffee")
PAGE = Path(__file__).parents[2] / "docs" / "explore.md"


def table_rows(header: str) -> list[tuple[str, str]]:
    """The rows of the table of two columns with this header in docs/explore.md."""
    table = PAGE.read_text(encoding="utf-8").partition(header)[2].partition("\n\n")[0]
    return re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", table, re.MULTILINE)


def limit_texts(gate: Gate) -> tuple[str, ...]:
    """How the document may write the limit of a gate; some are logarithms."""
    limit = gate.high if gate.low in (0, -1) else gate.low
    return f"{limit:g}", f"{100 * limit:g} %", f"{100 * math.exp(limit):.0f} %"


def test_gates_at_full_size_are_documented_with_their_limits() -> None:
    rows = dict(table_rows("| reason | limit |"))
    gates = FULL_SIZE_GATES + PAPER_GATES
    assert rows.keys() == {DOUBTFUL_FAULT, *(gate.reason for gate in gates)}
    assert all(f"{100 * limit:g} %" in rows[DOUBTFUL_FAULT] for limit in MIN_SCORES.values())
    for gate in gates:
        limits = "|".join(map(re.escape, limit_texts(gate)))
        assert re.search(rf"(?<![\d.])({limits})(?!\d)", rows[gate.reason]), gate


def test_measures_of_the_score_are_documented() -> None:
    found = [(rules, re.split("[:,]", text)[0]) for rules, text in table_rows("| rules | measurement |")]
    assert sorted(found) == sorted(
        (rules, WORDS[name]) for rules, names in MEASURES.items() for name in names
    )


@pytest.fixture(scope="module")
def cat() -> Original:
    return Original(data.chelsea())


def measured(original: Original, picture: np.ndarray) -> PictureMetrics:
    return original.measure(picture.clip(0, 255).astype(np.uint8))


# Their dark paper has little of the picture's contrast, which counts as muddy.
UNUSUAL = ("neon", "blueprint")
ORDINARY = [style for style in shipped_styles() if style.name not in UNUSUAL]


@pytest.mark.parametrize("style", ORDINARY[1::5], ids=lambda style: style.name)
def test_shipped_styles_pass_the_gates(cat: Original, style: Style) -> None:
    picture = cat.render(style)
    assert fault(cat.measure(picture)) == ""
    assert cat.steadiness(style, picture) < MAX_UNSTEADY


@pytest.mark.thorough
@pytest.mark.parametrize("name", PHOTOGRAPHS)
def test_all_shipped_styles_pass_the_gates(name: str) -> None:
    original = Original(getattr(data, name)())
    faults = {style.name: fault(original.measure(original.render(style))) for style in ORDINARY}
    assert sum(map(bool, faults.values())) <= 1, faults


def test_gates_name_what_is_wrong(cat: Original) -> None:
    picture = cat.picture.astype(float)
    height, width = picture.shape[:2]
    grain = np.random.default_rng(1).uniform(-150, 150, (height // 2, width // 2, 1))
    noise = cv2.resize(grain, (width, height), interpolation=cv2.INTER_NEAREST)[..., None]
    wrong = {
        "blank": np.full_like(picture, 255),
        "black": picture * 0.1,
        "muddy": 128 + 0.2 * (picture - 128),
        "blurred": cv2.GaussianBlur(picture, (0, 0), 9) * 1.6 - 60,
        "cluttered": picture + noise,
        "a negative": 255 - picture,
        "like the source": picture,
    }
    assert {reason: fault(measured(cat, each)) for reason, each in wrong.items()} == {
        reason: reason for reason in wrong
    }


def test_signatures_tell_how_alike_pictures_are(cat: Original) -> None:
    style = load_style("oil")
    here, near, far = (
        cat.signature(cat.render(each)) for each in (style, mutate(style, 1, 0.05), load_style("sketch"))
    )
    assert is_like_another(near, [far, here]) and not is_like_another(far, [here])
    assert np.linalg.norm(here - near) < np.linalg.norm(here - far)


def test_measures_do_not_depend_on_the_size(cat: Original) -> None:
    picture = cat.render(load_style("cartoon"))
    small = cat.measure(reduce_picture(picture, MAX_MEASURED_SIDE_PX))
    assert small.tone == pytest.approx(cat.measure(picture).tone, abs=0.02)


def test_pruning_removes_what_changes_nothing(cat: Original) -> None:
    idle = Step("saturation", {"factor": 1.0})
    steps = (Step("to_gray"), Step("etf"), idle, Step("brightness", {"factor": 1.0}), Step("to_color"))
    style = Style("idle", background=(*steps, Step("luma_posterize", {"levels": 5}), idle))
    left = prune(style, cat, cat.render(style))
    assert [step.block for step in left.steps] == ["to_gray", "etf", "to_color", "luma_posterize"]


def test_choice_spreads_out() -> None:
    signatures = np.array([[0.0, 0], [0.1, 0], [5, 0], [5.1, 0], [0, 4]])
    scores = np.array([1.0, 0.9, 0.5, 0.8, 0.7])
    assert spread_out(signatures, scores, 3) == [0, 3, 4]
    assert sorted(spread_out(signatures, scores, 9)) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("classes", [1, 10])
def test_judge_prefers_what_it_was_made_to_prefer(tmp_path: Path, classes: int) -> None:
    (tmp_path / "judge.onnx").write_bytes(brightness_judge(classes))
    judge = Judge(tmp_path / "judge.onnx")
    dark, bright = (judge(np.full((60, 90, 3), level, np.uint8)) for level in (20, 230))
    assert dark < bright
    assert classes == 1 or 1 <= dark < bright <= 10


@pytest.mark.parametrize("content", [b"", b"not a model"])
def test_judge_refuses_other_files_in_a_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model.onnx").write_bytes(content)
    with pytest.raises(InputError, match="model that scores pictures"):
        Judge(tmp_path / "model.onnx")


def test_judge_refuses_models_of_other_shape(tmp_path: Path) -> None:
    three = tmp_path / "three.onnx"
    three.write_bytes(brightness_judge(3))
    with pytest.raises(InputError, match="returns 3 numbers"):
        Judge(three)
