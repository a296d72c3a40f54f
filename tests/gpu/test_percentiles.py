"""Percentiles measured on the GPU: equal to NumPy's, and smoothed as on the CPU."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Sequence

import moderngl
import numpy as np
import pytest
from covering import in_one_test

from vidstyle.core.sampling import ExponentialSmoother
from vidstyle.gpu.device.percentiles import GpuPercentiles

LOW, SPAN = -0.125, 1.25
CLOSE = 2e-5
"""One of 65536 steps over the span."""


@pytest.fixture
def percentiles(context: moderngl.Context) -> Iterator[GpuPercentiles]:
    percentiles = GpuPercentiles(context, LOW, SPAN)
    yield percentiles
    percentiles.release()


def random(height: int, width: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(LOW, LOW + SPAN, (height, width)).astype(np.float32)


def codes(values: np.ndarray) -> np.ndarray:
    return np.rint((values - LOW) / SPAN * 65535).astype(np.uint16)


def coded_texture(context: moderngl.Context, values: np.ndarray) -> moderngl.Texture:
    return context.texture(values.shape[::-1], 1, codes(values), dtype="nu2")


def numbers(texture: moderngl.Texture) -> np.ndarray:
    assert (texture.size, texture.components, texture.dtype) == ((1, 1), 4, "f4")
    return np.frombuffer(texture.read(), np.float32)


def followed(
    percentiles: GpuPercentiles, values: np.ndarray, percentages: Sequence[float], share: float = 1.0
) -> np.ndarray:
    """Return the percentiles after this picture."""
    samples = coded_texture(percentiles._context, values)
    out = numbers(percentiles.measure(samples, values.shape[::-1], percentages, share))
    samples.release()
    return out[: len(percentages)]


def alternating(height: int, width: int) -> np.ndarray:
    """Black and white, half each."""
    return (np.indices((height, width)).sum(axis=0) % 2).astype(np.float32)


def expected(values: np.ndarray, percentages: Sequence[float]) -> np.ndarray:
    """NumPy's percentiles; highlights of HDR count as diffuse white."""
    return np.minimum(np.percentile(values.astype(float), percentages), 1.0)


PICTURES = {
    "random": random(123, 217),
    "random-dark": random(100, 99) * 0.01 + 0.2,
    "constant": np.full((50, 60), 0.3, np.float32),
    "lowest": np.full((20, 30), LOW, np.float32),
    "highest": np.full((20, 30), LOW + SPAN, np.float32),
    "two-valued": alternating(320, 320),
    "two-valued-odd": alternating(319, 317),
    "two-ends": alternating(40, 40) * SPAN + LOW,
    "ramp": np.linspace(LOW, LOW + SPAN, 65536, dtype=np.float32).reshape(256, 256),
    "1x1": np.full((1, 1), 0.7, np.float32),
    "2x1": np.array([[0.9, 0.1]], np.float32),
    "row": random(1, 320),
    "column": random(320, 1),
    "320x320": random(320, 320),
}


@in_one_test(
    "percentages", [(5, 95), (0, 100), (50, 50), (37.5,), (2, 98), (100, 0), (0.1, 33.3, 66.6, 99.9)]
)
@in_one_test("name", PICTURES)
def test_percentiles_equal_numpy(
    percentiles: GpuPercentiles, name: str, percentages: tuple[float, ...]
) -> None:
    values = PICTURES[name]
    found = followed(percentiles, values, percentages)
    np.testing.assert_allclose(found, expected(values, percentages), rtol=0, atol=CLOSE)


def test_percentiles_of_equal_codes_are_exact(percentiles: GpuPercentiles) -> None:
    values = random(200, 300)
    exact = expected(codes(values) / 65535 * SPAN + LOW, (5, 50, 95))
    np.testing.assert_allclose(followed(percentiles, values, (5, 50, 95)), exact, rtol=0, atol=2e-7)


def test_only_the_used_part_counts(context: moderngl.Context, percentiles: GpuPercentiles) -> None:
    """The texture may be larger, as it is created for the largest picture."""
    values = random(40, 50) * 0.1 + 0.5
    larger = random(60, 80)
    larger[:40, :50] = values
    samples = coded_texture(context, larger)
    found = numbers(percentiles.measure(samples, (50, 40), (0, 50, 100), 1.0))
    np.testing.assert_allclose(found[:3], np.percentile(values, (0, 50, 100)), rtol=0, atol=CLOSE)
    samples.release()


def test_previous_pictures_have_no_effect(percentiles: GpuPercentiles) -> None:
    """Even if they were larger."""
    for values in (random(100, 120), random(30, 20) * 0.1, np.full((1, 1), 0.6, np.float32)):
        found = followed(percentiles, values, (0, 5, 95, 100))
        np.testing.assert_allclose(found, expected(values, (0, 5, 95, 100)), rtol=0, atol=CLOSE)


def test_fewer_than_four_repeat_the_last(context: moderngl.Context, percentiles: GpuPercentiles) -> None:
    samples = coded_texture(context, random(30, 40))
    found = numbers(percentiles.measure(samples, (40, 30), (10, 60), 1.0))
    assert found[1] == found[2] == found[3] != found[0]
    samples.release()


