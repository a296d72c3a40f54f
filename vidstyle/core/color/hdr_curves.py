"""HDR transfer functions, and the tones and colours that a style sees of an HDR picture.

A style works on SDR: BT.709 primaries, diffuse white is 1 and black 0, on the gamma of a BT.1886 display.
So its colours and thresholds have the usual meaning. Light above diffuse white is brought into 1..1.5 by a
logarithm, and colours outside BT.709 have negative parts, so that a style that keeps tones keeps both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vidstyle.core.kernels import compiled, index_at, interleaved
from vidstyle.core.picture import Encoding, Transfer

REFERENCE_WHITE_NITS = 203.0
"""Diffuse white of HDR in cd/m2 (ITU-R BT.2408), which becomes SDR white."""
HLG_PEAK_NITS = 1000.0
HLG_GAMMA = 1.2
"""The system gamma of HLG on a display of 1000 cd/m2 (ITU-R BT.2100, table 5)."""
HLG_WHITE_RATIO = REFERENCE_WHITE_NITS / HLG_PEAK_NITS
"""Diffuse white on that display, 0..1."""
SDR_GAMMA = 2.4
"""Gamma of the reference display for BT.709 (ITU-R BT.1886, black at zero)."""
HIGHLIGHT_SCALE = 0.13
"""Above diffuse white, tones x become 1 + s log(1 + (x - 1) / s): 1.45 at 10,000 cd/m2, within `RANGES`."""
MAX_SIGNALS: dict[Transfer, float] = {"sdr": 1.5, "pq": 1.0, "hlg": 1.1}
"""The largest values of the tables: SDR tones above white, and codes of HLG, which go to 1.09."""
MAX_LIGHT_ROOT = 2.7
"""The fourth root of 10,000 cd/m2 in units of diffuse white, and a little more."""
TABLE_SIZE = 4096
"""Entries of a table. Interpolation keeps dark parts of bright colours, which are small differences."""
BT2020_TO_BT709_MATRIX = np.array(
    [[1.660491, -0.587641, -0.072850], [-0.124550, 1.132900, -0.008349], [-0.018151, -0.100579, 1.118730]],
    np.float32,
)
"""Conversion of linear light (ITU-R BT.2407, section 2)."""

_PQ_M1_EXPONENT, _PQ_M2_EXPONENT = 2610 / 16384, 2523 / 4096 * 128
_PQ_C1_COEFFICIENT, _PQ_C2_COEFFICIENT, _PQ_C3_COEFFICIENT = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
_HLG_A_COEFFICIENT, _HLG_B_COEFFICIENT, _HLG_C_COEFFICIENT = 0.17883277, 0.28466892, 0.55991073


def pq_to_nits(signal: np.ndarray) -> np.ndarray:
    """Return the light of a PQ signal 0..1 in cd/m2 (SMPTE ST 2084)."""
    power = np.asarray(signal, np.float64) ** (1 / _PQ_M2_EXPONENT)
    return 10000 * (
        np.maximum(power - _PQ_C1_COEFFICIENT, 0) / (_PQ_C2_COEFFICIENT - _PQ_C3_COEFFICIENT * power)
    ) ** (1 / _PQ_M1_EXPONENT)


def nits_to_pq(nits: np.ndarray) -> np.ndarray:
    """Return the PQ signal 0..1 of light in cd/m2 (SMPTE ST 2084)."""
    power = np.clip(np.asarray(nits, np.float64) / 10000, 0, 1) ** _PQ_M1_EXPONENT
    return (
        (_PQ_C1_COEFFICIENT + _PQ_C2_COEFFICIENT * power) / (1 + _PQ_C3_COEFFICIENT * power)
    ) ** _PQ_M2_EXPONENT


def hlg_to_scene(signal: np.ndarray) -> np.ndarray:
    """Return the scene light of an HLG signal, both 0..1 (ITU-R BT.2100)."""
    signal = np.asarray(signal, np.float64)
    return np.where(
        signal <= 0.5,
        signal**2 / 3,
        (np.exp((signal - _HLG_C_COEFFICIENT) / _HLG_A_COEFFICIENT) + _HLG_B_COEFFICIENT) / 12,
    )


def scene_to_hlg(scene: np.ndarray) -> np.ndarray:
    """Return the HLG signal of scene light, both 0..1 (ITU-R BT.2100)."""
    scene = np.asarray(scene, np.float64)
    bright = np.maximum(12 * scene - _HLG_B_COEFFICIENT, 1e-9)
    return np.where(
        scene <= 1 / 12, np.sqrt(3 * scene), _HLG_A_COEFFICIENT * np.log(bright) + _HLG_C_COEFFICIENT
    )


def signal_to_light(signal: np.ndarray, transfer: Transfer) -> np.ndarray:
    """Return the light of a signal or of an SDR tone in units of diffuse white; of HLG, the scene's light."""
    signal = np.maximum(signal, 0)
    if transfer == "pq":
        return pq_to_nits(np.minimum(signal, 1)) / REFERENCE_WHITE_NITS
    if transfer == "hlg":
        return hlg_to_scene(signal) / HLG_WHITE_RATIO
    highlight = HIGHLIGHT_SCALE * np.expm1(np.maximum(signal - 1, 0) / HIGHLIGHT_SCALE)
    return (np.minimum(signal, 1) + highlight) ** SDR_GAMMA


