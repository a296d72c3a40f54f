"""Noise and JPEG blocks of a single picture are removed; films and clean pictures stay unchanged."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from films import noisy, page, picture, still_film
from media import photograph
from pictures import style

from vidstyle.backend import FrameRequest
from vidstyle.core.bands import BandWorkers, CallingThread
from vidstyle.core.picture import Encoding, Picture
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.pipeline.render import render
from vidstyle.renderer import open_renderer, stylize
from vidstyle.stabilize.still import MARGIN_PX, cleaned, flatten_still
from vidstyle.stabilize.still_noise import measure_still

DEVIATION = 8
"""Standard deviation of the noise of a phone's picture of a dim room, in codes."""


def step_edge(deviation: float) -> np.ndarray:
    """Codes of a dark and a bright half, H x W x 3."""
    codes = np.full((120, 160, 3), 128.0, np.float32)
    codes[:, :80, 0], codes[:, 80:, 0] = 70, 170
    return noisy(codes, deviation, 1)


def flattened(dirty: Picture, steady: float = 1) -> Picture:
    return flatten_still(FrameRequest(dirty), steady).picture


def flat(planes: np.ndarray) -> np.ndarray:
    luma = flattened(picture(planes)).luma
    assert luma is not None
    return luma.astype(np.float64)


def test_noise_goes_and_an_edge_stays() -> None:
    luma = flat(step_edge(DEVIATION))
    assert luma[10:-10, 10:70].std() < DEVIATION / 5
    assert luma[10:-10, 80].mean() - luma[10:-10, 79].mean() > 85


@pytest.mark.parametrize("blur", [0.5, 0.7, 0.8])
def test_smoothed_noise_of_a_camera_goes(blur: float) -> None:
    """It is fainter in the finest detail than noise that is different in each pixel."""
    grain = cv2.GaussianBlur(noisy(np.zeros((240, 320, 3)), 1, 1), (0, 0), blur)
    grain *= DEVIATION / grain.std()
    whole = Picture.from_array(np.clip(128 + grain, 0, 255).astype(np.uint8))
    color = flattened(whole).color
    assert color is not None and color[10:-10, 10:-10].std() < DEVIATION / 3


def test_noise_counts_by_the_contrast_that_styles_stretch() -> None:
    """Faint noise goes from a dim picture, and stays in a bright one."""
    ramp = np.repeat(np.linspace(0, 1, 160, dtype=np.float32)[None, :, None], 120, axis=0)
    for contrast, goes in ((60, True), (240, False)):
        planes = np.concatenate([8 + contrast * ramp, np.full((120, 160, 2), 128, np.float32)], axis=2)
        dirty = picture(noisy(planes, 1.8, 1))
        assert (flattened(dirty) is not dirty) == goes


def test_features_remain() -> None:
    """A photograph is nearer to the one without noise than before."""
    clean = page(180, 320)[..., 0]
    dirty = noisy(page(180, 320), DEVIATION, 1)
    assert np.abs(flat(dirty) - clean).mean() < 0.62 * np.abs(dirty[..., 0] - clean).mean()


def test_dark_areas_may_have_more_noise() -> None:
    """As in underexposed pictures: one limit for both would leave noise in the dark, or blur the bright."""
    codes = np.full((240, 320, 3), 128.0, np.float32)
    codes[:, :160, 0], codes[:, 160:, 0] = 50, 170
    codes[8::16, :, 0] += 24
    dirty = noisy(codes, 2, 1)
    dirty[:, :160] = noisy(codes, 5, 1)[:, :160]
    error = np.abs(flat(dirty) - codes[..., 0])
    assert error[:, 8:152].mean() < 1.5 and error[:, 168:-8].mean() < 0.7


