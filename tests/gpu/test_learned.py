"""Learned blocks on the GPU: the selected filters, and the number of passes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from gpu import film_picture
from pictures import step, style

from vidstyle.backend import FrameRequest
from vidstyle.blade.bank_file import shipped_bank
from vidstyle.blade.structure_tensor import select_filters
from vidstyle.core.planes import luma_rows
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import plan_for_video
from vidstyle.gpu.compile.shader_nodes import ShaderNode, working_format
from vidstyle.gpu.device import devices as devices
from vidstyle.gpu.session import GpuSession
from vidstyle.style import Style

ONCE = style(step("learned", bank="tvf_flat", passes=3, reselect=False))
ANEW = style(step("learned", bank="tvf_flat", passes=3, reselect=True))
SHARED = style(step("etf", passes=3, reselect=False))
CURVED = style(step("flow_dog", sigma=1))
CHOICES = ("chosen_filter", "chosen_filters", "chosen_for_square", "curved_choice")


@pytest.fixture(params=["compute", "fragment"])
def form(request: pytest.FixtureRequest) -> Iterator[Form]:
    yield request.param


def drawn(look: Style, form: Form, shape: tuple[int, int]) -> GpuSession:
    device = devices.choose("gpu").device
    assert device is not None
    session = GpuSession(device, form)
    picture = film_picture(*shape)
    session.fetch(session.start(look, FrameRequest(picture)).result()).result()
    return session


def numbers_in(session: GpuSession) -> np.ndarray:
    """Return the numbers of the filters that the GPU has selected, H x W."""
    assert session._runner is not None
    nodes = {name_of(node): node for node in session._runner._slots.nodes}
    node = [nodes[name] for name in CHOICES if name in nodes][-1]

    def read() -> np.ndarray:
        assert session._runner is not None
        texture = session._runner._slots.nodes[node]
        codes = np.frombuffer(texture.read(alignment=1), np.uint16)
        codes = codes.reshape(texture.height, texture.width, -1)[: node.shape[0], : node.shape[1]]
        coding = working_format(node, session._runner.plan.form)
        return np.rint((codes / 65535 * coding.span + coding.low) * 1024)

    numbers = session._thread.submit(read).result()
    if node.kind == "luma":
        return numbers[..., 0]
    height, width = session._runner.plan.source.shape
    rows, columns, _ = numbers.shape
    squares = numbers.reshape(rows, columns, 2, 2).swapaxes(1, 2)
    return squares.reshape(2 * rows, 2 * columns)[:height, :width]


def name_of(node: ShaderNode) -> str:
    assert node.function is not None
    return node.function.name


@pytest.mark.parametrize("shape", [(181, 321), (16, 700), (1, 1)])
@pytest.mark.parametrize(
    ("look", "name"),
    [(ONCE, "tvf_flat"), (SHARED, "etf"), (CURVED, "flow_dog_fine")],
    ids=["each", "shared", "curved"],
)
def test_gpu_and_cpu_select_same_filters(form: Form, shape: tuple[int, int], look: Style, name: str) -> None:
    """Except for structure exactly on the border of two bins."""
    session = drawn(look, form, shape)
    picture, bank = film_picture(*shape), shipped_bank(name)
    expected = select_filters(luma_rows(picture, 0, shape[0]), bank.bins, bank.rho)
    expected = expected.repeat(bank.bins.pitch, 0).repeat(bank.bins.pitch, 1)[: shape[0], : shape[1]]
    found = numbers_in(session)
    session.close()
    assert (found == expected).mean() >= 0.98
    assert found.max() < bank.bins.count


@pytest.mark.parametrize("look", [ONCE, ANEW], ids=["once", "anew"])
def test_choice_and_filter_are_one_compute_pass(look: Style) -> None:
    first = ["chosen_filter", "filtered"]
    assert names_of_calls(look, "compute") == [first, *([["filtered"]] * 2 if look is ONCE else [first] * 2)]


@pytest.mark.parametrize("look", [ONCE, ANEW], ids=["once", "anew"])
def test_fragments_choose_for_four_pixels_in_a_pass_of_half_the_size(look: Style) -> None:
    chooses, filters = ["chosen_filters"], ["IMAGE_own_choice", "filtered"]
    assert names_of_calls(look, "fragment") == (
        [chooses, *[filters] * 3] if look is ONCE else [chooses, filters] * 3
    )
    plan = plan_for_video(look, 61, 41, "fragment")
    assert [each.shape for each in plan.passes][:2] == [(21, 31), (41, 61)]


def test_pixels_that_share_a_filter_choose_it_in_a_pass_of_half_the_size(form: Form) -> None:
    filters = ["IMAGE_own_choice", "filtered"]
    assert names_of_calls(SHARED, form) == [["chosen_for_square"], *[filters] * 3]


def names_of_calls(look: Style, form: Form) -> list[list[str]]:
    plan = plan_for_video(look, 60, 40, form)
    return [[name_of(node) for node in each.nodes] for each in plan.passes]
