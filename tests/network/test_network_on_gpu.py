"""A style with a network runs on the CPU, on any device."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx_model
import pytest
from gpu import device
from pictures import noise

from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.gpu.renderer import GpuRenderer
from vidstyle.style import load_style


def test_a_network_runs_on_the_cpu(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Also if the style is changed to one with a network, and back."""
    (tmp_path / "a.onnx").write_bytes(onnx_model.negative())
    step = 'format = 1\n[[background]]\nblock = "network"\nmodel = "a.onnx"\n'
    (tmp_path / "net.toml").write_text(step + '[[lines]]\nblock = "sobel"\n')
    picture, style, ink = Picture.from_array(noise(40, 60, 3)), load_style(tmp_path / "net.toml"), "poster"
    with CpuRenderer(style) as renderer:
        expected = renderer.run(picture, rgb=True).color
    renderer = GpuRenderer(load_style(ink), device(), CpuRenderer)
    before = renderer.run(picture, rgb=True).color
    with caplog.at_level("INFO", "vidstyle"):
        renderer.change_style(style)
        result = renderer.run(picture, rgb=True).color
    assert expected is not None and result is not None and np.array_equal(result, expected)
    assert [each.message for each in caplog.records] == ["net has a network: it runs on the CPU"]
    renderer.change_style(load_style(ink))
    after = renderer.run(picture, rgb=True).color
    renderer.close()
    assert before is not None and after is not None and np.array_equal(before, after)