def jpeg(color: np.ndarray, quality: int) -> np.ndarray:
    _, data = cv2.imencode(".jpg", color[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    return cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1]


def seams(color: np.ndarray, corner: int) -> float:
    """How much neighbours differ more where JPEG's blocks meet than elsewhere."""
    steps = np.abs(np.diff(color[..., 1].astype(np.float32), axis=1)).mean(axis=0)
    places = (np.arange(steps.size) + 1) % 8 == corner
    return float(steps[places].mean() / steps[~places].mean()) - 1


@pytest.mark.parametrize("name, crop", [("astronaut", 0), ("coffee", 3)])
def test_jpeg_blocks_go(name: str, crop: int) -> None:
    """Also from a crop, in which they begin at another place; detail is nearer to the original."""
    clean = photograph(name)[crop:, crop:]
    blocky = jpeg(photograph(name), 25)[crop:, crop:]
    made = flattened(Picture.from_array(np.ascontiguousarray(blocky))).color
    assert made is not None
    corner = -crop % 8
    assert abs(seams(made, corner)) < 0.25 * seams(blocky, corner)
    assert (
        np.square(made - clean.astype(float)).mean() < 0.93 * np.square(blocky - clean.astype(float)).mean()
    )


@pytest.mark.parametrize("quality", [70, 95])
def test_jpeg_of_usual_quality_is_the_same(quality: int) -> None:
    fine = Picture.from_array(jpeg(photograph("astronaut"), quality))
    assert flattened(fine) is fine


def test_bands_equal_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vidstyle.stabilize.still.shared_workers", lambda: BandWorkers(CallingThread(), 4))
    whole = Picture.from_array(
        cv2.resize(noisy(photograph("rocket"), 9, 1), (90, 1300)).clip(0, 255).astype(np.uint8)
    )
    noise = measure_still(whole)
    assert whole.color is not None and noise.planes
    part = replace(whole, color=whole.color[:900])
    made, above = cleaned(whole, noise).color, cleaned(part, noise).color
    assert made is not None and above is not None
    assert np.abs(made[: 900 - MARGIN_PX].astype(int) - above[: 900 - MARGIN_PX]).max() <= 1


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (17, 23), (63, 41)])
@pytest.mark.parametrize("subsampling", [(1, 1), (2, 2), (4, 1)])
def test_any_size_and_subsampling(shape: tuple[int, int], subsampling: tuple[int, int]) -> None:
    dirty = picture(noisy(np.full((*shape, 3), 120.0), DEVIATION, 1), Encoding(subsampling=subsampling))
    made = flattened(dirty)
    assert made.luma is not None and made.chroma is not None and dirty.chroma is not None
    assert made.luma.shape == shape and made.chroma[0].shape == dirty.chroma[0].shape
    if min(shape) > 40:
        assert made.luma.std() < DEVIATION / 4 and made.chroma[1].std() < DEVIATION / 3


@pytest.mark.parametrize("name", ["astronaut", "coffee", "rocket"])
def test_clean_photograph_is_the_same(name: str) -> None:
    clean = Picture.from_array(photograph(name))
    assert flattened(clean) is clean


def test_steady_0_keeps_the_noise() -> None:
    (dirty,) = still_film(1, DEVIATION)
    assert flattened(dirty, 0) is dirty


@pytest.mark.parametrize("time", [0.0, None])
def test_only_a_picture_without_a_time_is_flattened(time: float | None) -> None:
    (dirty,) = still_film(1, DEVIATION)
    with closing(open_renderer(style(steady=1), "cpu")) as renderer:
        luma = renderer.run(dirty, time).luma
    assert luma is not None and dirty.luma is not None
    assert np.array_equal(luma, dirty.luma) == (time is not None)


@pytest.mark.parametrize("depth", [0, 8, 10, 16])
@pytest.mark.parametrize("full_range", [False, True])
def test_every_depth_is_flattened_alike(depth: int, full_range: bool) -> None:
    encoding = Encoding(full_range=full_range, depth=depth, subsampling=(1, 1))
    black, white = encoding.luma_levels
    codes = black + (white - black) * (noisy(np.full((90, 90, 1), 128.0), DEVIATION, 1)[..., 0] / 255)
    codes = codes.astype(encoding.dtype)
    luma = flattened(Picture(encoding, luma=codes)).luma
    assert luma is not None and luma.dtype == codes.dtype
    assert (luma / (white - black)).std() < DEVIATION / 255 / 5


def test_alpha_is_kept() -> None:
    random = np.random.default_rng(1)
    dirty = np.clip(random.normal(128, DEVIATION, (60, 60, 4)), 0, 255).astype(np.uint8)
    alpha = flattened(Picture.from_array(dirty)).alpha
    assert alpha is not None and np.array_equal(np.squeeze(alpha), dirty[..., 3])


def test_render_treats_one_picture_as_a_still(tmp_path: Path) -> None:
    """As `stylize` does, which has no time, and the gallery."""
    random = np.random.default_rng(1)
    dirty = np.clip(random.normal(128, DEVIATION, (64, 96, 3)), 0, 255).astype(np.uint8)
    chosen = style(steady=1)
    cv2.imwrite(str(tmp_path / "in.png"), dirty)
    render(tmp_path / "in.png", tmp_path / "out.png", chosen, device="cpu")
    made = cv2.imread(str(tmp_path / "out.png"))
    assert made.std() < DEVIATION / 3
    assert np.array_equal(made, stylize(dirty[..., ::-1], chosen, device="cpu")[..., ::-1])
    assert np.array_equal(made, restyle_picture(dirty[..., ::-1], chosen)[..., ::-1])
