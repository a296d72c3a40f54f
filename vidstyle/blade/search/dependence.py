"""Tests what the result of a reference filter depends on, to explain what a bank cannot reproduce."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.blade.bank import FILTER_SIZES, Bank
from vidstyle.blade.photographs import Photograph, chroma_of, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter

TEST_SIDE_PX = 192
"""Maximum side of the part of a photograph that is tested, in pixels."""
MAX_TEST_PICTURES = 2
"""Maximum number of photographs on which a filter is tested: one alone may lack what it depends on."""
MIN_SHARE = 0.02
"""Differences below this share of the filter's change are ignored."""
FAR_PX = 48
"""Distance from which a change of the picture is far away; no bank reaches so far at full size."""
BORDER_PX = 24
"""Width of the border that is ignored where the test moves pixels over it."""
MOVE_PX = 47, 43
"""Rows and columns by which the picture is moved: primes, thus no multiples of the period of a pattern."""
MIN_AMPLIFICATION = 4
"""Factor of the energy of noise above which its effect is not only rounding."""
FLAT_LEVELS = 2 / 255
"""Maximum difference between pixels of a result that counts as flat."""


@dataclass(frozen=True)
class Dependence:
    """What a filter's luma depends on; each number is a share of its squared change.

    Attributes:
        randomness: the difference of two runs.
        position: the difference after moving the picture.
        direction: the difference after rotating the picture by 90 degrees.
        instability: the difference after adding noise of one level of 255, less its linear part.
        far: the mean difference more than `FAR_PX` from a change of the picture.
        color: the difference after removing the colour of the picture.
        chroma: the change of the chroma planes; 0 for a filter that returns luma only.
        draws: whether the result of a flat picture is not flat.
        by_distance: the difference at 1, 2, 3 and more pixels from a change of the picture.
    """

    randomness: float
    position: float
    direction: float
    instability: float
    far: float
    color: float
    chroma: float
    draws: bool
    by_distance: tuple[float, ...]

    @property
    def reach(self) -> int:
        """Return the greatest distance in pixels at which a change of the picture changes the result."""
        reached = [number for number, share in enumerate(self.by_distance, 1) if share >= MIN_SHARE]
        return reached[-1] if reached else 0

    def reasons(self, bank: Bank, unexplained: float, layouts: int = 1) -> Iterator[str]:
        """Yield what a bank cannot reproduce.

        Args:
            unexplained: the share of the change that the bank does not reproduce.
            layouts: number of layouts of bins that were tried.
        """
        if self.randomness >= MIN_SHARE:
            yield f"is random (two runs differ by {self.randomness:.0%} of the change)"
            return  # other tests would find the same difference
        if self.far >= MIN_SHARE:
            part = "" if bank.curve is None else ", of which a bank has only percentiles"
            yield f"is not local (a change more than {FAR_PX} px away changes the result){part}"
        elif self.position >= MIN_SHARE:
            yield f"depends on the position in the picture ({self.position:.0%} of the change)"
        elif self.direction >= MIN_SHARE:
            yield f"prefers a direction ({self.direction:.0%} of the change differ in a rotated picture)"
        if self.draws:
            yield "draws on flat areas"
        if self.instability >= MIN_SHARE:
            part = f"{self.instability:.0%} of the change"
            yield f"reacts to noise of one level ({part}), which a bank averages"
        by_color = self.color - self.instability  # a gray copy also differs by rounding
        if by_color >= max(MIN_SHARE, self.instability / 2):
            missing = "which luma lacks" if bank.matrix is None else "of which a bank has only a matrix"
            yield f"depends on colour ({by_color:.0%} of the change of luma), {missing}"
        before = 0 if bank.mode is None else int(bank.mode[0])
        if self.far < MIN_SHARE and (self.reach - before) * bank.scale > bank.size // 2:
            yield f"depends on pixels up to {self.reach} px away ({_larger(self.reach - before, bank)})"
        beyond = max(self.by_distance[before + round(bank.size // 2 / bank.scale) :], default=0.0)
        found = self.far, self.position, self.direction, self.color, self.instability, beyond
        if max(found) < unexplained / 2:
            yield f"depends on details within {max(self.reach, 1)} px that {_undistinguished(layouts)}"
        if self.chroma >= MIN_SHARE and bank.chroma is None:
            yield "also changes colour (add --chroma)"


def _undistinguished(layouts: int) -> str:
    """Return which bins do not distinguish details, and what to do if others may."""
    if layouts == 1:
        return "these bins do not distinguish (try --bins auto)"
    return f"no layout of bins distinguishes ({layouts} tried)"


def _larger(reach: int, bank: Bank) -> str:
    """Return how far filters reach, and what makes them reach `reach` pixels."""
    text, largest = f"filters reach {round(bank.size // 2 / bank.scale)} px", FILTER_SIZES[-1]
    if bank.size < largest:
        return f"{text}; try --size {min(max(2 * round(reach * bank.scale) + 1, bank.size + 2), largest)}"
    return f"{text}; try --scale {bank.scale / 2:g}"


def find_dependence(reference: ReferenceFilter, photographs: Sequence[Photograph]) -> Dependence:
    """Run a filter on parts of some photographs and on changed copies of them.

    Returns:
        The shares of the change of all tested parts, so that a part without details has little weight.

    Raises:
        InputError: a picture cannot be read, or the filter fails.
    """
    tested = photographs[:: max(1, -(-len(photographs) // MAX_TEST_PICTURES))]
    changes, found = zip(*(_test(reference, each) for each in tested), strict=True)

    def mean(values: Iterable[float]) -> float:
        return float(np.average(list(values), weights=changes))

    names = ("randomness", "position", "direction", "instability", "far", "color", "chroma")
    return Dependence(
        **{name: mean(getattr(each, name) for each in found) for name in names},
        draws=any(each.draws for each in found),
        by_distance=tuple(map(mean, zip(*(each.by_distance for each in found), strict=False))),
    )


def _test(reference: ReferenceFilter, photograph: Photograph) -> tuple[float, Dependence]:
    """Return the change of the middle of a photograph by a filter, and on what it depends."""
    color = _middle(photograph.color())

    def apply(picture: np.ndarray) -> np.ndarray:
        return reference.apply(np.ascontiguousarray(picture, np.float32), photograph)[0]

    result, luma = apply(color), luma_of(color)
    plain = luma_of(result)
    change = max(_square(plain - luma), 1e-9)
    profile = _profile(color, plain, apply) / change
    gray = np.repeat(luma[..., None], 3, axis=2)
    flat = luma_of(apply(np.full_like(color, 0.5)))
    return change, Dependence(
        randomness=_square(luma_of(apply(color)) - plain) / change,
        position=_square(_moved(color, plain, apply)) / change,
        direction=_square(_inside(luma_of(apply(np.rot90(color))) - np.rot90(plain))) / change,
        instability=_instability(color, plain, apply) / change,
        far=float(profile[min(FAR_PX, len(profile) - 1) :].mean()),
        color=_square(luma_of(apply(gray)) - plain) / change,
        chroma=_chroma_change(color, result) / change,
        draws=float(np.ptp(_inside(flat))) > FLAT_LEVELS,
        by_distance=tuple(map(float, profile)),
    )


def changes_color(reference: ReferenceFilter, photograph: Photograph) -> bool:
    """Whether a filter changes the chroma of a part of a photograph.

    Raises:
        InputError: the picture cannot be read, or the filter fails.
    """
    color = np.ascontiguousarray(_middle(photograph.color()), np.float32)
    result = reference.apply(color, photograph)[0]
    change = max(_square(luma_of(result) - luma_of(color)), 1e-9)
    return _chroma_change(color, result) / change >= MIN_SHARE


def _chroma_change(color: np.ndarray, result: np.ndarray) -> float:
    """Return the squared change of both chroma planes; 0 for a result that is luma only."""
    if result.ndim == 2:
        return 0.0
    return sum(_square(new - old) for new, old in zip(chroma_of(result), chroma_of(color), strict=True))


def _middle(color: np.ndarray) -> np.ndarray:
    """Return the middle of a picture."""
    top, left = (max(side - TEST_SIDE_PX, 0) // 2 for side in color.shape[:2])
    return color[top : top + TEST_SIDE_PX, left : left + TEST_SIDE_PX]


def _profile(color: np.ndarray, plain: np.ndarray, apply: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Return the mean squared difference by distance from the left half, after changing that half."""
    middle = color.shape[1] // 2
    changed = color.copy()
    changed[:, :middle] = 1 - color[::-1, middle - 1 :: -1]
    difference = luma_of(apply(changed)) - plain
    return np.square(difference[:, middle:], dtype=np.float64).mean(axis=0)


def _instability(color: np.ndarray, plain: np.ndarray, apply: Callable[[np.ndarray], np.ndarray]) -> float:
    """Return the squared difference after adding noise of -1, 0 or 1 level, or 0 for little amplification.

    A filter that sharpens amplifies noise linearly, as a bank does. Therefore only the effect that noise and
    its negative have in common is measured. If the three results differ at random, a third of its square is
    the mean squared difference of two of them.
    """
    noise = np.random.default_rng(1).integers(-1, 2, (*plain.shape, 1)).astype(np.float32) / 255
    more, less = (luma_of(apply(np.clip(color + each, 0, 1))) for each in (noise, -noise))
    square = _square(more + less - 2 * plain) / 3
    return square if square > MIN_AMPLIFICATION * _square(noise) else 0.0


def _moved(color: np.ndarray, plain: np.ndarray, apply: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Return the difference between the result of a moved picture and the moved result, without the seam."""
    rows, columns = (min(most, side // 4) for most, side in zip(MOVE_PX, plain.shape, strict=True))
    moved = luma_of(apply(np.roll(color, (rows, columns), (0, 1))))
    return _inside((moved - np.roll(plain, (rows, columns), (0, 1)))[rows:, columns:])


def _inside(plane: np.ndarray) -> np.ndarray:
    """Return a plane without its border, or its middle if it is small."""
    rows, columns = (min(BORDER_PX, side // 4) for side in plane.shape)
    return plane[rows : plane.shape[0] - rows, columns : plane.shape[1] - columns]


def _square(plane: np.ndarray) -> float:
    return float(np.square(plane, dtype=np.float64).mean())
