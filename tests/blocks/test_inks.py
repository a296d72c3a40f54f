"""`separate` and `overprint`: spot inks that print a picture."""

from __future__ import annotations

import numpy as np
import pytest
from media import photograph
from pictures import run_color, step, style

INKS = {"first": "#ffe14d", "second": "#ff48a0", "third": "#0f5fb0"}


def absorbed() -> np.ndarray:
    """Return the share of red, green and blue that each ink absorbs, 3 x 3."""
    return 1 - np.array([[int(text[i : i + 2], 16) for i in (1, 3, 5)] for text in INKS.values()]) / 255


def printed(amounts: np.ndarray) -> np.ndarray:
    return np.prod(1 - amounts[..., :, None] * absorbed(), axis=-2)


def separated(color: np.ndarray) -> np.ndarray:
    return 1 - run_color(style(step("separate", **INKS)), color.astype(np.float32)).astype(np.float64)


def test_overprint_multiplies_the_light_of_the_inks() -> None:
    amounts = np.random.default_rng(1).random((20, 30, 3))
    got = run_color(style(step("overprint", **INKS)), (1 - amounts).astype(np.float32))
    np.testing.assert_allclose(got, printed(amounts), atol=1e-6)


def test_printable_colors_are_printed_exactly() -> None:
    amounts = np.random.default_rng(2).random((20, 30, 3))
    found = printed(separated(printed(amounts)))
    assert np.abs(found - printed(amounts)).mean() < 0.004


def test_no_grid_of_amounts_prints_a_photograph_better() -> None:
    """Against a search of all amounts in steps of a tenth."""
    color = photograph("astronaut")[::16, ::16].astype(np.float64) / 255
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 11)] * 3), -1).reshape(-1, 3)
    best = ((printed(grid) - color[..., None, :]) ** 2).sum(-1).min(-1)
    error = ((printed(separated(color)) - color) ** 2).sum(-1)
    assert error.mean() < best.mean()
    assert np.sqrt(error).max() < np.sqrt(best).max() + 0.05


@pytest.mark.parametrize("ink", range(3))
def test_an_ink_is_its_own_plate(ink: int) -> None:
    color = np.broadcast_to(1 - absorbed()[ink], (4, 5, 3))
    assert np.abs(separated(color) - np.eye(3)[ink]).max() < 0.02
