"""Network: a neural network from an ONNX file."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.block import Asset, Choice, Slider, block
from vidstyle.network.network_process import open_network
from vidstyle.network.network_run import RANGES, NetworkRun


@block(
    "network",
    on="color",
    label="Neural network",
    category="parts",
    aliases="ai, onnx, model, neural style, deep learning",
)
def network(
    model: Annotated[
        Any,
        Asset("ONNX file of a network; empty: no change", open_network, optional=True, label="Network file"),
    ] = "",
    range: Annotated[
        str, Choice(tuple(RANGES), "numbers of the network for black and white", label="Number range")
    ] = "0..255",
    size: Annotated[
        int, Slider(64, 4096, "shorter side of the picture that the network gets", label="Picture size")
    ] = 720,
    amount: Annotated[float, Slider(0, 1, "0 for no effect", label="Network strength")] = 1,
) -> NetworkRun | None:
    """Apply a neural network that maps a picture to another; on the processor only.

    Both pictures have the same size. It takes and returns RGB as 1 x 3 x H x W or 1 x H x W x 3 floats.
    Pictures are reduced to `size`, and the result gets the fine detail of the picture back where both
    vary together. Pictures of more than 1024 pixels run in overlapping tiles. onnxruntime runs the
    network if it is installed, else OpenCV.
    """
    return None if model is None else NetworkRun(model, RANGES[range], size, amount)
