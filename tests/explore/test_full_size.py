"""Measures of crops at full size, their gates and the score."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from skimage import data

from vidstyle.explore.full_size import MAX_FACE_LIKENESS, FullSize, FullSizeMetrics
from vidstyle.explore.gates import DOUBTFUL_FAULT, doubt, fault
from vidstyle.explore.generate import random_style
from vidstyle.explore.measure import Original
from vidstyle.explore.score import reasons, score
from vidstyle.style import Step, Style, load_style

PLAIN = Style("plain", height=720)


def styled(*steps: Step) -> Style:
    return Style("test", height=720, background=steps)


@pytest.fixture(scope="module")
def cat() -> FullSize:
    return FullSize(cv2.resize(data.chelsea(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC))


@pytest.fixture(scope="module")
def astronaut() -> FullSize:
    return FullSize(data.astronaut())


def test_the_picture_itself_keeps_everything(astronaut: FullSize) -> None:
    measures = astronaut.measure(PLAIN)
    for kept in (measures.structure, measures.shapes_kept, measures.tones_kept, measures.face):
        assert kept == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("name", ["comic", "engraving", "poster"])
def test_shipped_styles_pass(astronaut: FullSize, name: str) -> None:
    assert fault(astronaut.measure(load_style(name))) == ""


@pytest.mark.parametrize("step", [Step("saturation", {"factor": 2}), Step("flow_dog", {"sigma": 2, "p": 10})])
def test_a_smear_never_passes(astronaut: FullSize, cat: FullSize, step: Step) -> None:
    """Also one that looks sharp when it is reduced to the size of a tile."""
    smear = styled(Step("scale", {"factor": 0.14}), step)
    small = Original(data.astronaut())
    assert fault(small.measure(small.render(smear))) == ""
    for crops in (astronaut, cat):
        assert fault(crops.measure(smear)) == "blurred at full size"


def test_faces_are_lost_when_their_features_are(astronaut: FullSize, cat: FullSize) -> None:
    blots = styled(Step("gaussian", {"sigma": 20}), Step("soft_threshold", {"phi": 0.5, "epsilon": 90}))
    assert astronaut.measure(blots).face < 0.55 < astronaut.measure(load_style("poster")).face
    assert cat.measure(blots).face == MAX_FACE_LIKENESS
    measures = astronaut.measure(load_style("poster"))._replace(face=0.3)
    assert fault(measures) == "with lost faces"


def test_lengths_in_crops_are_those_in_the_whole_picture() -> None:
    """A picture that is twice as large has dots that are twice as large, also in its crops."""
    dots = styled(Step("halftone", {"cell": 12}))
    once, twice = (
        FullSize(cv2.resize(data.chelsea(), None, fx=factor, fy=factor)).measure(dots) for factor in (2, 4)
    )
    assert twice.edge_sharpness < once.edge_sharpness


@pytest.mark.parametrize("shape", [(1, 1), (1, 400), (37, 5), (300, 410)])
def test_any_size_is_measured(shape: tuple[int, int]) -> None:
    picture = np.random.default_rng(1).integers(0, 255, (*shape, 3), np.uint8)
    assert np.isfinite(FullSize(picture).measure(load_style("poster"))).all()


def test_score_says_which_measures_speak_for_or_against(astronaut: FullSize) -> None:
    good = astronaut.measure(load_style("poster"))
    bad = good._replace(edge_sharpness=0.2, black=0.9)
    assert score(bad) < score(good)
    assert reasons(bad)["edge_sharpness"] < 0 and reasons(bad)["black"] < 0
    assert set(reasons(good)) == set(FullSizeMetrics._fields)
    assert doubt(score(bad)) == DOUBTFUL_FAULT and doubt(0.9) == ""


def test_random_styles_have_scores_between_0_and_1(cat: FullSize) -> None:
    for seed in range(4):
        assert 0 <= score(cat.measure(random_style(seed))) <= 1