def light_to_signal(light: np.ndarray, transfer: Transfer) -> np.ndarray:
    """Return the signal or the SDR tone of light; the inverse of `signal_to_light`."""
    light = np.maximum(light, 0)
    if transfer == "pq":
        return nits_to_pq(light * REFERENCE_WHITE_NITS)
    if transfer == "hlg":
        return np.minimum(scene_to_hlg(light * HLG_WHITE_RATIO), MAX_SIGNALS["hlg"])
    tone = light ** (1 / SDR_GAMMA)
    return np.minimum(tone, 1) + HIGHLIGHT_SCALE * np.log1p(np.maximum(tone - 1, 0) / HIGHLIGHT_SCALE)


def diffuse_white(transfer: Transfer) -> float:
    """Return the signal of diffuse white.

    >>> diffuse_white("sdr"), round(diffuse_white("pq"), 2)
    (1.0, 0.58)
    """
    scene = HLG_WHITE_RATIO ** (1 / HLG_GAMMA - 1) if transfer == "hlg" else 1.0
    return float(light_to_signal(np.array(scene), transfer))


@dataclass(frozen=True)
class LightConversion:
    """Converts RGB between transfer functions and primaries, through light.

    Attributes:
        light: light at equal steps of a signal from 0 to `top`; float32.
        gamut: 3 x 3 matrix for light; float32.
        signal: signal at equal steps of the fourth root of light from 0 to `MAX_LIGHT_ROOT`; float32.
        exponents: of the luminance, by whose powers light is multiplied before and after the gamut: HLG's
            system gamma, which turns the scene's light into a display's, or the inverse.
    """

    light: np.ndarray
    top: float
    gamut: np.ndarray
    signal: np.ndarray
    exponents: tuple[float, float]

    def apply(self, color: np.ndarray) -> np.ndarray:
        """Return the converted RGB, H x W x 3 float32; negative values are mirrored, large ones clipped."""
        out = np.empty(color.shape, np.float32)
        last = TABLE_SIZE - 1
        steps = np.float32(last / self.top), np.float32(last / MAX_LIGHT_ROOT)
        exponents = np.array(self.exponents, np.float32)
        _convert(interleaved(color), self.light, self.gamut, self.signal, steps, exponents, interleaved(out))
        return out


def light_conversion(old: Encoding, new: Encoding) -> LightConversion | None:
    """Return the conversion of RGB between encodings; None if they have one transfer function."""
    if old.transfer == new.transfer:
        return None
    return _conversion(old.transfer, _has_wide_primaries(old), new.transfer, _has_wide_primaries(new))


def _has_wide_primaries(encoding: Encoding) -> bool:
    """Whether the encoding has BT.2020 primaries, which only HDR uses here."""
    return encoding.is_hdr and encoding.matrix == "bt2020"


@lru_cache(maxsize=16)
def _conversion(old: Transfer, is_wide: bool, new: Transfer, becomes_wide: bool) -> LightConversion:
    signal, root = (np.linspace(0, top, TABLE_SIZE) for top in (MAX_SIGNALS[old], MAX_LIGHT_ROOT))
    gamut = np.eye(3, dtype=np.float32)
    if is_wide != becomes_wide:
        narrowing = BT2020_TO_BT709_MATRIX.astype(np.float64)
        gamut = (narrowing if is_wide else np.linalg.inv(narrowing)).astype(np.float32)
    return LightConversion(
        signal_to_light(signal, old).astype(np.float32),
        MAX_SIGNALS[old],
        gamut,
        light_to_signal(root**4, new).astype(np.float32),
        (HLG_GAMMA - 1 if old == "hlg" else 0.0, 1 / HLG_GAMMA - 1 if new == "hlg" else 0.0),
    )


@compiled(fastmath=True)
def _convert(values, light, gamut, signal, steps, exponents, out):  # type: ignore[no-untyped-def]
    for row in range(values.shape[0]):
        for x in range(0, values.shape[1], 3):
            red = _look_up(light, values[row, x], steps[0])
            green = _look_up(light, values[row, x + 1], steps[0])
            blue = _look_up(light, values[row, x + 2], steps[0])
            factor = _system_factor(red, green, blue, exponents[0])
            red, green, blue = red * factor, green * factor, blue * factor
            new_red = gamut[0, 0] * red + gamut[0, 1] * green + gamut[0, 2] * blue
            new_green = gamut[1, 0] * red + gamut[1, 1] * green + gamut[1, 2] * blue
            new_blue = gamut[2, 0] * red + gamut[2, 1] * green + gamut[2, 2] * blue
            factor = _system_factor(new_red, new_green, new_blue, exponents[1])
            out[row, x] = _look_up(signal, _fourth_root(new_red * factor), steps[1])
            out[row, x + 1] = _look_up(signal, _fourth_root(new_green * factor), steps[1])
            out[row, x + 2] = _look_up(signal, _fourth_root(new_blue * factor), steps[1])


@compiled(fastmath=True)
def _system_factor(red, green, blue, exponent):  # type: ignore[no-untyped-def]
    """Return the factor of HLG's system gamma for light in units of diffuse white, with BT.2020 primaries."""
    if exponent == 0:
        return np.float32(1)
    luminance = np.float32(0.2627) * red + np.float32(0.6780) * green + np.float32(0.0593) * blue
    return np.float32(max(luminance * np.float32(HLG_WHITE_RATIO), np.float32(1e-9)) ** exponent)


@compiled(fastmath=True)
def _fourth_root(light):  # type: ignore[no-untyped-def]
    return np.float32(math.copysign(math.sqrt(math.sqrt(abs(light))), light))


@compiled(fastmath=True)
def _look_up(table, value, step):  # type: ignore[no-untyped-def]
    """Interpolate between two entries; the result has the sign of the value."""
    last = np.int32(table.size - 1)
    place = min(abs(value) * step, np.float32(last))
    index = index_at(place, last - 1)
    found = table[index] + (place - np.float32(index)) * (table[index + 1] - table[index])
    return found if value >= 0 else -found
