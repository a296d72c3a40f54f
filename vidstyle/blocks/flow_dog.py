"""Flow difference of Gaussians: the input of XDoG's threshold."""

from __future__ import annotations

from bisect import bisect_right
from typing import Annotated

from vidstyle.blade.bank_file import shipped_bank, shipped_parts
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, block


@block(
    "learned",
    on="luma",
    label="Sharpen along lines",
    category="lines",
    aliases="difference of gaussians, edges, ink, pen, drawing, sketch, contour, outline, sharp",
)
def flow_dog(
    sigma: Annotated[
        float,
        Slider(0.5, 24, "width of the lines", "px", explore=(0.5, 8), label="Line width", max_detail=1.5),
    ] = 1.4,
    p: Annotated[
        float,
        Slider(
            0, 60, "more for stronger lines, also along faint edges", explore=(1, 40), label="Line strength"
        ),
    ] = 20,
) -> BankRun:
    """Strengthen lines and outlines, and smooth along them.

    Sharpens across the edges: a difference of Gaussians along the flow of edges. Learned. (1 + p) G - p
    G', with Gaussians of sigma and 1.6 sigma across the edge, then one of 1.5 sigma along it. The result
    exceeds black and white. Paper, section 4.2 C, which prints the two Gaussians in reverse order;
    Winnemoeller, Kyprianidis and Olsen 2012. Above 1 px it runs on a reduced picture and uses the
    directions of that picture; between the learned sigmas, filters are interpolated by variance. Filters
    are selected by the orientation and curvature of lines, not by strength and coherence.
    """
    name = "flow_dog_fine" if sigma <= 1 else "flow_dog"
    learned = shipped_bank(name).about["sigmas"]
    first = min(bisect_right(learned, sigma), len(learned) - 1) - 1
    near, far = (_blur(learned[number]) for number in (first, first + 1))
    share = min((_blur(sigma) - near) / (far - near), 1.0)
    weights = [weight for part in (1 - share, share) if part > 0 for weight in (part, part * p)]
    first += share == 1
    bank = shipped_parts(name, 2 * first, 2 * first + len(weights))
    return BankRun(bank, tuple(weights), scale=min(1 / sigma, 1), is_wide=True)


def _blur(sigma: float) -> float:
    """Return what filters depend on linearly: the variance, and from 1 px on the blur of the reduction."""
    return sigma**2 if sigma < 1 else 2 - sigma**-2