def test_percentiles_are_smoothed_as_on_the_cpu(percentiles: GpuPercentiles) -> None:
    """Through slow changes, a jump back in time and a constant of 0."""
    smoother, weights = ExponentialSmoother(), ExponentialSmoother()
    times = [(2.0, 0.4), (2.04, 0.4), (2.1, 0.4), (2.2, 0.4), (1.0, 0.4), (1.1, 0.4), (1.2, 0), (1.5, 2.0)]
    for seed, (time, constant) in enumerate(times):
        values = random(40, 50, seed) * 0.1 * seed
        measure = np.percentile(values.astype(float), (5, 95))
        expected = smoother.follow(measure, time, constant)
        found = followed(percentiles, values, (5, 95), weights.blend_weight(time, constant))
        np.testing.assert_allclose(found, expected, rtol=0, atol=CLOSE)


def test_first_measurement_is_not_smoothed(percentiles: GpuPercentiles) -> None:
    assert followed(percentiles, np.full((4, 5), 0.3, np.float32), (50,), share=0.1) == pytest.approx(
        0.3, abs=CLOSE
    )


def test_previous_numbers_stay_valid(context: moderngl.Context, percentiles: GpuPercentiles) -> None:
    """A frame in flight uses the results of its measurement."""
    samples = [coded_texture(context, np.full((4, 5), value, np.float32)) for value in (0.2, 0.8)]
    textures = [percentiles.measure(each, (5, 4), (50,), 1.0) for each in samples]
    assert [numbers(texture)[0] for texture in textures] == pytest.approx([0.2, 0.8], abs=CLOSE)
    for each in samples:
        each.release()


def test_two_steps_have_separate_state(context: moderngl.Context, percentiles: GpuPercentiles) -> None:
    other = GpuPercentiles(context, LOW, SPAN)
    followed(percentiles, np.full((4, 5), 0.2, np.float32), (50,))
    followed(other, np.full((4, 5), 0.8, np.float32), (50,))
    again = followed(percentiles, np.full((4, 5), 0.4, np.float32), (50,), share=0.5)
    assert again == pytest.approx(0.3, abs=CLOSE)
    other.release()


def test_other_range_is_supported(context: moderngl.Context) -> None:
    percentiles = GpuPercentiles(context, 0.0, 2.0)
    samples = context.texture((1, 1), 1, np.array([[13107]], np.uint16), dtype="nu2")
    assert numbers(percentiles.measure(samples, (1, 1), (50,), 1.0))[0] == pytest.approx(0.4)
    samples.release()
    percentiles.release()


def test_state_of_other_drawing_is_restored(context: moderngl.Context, percentiles: GpuPercentiles) -> None:
    """Into their target and its viewport, with and without blending, by the context's blend function."""
    program = context.program(
        "#version 330\nvoid main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }",
        "#version 330\nout vec4 color;\nvoid main() { color = vec4(0.5, 0.5, 0.5, 0.25); }",
    )
    point = context.vertex_array(program, [])
    target = context.framebuffer([context.texture((1, 1), 4, dtype="f4")])
    for flags, expected in ((context.NOTHING, 0.5), (context.BLEND, 0.25 * 0.5 + 0.75 * 1.0)):
        target.clear(1.0, 1.0, 1.0, 1.0)
        with context.scope(target, flags) as scope:
            followed(percentiles, random(30, 40), (5, 95))
            point.render(context.POINTS, 1)
        scope.release()
        assert np.frombuffer(target.read(components=1, dtype="f4"), np.float32)[0] == expected
    for thing in (target.color_attachments[0], target, point, program):
        thing.release()


def test_enabled_flags_of_others_have_no_effect(
    context: moderngl.Context, percentiles: GpuPercentiles
) -> None:
    context.enable_only(context.BLEND | context.DEPTH_TEST | context.CULL_FACE | context.PROGRAM_POINT_SIZE)
    for seed in range(3):
        values = random(30, 40, seed)
        found = followed(percentiles, values, (5, 95))
        np.testing.assert_allclose(found, expected(values, (5, 95)), rtol=0, atol=CLOSE)
    context.enable_only(context.NOTHING)


def alive(context: moderngl.Context) -> set[int]:
    """Identities of all objects of the context that have not been released, referenced or not."""
    kinds = (
        moderngl.Texture,
        moderngl.Framebuffer,
        moderngl.Buffer,
        moderngl.Program,
        moderngl.VertexArray,
        moderngl.Scope,
    )
    held = [thing for thing in gc.get_objects() if type(thing) in kinds and thing.ctx is context]
    lost = [thing for thing in context.objects if not isinstance(thing, moderngl.InvalidObject)]
    held = [thing for thing in held if not isinstance(thing.mglo, moderngl.InvalidObject)]
    return {id(thing) for thing in (*held, *lost)}


def test_many_calls_create_no_objects(context: moderngl.Context) -> None:
    empty = alive(context)
    percentiles = GpuPercentiles(context, LOW, SPAN)
    samples = coded_texture(context, random(8, 9))
    names = {percentiles.measure(samples, (9, 8), (5, 95), 0.5).glo for _ in range(2)}
    before = alive(context)
    names |= {percentiles.measure(samples, (9, 8), (5, 95), 0.5).glo for _ in range(1000)}
    assert len(names) == 2
    assert alive(context) == before
    percentiles.release()
    samples.release()
    assert alive(context) == empty
