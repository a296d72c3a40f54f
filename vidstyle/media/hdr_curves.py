"""The curves of HDR light, in closed form, as NumPy functions of arrays."""

from __future__ import annotations

import numpy as np

REFERENCE_WHITE = 203.0
"""Candela per square metre of diffuse white in HDR (ITU-R BT.2408); it becomes the white of SDR."""
HLG_PEAK = 1000.0
HLG_GAMMA = 1.2
"""The system gamma of HLG on a display of 1000 cd/m2 (ITU-R BT.2100, table 5)."""
SDR_GAMMA = 2.4
"""Of the reference display for BT.709 (ITU-R BT.1886, black at zero)."""

_M1, _M2 = 2610 / 16384, 2523 / 4096 * 128
_C1, _C2, _C3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
_A, _B, _C = 0.17883277, 0.28466892, 0.55991073


def pq_to_nits(signal: np.ndarray) -> np.ndarray:
    """SMPTE ST 2084: the light of a signal 0..1, in cd/m2."""
    power = np.asarray(signal, np.float64) ** (1 / _M2)
    return 10000 * (np.maximum(power - _C1, 0) / (_C2 - _C3 * power)) ** (1 / _M1)


def nits_to_pq(nits: np.ndarray) -> np.ndarray:
    """SMPTE ST 2084: the signal 0..1 of a light in cd/m2."""
    power = np.clip(np.asarray(nits, np.float64) / 10000, 0, 1) ** _M1
    return ((_C1 + _C2 * power) / (1 + _C3 * power)) ** _M2


def hlg_to_scene(signal: np.ndarray) -> np.ndarray:
    """ITU-R BT.2100: the light of the scene, 0..1, of an HLG signal 0..1."""
    signal = np.asarray(signal, np.float64)
    return np.where(signal <= 0.5, signal**2 / 3, (np.exp((signal - _C) / _A) + _B) / 12)


def compressed_nits(nits: np.ndarray, peak: float, target: float = REFERENCE_WHITE) -> np.ndarray:
    """ITU-R BT.2390, section 5.4.1: light up to `peak` brought below `target`, in cd/m2; darker light kept.

    The knee is a Hermite spline in PQ; black stays at zero.
    """
    top = float(nits_to_pq(np.array(peak)))
    highest = float(nits_to_pq(np.array(target))) / top
    signal = np.minimum(nits_to_pq(nits) / top, 1)
    if highest >= 1:
        return pq_to_nits(signal * top)
    start = 1.5 * highest - 0.5
    t = np.clip((signal - start) / (1 - start), 0, 1)
    bent = (
        (2 * t**3 - 3 * t**2 + 1) * start
        + (t**3 - 2 * t**2 + t) * (1 - start)
        + (-2 * t**3 + 3 * t**2) * highest
    )
    return pq_to_nits(np.where(signal < start, signal, bent) * top)
