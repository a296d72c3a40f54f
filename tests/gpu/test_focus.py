"""Focus on a GPU agrees with the CPU."""

from __future__ import annotations

import numpy as np
import pytest
from gpu import AGREEMENT
from pictures import film_with_face, picture_with_face

from vidstyle.renderer import Renderer, stylize
from vidstyle.style import load_style


@pytest.mark.parametrize("name", ["comic", "oil", "charcoal"])
def test_faces_agree(name: str) -> None:
    style = load_style(name)
    one, other = (stylize(picture_with_face(), style, device).astype(int) for device in ("cpu", "gpu"))
    assert np.mean(np.abs(one - other) <= 1) >= AGREEMENT


def test_faces_of_a_film_agree() -> None:
    """Also when the window of a face changes."""
    frames = film_with_face(lambda number: 100 + 21 * number, 4)
    results = []
    for device in ("cpu", "gpu"):
        with Renderer("ink", device) as renderer:
            results.append([renderer(picture.color, time).astype(int) for picture, time in frames])
    assert np.mean(np.abs(np.array(results[0]) - results[1]) <= 1) >= AGREEMENT
