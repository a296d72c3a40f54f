"""Measures of crops at full size, their gates and the score."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import get_args

import cv2
import numpy as np
import pytest
from skimage import data

from vidstyle.errors import StyleError
from vidstyle.explore.candidates import examine
from vidstyle.explore.crops.crop_measures import MAX_FACE_LIKENESS, ComparedCrop, FullSizeMetrics
from vidstyle.explore.crops.full_size import Crop, FullSize, comparable_faces, tones_of
from vidstyle.explore.gates import DOUBTFUL_FAULT, UNUSABLE_FAULT, doubt, fault
from vidstyle.explore.generate import random_style
from vidstyle.explore.measure import Original
from vidstyle.explore.paper.rules import Rules
from vidstyle.explore.score import MEASURES, reasons, score, verdict
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.media.resize import reduce_picture
from vidstyle.regions.boxes import Box
from vidstyle.regions.still_faces import KnownFaces, StillFaces
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
    for kept in (measures.likeness, measures.detail_kept, measures.face):
        assert kept == pytest.approx(1, abs=1e-3)
    assert min(measures.structure_kept, measures.face_structure) > 0.9 and measures.smeared == 0


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
        assert fault(crops.measure(smear)) in ("blurred at full size", "without the subject")


def test_faces_are_lost_when_their_features_are(astronaut: FullSize, cat: FullSize) -> None:
    steps = Step("gaussian", {"sigma": 20}), Step("soft_threshold", {"phi": 0.5, "epsilon": 90})
    blots = replace(styled(*steps), focus=0.0)
    assert astronaut.measure(blots).face < 0.66 < astronaut.measure(load_style("poster")).face
    assert cat.measure(blots).face == MAX_FACE_LIKENESS and not cat.measure(blots).has_face
    good = astronaut.measure(load_style("engraving"))
    assert astronaut.measure(blots).face_outlines < 0.65 < good.face_outlines
    assert (
        astronaut.measure(blots).face_structure < 0.5 < astronaut.measure(load_style("poster")).face_structure
    )
    assert fault(good._replace(face=0.3)) == "with lost faces"
    assert fault(good._replace(face_outlines=0.6), "paper") == "with lost faces" != fault(good)


def test_faces_out_of_focus_are_not_compared() -> None:
    """Each style of them would count as blurred."""
    picture = cv2.resize(data.astronaut(), None, fx=2, fy=2, interpolation=cv2.INTER_AREA)
    assert FullSize(picture).measure(PLAIN).has_face
    soft = picture.copy()
    soft[:440, 300:660] = cv2.GaussianBlur(picture[:440, 300:660], (0, 0), 4)
    assert len(StillFaces().find("", lambda: soft).boxes) == 1
    assert not FullSize(soft).measure(PLAIN).has_face


def test_faces_larger_than_a_crop_are_compared() -> None:
    crop = data.astronaut()[:360, :480]
    assert ComparedCrop(crop, [Box(33, -95, 447, 455)]).has_faces
    assert not ComparedCrop(crop, [Box(300, 60, 680, 420)]).has_faces, "half of it is outside"


def test_a_part_that_is_smeared_is_seen() -> None:
    """Although the strong edges of the other part are kept."""
    leaves = cv2.GaussianBlur(np.random.default_rng(1).normal(110, 150, (360, 480)), (0, 0), 1.5)
    source = leaves.clip(0, 255).astype(np.uint8)[..., None].repeat(3, axis=2)
    source[:, :240:12] = 250
    smeared = source.copy()
    smeared[:, 240:] = cv2.GaussianBlur(source, (0, 0), 8)[:, 240:]
    compared = ComparedCrop(source, [])
    whole, part = compared.measure(source), compared.measure(smeared)
    assert whole.smeared == 0 and 0.25 < part.smeared < 0.5
    assert part.structure_kept < whole.structure_kept - 0.2 and part.detail_kept > 0.75


def test_flat_tones_are_concentrated() -> None:
    ramp = np.tile(np.linspace(0, 255, 480).astype(np.uint8), (360, 1))[..., None].repeat(3, axis=2)
    compared = ComparedCrop(ramp, [])
    assert compared.measure(ramp).tone_concentration < 0.25
    assert compared.measure(ramp // 64 * 64).tone_concentration == 1


def test_lengths_in_crops_are_those_in_the_whole_picture() -> None:
    """A picture that is twice as large has dots that are twice as large, also in its crops."""
    dots = styled(Step("halftone", {"cell": 12}))
    once, twice = (
        FullSize(cv2.resize(data.chelsea(), None, fx=factor, fy=factor)).measure(dots) for factor in (2, 4)
    )
    assert twice.fineness < once.fineness


def test_crops_have_the_level_of_detail_of_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """The level that its faces need, less where it is small."""
    monkeypatch.setattr(StillFaces, "find", lambda self, key, picture: KnownFaces(detail=1.5))
    dots, crops = styled(Step("halftone", {"cell": 12})), FullSize(data.chelsea()[:240])
    chosen = replace(dots, height=1.5 * dots.height * 240 / 480, keeps_detail=True)
    assert crops.measure(dots) == crops.measure(chosen) != crops.measure(replace(dots, keeps_detail=True))


def test_crops_are_parts_of_the_picture_that_people_get() -> None:
    """With the percentiles of the whole picture, and with its faces in focus."""
    picture = cv2.resize(data.astronaut(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    style = styled(Step("equalize"), Step("gaussian", {"sigma": 6}), Step("luma_posterize", {"levels": 5}))
    known = StillFaces().find("", lambda: picture)
    faces = comparable_faces(known, len(picture))
    assert faces and next(iter(faces)).height < 0.22 * len(picture)
    box = Box(300, 60, 780, 420)
    assert box.contains(next(iter(faces)))
    whole = restyle_picture(picture, style, known)[box.top : box.bottom, box.left : box.right]
    part = Crop(picture, box, faces, known.detail).render(
        style, tones_of(style, reduce_picture(picture, 320))
    )
    plain = Crop(picture, box, {}).render(style, tones_of(style, part))
    apart, other = (np.abs(whole.astype(int) - each).mean() for each in (part, plain))
    assert apart < 1.5 and other > 4 * apart


@pytest.mark.parametrize("shape", [(1, 1), (1, 400), (37, 5), (300, 410)])
def test_any_size_is_measured(shape: tuple[int, int]) -> None:
    picture = np.random.default_rng(1).integers(0, 255, (*shape, 3), np.uint8)
    assert np.isfinite(FullSize(picture).measure(load_style("poster"))).all()


def test_score_says_which_measures_speak_for_or_against(astronaut: FullSize) -> None:
    good = astronaut.measure(PLAIN)
    good = good._replace(tone_concentration=0.9)
    bad = good._replace(
        likeness=0.3, tone_concentration=0.2, structure_kept=0.2, smeared=0.8, face_structure=0.3, parts=-1.5
    )
    for rules in get_args(Rules):
        assert score(bad, rules) < score(good, rules)
        assert max(reasons(bad, rules).values()) < 0
        assert set(reasons(good, rules)) == set(MEASURES[rules]) < set(FullSizeMetrics._fields)
        assert verdict(bad, rules).startswith(f"Score {100 * score(bad, rules):.0f} of 100; against it: ")
        assert doubt(score(bad, rules), rules) == DOUBTFUL_FAULT and doubt(0.9, rules) == ""
    assert "face" in verdict(bad, "paper")
    assert "face" not in verdict(bad._replace(has_face=False), "paper")
    assert doubt(0.33) == DOUBTFUL_FAULT and doubt(0.33, "paper") == ""


def test_stretched_contrast_has_no_halos_and_bright_rims_have() -> None:
    leaves = cv2.GaussianBlur(np.random.default_rng(1).normal(0, 900, (360, 480)), (0, 0), 4)
    clear = np.clip(128 + leaves, 0, 255).astype(np.uint8)[..., None].repeat(3, axis=2)
    dark = ComparedCrop((20 + clear * 0.3).astype(np.uint8), [])
    assert abs(dark.measure(clear).halo) < 0.03
    edge = np.full((200, 200, 3), 90, np.uint8)
    edge[:, 100:] = 160
    rims = edge.copy()
    rims[:, 103:109] = 250
    assert ComparedCrop(edge, []).measure(rims).halo > 0.1


def test_a_style_that_is_too_large_for_the_picture_is_discarded(astronaut: FullSize) -> None:
    huge = styled(Step("scale", {"factor": 4}), Step("flow_dog"), Step("scale", {"factor": 4}))
    assert examine(Original(data.astronaut()), astronaut, huge).fault == UNUSABLE_FAULT


def test_random_styles_have_scores_between_0_and_1(cat: FullSize) -> None:
    scores = []
    for seed in range(6):
        # Some are too large for a small picture.
        with suppress(StyleError):
            scores.append(score(cat.measure(random_style(seed))))
    assert len(scores) >= 4 and all(0 <= each <= 1 for each in scores)
