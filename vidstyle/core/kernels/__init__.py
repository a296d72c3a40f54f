"""Loops over pixels as machine code: how kernels are declared, compiled, kept and loaded."""

from vidstyle.core.kernels.aligned import CACHE_LINE_FLOATS, aligned_empty, aligned_parts, round_up
from vidstyle.core.kernels.channels import (
    clipped_sum,
    gray_or_interleaved,
    gray_rgb,
    interleaved,
    is_gray,
    repeat_row,
)
from vidstyle.core.kernels.declare import Compiled, cached, compiled, dry_run, is_dry_run
from vidstyle.core.kernels.indices import TIE_LIFT, index_at, look_up_at

__all__ = [
    "CACHE_LINE_FLOATS",
    "TIE_LIFT",
    "Compiled",
    "aligned_empty",
    "aligned_parts",
    "cached",
    "clipped_sum",
    "compiled",
    "dry_run",
    "is_dry_run",
    "gray_or_interleaved",
    "gray_rgb",
    "index_at",
    "interleaved",
    "is_gray",
    "look_up_at",
    "repeat_row",
    "round_up",
]
