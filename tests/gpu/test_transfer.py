"""Upload and download of planes: the same samples for every memory layout, and no leaks."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import moderngl
import numpy as np
import pytest
from covering import in_one_test
from numpy.lib.array_utils import byte_bounds

from vidstyle.gpu.device.transfer import Download, PlaneTransfer, Upload, _layout_and_memory

TYPES = {"f1": np.uint8, "nu2": np.uint16, "f4": np.float32}
SIZES = [(1, 1), (1, 9), (9, 1), (361, 641), (8192, 16)]

every_type = pytest.mark.parametrize("dtype", TYPES.values(), ids=TYPES)
every_size = pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[1]}x{size[0]}")


def release_dropped(context: moderngl.Context) -> None:
    """Release unreferenced objects; `context.gc()` fails if some of them are already released."""
    while context.objects:
        dropped = context.objects.popleft()
        if not isinstance(dropped, moderngl.InvalidObject):
            dropped.release()


@pytest.fixture
def upload(context: moderngl.Context) -> Iterator[Upload]:
    yield Upload(context)
    release_dropped(context)


@pytest.fixture
def download(context: moderngl.Context) -> Iterator[Download]:
    yield Download(context)
    release_dropped(context)


def samples(shape: tuple[int, ...], dtype: type[np.generic], seed: int = 0) -> np.ndarray:
    """Noise over the whole range of the type; floats also far outside 0..1."""
    random = np.random.default_rng(seed)
    if dtype is np.float32:
        return random.normal(0, 1000, shape).astype(np.float32)
    return random.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


def padded(plane: np.ndarray, padding: int) -> np.ndarray:
    """The same plane in memory that ends with its last sample, with `padding` bytes between rows."""
    row = plane[0].nbytes + padding
    memory = np.full(row * (plane.shape[0] - 1) + plane[0].nbytes, 0xA5, np.uint8)
    strides = (row, *plane.strides[1:])
    view = np.ndarray(plane.shape, plane.dtype, memory, strides=strides)
    view[...] = plane
    return view


def seen(texture: moderngl.Texture, width: int) -> np.ndarray:
    """Return the content of a texture, cropped to the plane's width."""
    dtype = TYPES[texture.dtype]
    values = np.frombuffer(texture.read(alignment=1), dtype)
    values = values.reshape(texture.height, texture.width, texture.components)[:, :width]
    return values[..., 0] if texture.components == 1 else values


def alive(context: moderngl.Context) -> list[object]:
    """All buffers, textures and framebuffers that have not been released, referenced or not."""
    kinds = (moderngl.Buffer, moderngl.Texture, moderngl.Framebuffer)
    held = [thing for thing in gc.get_objects() if type(thing) in kinds and thing.ctx is context]
    lost = [thing for thing in context.objects if not isinstance(thing, moderngl.InvalidObject)]
    return [thing for thing in held if not isinstance(thing.mglo, moderngl.InvalidObject)] + lost


@every_size
@every_type
@pytest.mark.parametrize("channels", [1, 3])
def test_planes_arrive_in_textures(
    upload: Upload, size: tuple[int, int], dtype: type[np.generic], channels: int
) -> None:
    plane = samples(size if channels == 1 else (*size, 3), dtype)
    texture = upload.send({"luma": plane})["luma"]
    assert (texture.dtype, texture.components) == ({v: k for k, v in TYPES.items()}[dtype], channels)
    assert texture.size == (size[1], size[0])
    np.testing.assert_array_equal(seen(texture, size[1]), plane)


@every_size
@every_type
def test_planes_return_unchanged(
    upload: Upload, download: Download, size: tuple[int, int], dtype: type[np.generic]
) -> None:
    planes = {"luma": samples(size, dtype), "blue": samples(size[::-1], dtype, 1)}
    textures = upload.send(planes)
    arrays = download.begin([*textures.values()]).arrays()
    for array, plane in zip(arrays, planes.values(), strict=True):
        assert array.dtype == dtype
        assert array.flags.owndata and array.flags.writeable
        np.testing.assert_array_equal(array, plane)


@every_size
@pytest.mark.parametrize("name", TYPES)
def test_three_of_four_channels_are_read_back(
    context: moderngl.Context, download: Download, size: tuple[int, int], name: str
) -> None:
    """Together with a plane of another type and an odd number of bytes, so that the offset matters."""
    color = samples((*size, 4), TYPES[name])
    gray = samples((3, 5), np.uint8)
    textures = [
        context.texture((5, 3), 1, gray, dtype="f1"),
        context.texture((size[1], size[0]), 4, color, dtype=name),
    ]
    first, second = download.begin(textures).arrays()
    np.testing.assert_array_equal(first, gray)
    np.testing.assert_array_equal(second, color[..., :3])
    for texture in textures:
        texture.release()


LAYOUTS = {
    "padded": (lambda plane: padded(plane, 48), 48),
    "padded-by-one": (lambda plane: padded(plane, plane.itemsize), None),
    "far-apart": (lambda plane: padded(plane, 8000), 0),
    "half-a-sample-apart": (lambda plane: padded(plane, 2), None),
    "rows-flipped": (lambda plane: plane[::-1], 0),
    "columns-flipped": (lambda plane: plane[:, ::-1], 0),
    "turned": (lambda plane: plane.swapaxes(0, 1), 0),
    "columns-skipped": (lambda plane: plane[:, ::2], 0),
    "rows-skipped": (lambda plane: plane[::2], None),
    "cropped": (lambda plane: plane[1:-2, 3:-4], None),
    "read-only": (lambda plane: np.frombuffer(plane.tobytes(), plane.dtype).reshape(plane.shape), 0),
    "other-endian": (lambda plane: plane.astype(plane.dtype.newbyteorder("S")), 0),
    "one-row-of-many": (lambda plane: plane[5:6], 0),
    "one-row-repeated": (lambda plane: np.broadcast_to(plane[5], (1, *plane.shape[1:])), 0),
    "one-column-of-many": (lambda plane: plane[:, 5:6], None),
    "repeated": (lambda plane: np.broadcast_to(plane[:1], plane.shape), 0),
}
"""Arrays derived from a contiguous one, and the extra bytes of the texture's rows if known."""


@every_type
@in_one_test("layout", LAYOUTS)
@in_one_test("shape", [(37, 53), (37, 53, 3)])
def test_any_layout_is_sent(
    upload: Upload, shape: tuple[int, ...], layout: str, dtype: type[np.generic]
) -> None:
    change, longer = LAYOUTS[layout]
    plane = change(samples(shape, dtype))
    texture = upload.send({"plane": plane})["plane"]
    height, width = plane.shape[:2]
    np.testing.assert_array_equal(seen(texture, width), plane)
    assert texture.height == height
    if longer is not None:
        pixel = plane.itemsize * texture.components
        assert texture.width == width + longer // pixel


@every_type
@in_one_test("layout", LAYOUTS)
@in_one_test("shape", [(37, 53), (37, 53, 3)])
def test_only_memory_of_plane_is_read(shape: tuple[int, ...], layout: str, dtype: type[np.generic]) -> None:
    """From its first to its last sample, and without a copy if its rows allow it."""
    plane = LAYOUTS[layout][0](samples(shape, dtype))
    _, memory = _layout_and_memory(plane, 4096)
    if np.shares_memory(memory, plane):
        assert byte_bounds(memory) == byte_bounds(plane)
    else:
        assert memory.size == plane.size
        assert layout not in ("padded", "cropped", "read-only", "one-row-of-many", "one-row-repeated")


def test_rows_of_rgb_that_end_within_a_pixel_are_not_copied(upload: Upload) -> None:
    """53 pixels of 3 bytes on 192 bytes: 64 pixels; on 176: 58 and two bytes."""
    for row, across in ((192, 64), (176, 58)):
        plane = padded(samples((37, 53, 3), np.uint8), row - 159)
        texture = upload.send({"color": plane})["color"]
        assert texture.width == across
        np.testing.assert_array_equal(seen(texture, 53), plane)


def test_a_row_wider_than_any_texture_is_cut(context: moderngl.Context, upload: Upload) -> None:
    widest = context.info["GL_MAX_TEXTURE_SIZE"]
    plane = padded(samples((3, widest), np.uint8), 32)
    texture = upload.send({"luma": plane})["luma"]
    assert texture.width == widest
    np.testing.assert_array_equal(seen(texture, widest), plane)


def test_plane_can_change_after_send(upload: Upload) -> None:
    plane = samples((361, 641), np.uint8)
    sent = plane.copy()
    texture = upload.send({"luma": plane})["luma"]
    plane[...] = 0
    np.testing.assert_array_equal(seen(texture, 641), sent)


def test_textures_of_previous_picture_stay_valid(upload: Upload) -> None:
    """Even if the next picture has another size."""
    before, now = samples((40, 50), np.uint8), samples((30, 20), np.uint8, 1)
    textures = [upload.send({"luma": plane})["luma"] for plane in (before, now)]
    np.testing.assert_array_equal(seen(textures[0], 50), before)
    np.testing.assert_array_equal(seen(textures[1], 20), now)


def test_textures_are_reused_alternately(upload: Upload) -> None:
    names = [upload.send({"luma": samples((40, 50), np.uint8, seed)})["luma"].glo for seed in range(6)]
    assert names == [names[0], names[1]] * 3
    assert names[0] != names[1]


def test_textures_are_plain(context: moderngl.Context, upload: Upload) -> None:
    texture = upload.send({"luma": samples((4, 5), np.uint8)})["luma"]
    assert texture.filter == (context.NEAREST, context.NEAREST)
    assert not texture.repeat_x and not texture.repeat_y
    assert texture.swizzle == "RGBA"


def gray_texture(context: moderngl.Context, seed: int, size: tuple[int, int] = (61, 41)) -> moderngl.Texture:
    return context.texture(size, 1, samples((size[1], size[0]), np.uint8, seed), dtype="f1")


def test_two_transfers_in_flight_are_independent(context: moderngl.Context, download: Download) -> None:
    textures = [gray_texture(context, seed) for seed in range(2)]
    transfers = [download.begin([texture]) for texture in textures]
    for seed, transfer in enumerate(transfers):
        np.testing.assert_array_equal(transfer.arrays()[0], samples((41, 61), np.uint8, seed))
    for texture in textures:
        texture.release()


def test_third_transfer_finishes_first(context: moderngl.Context, download: Download) -> None:
    """It keeps its arrays after any number of later transfers and changes to the texture."""
    transfers: list[PlaneTransfer] = []
    for seed in range(7):
        texture = gray_texture(context, seed, (61, 41 + seed))
        transfers.append(download.begin([texture]))
        texture.write(np.zeros((41 + seed, 61), np.uint8))
        texture.release()
    for seed, transfer in enumerate(transfers):
        np.testing.assert_array_equal(transfer.arrays()[0], samples((41 + seed, 61), np.uint8, seed))


def test_arrays_requested_twice_are_identical(context: moderngl.Context, download: Download) -> None:
    texture = gray_texture(context, 0)
    transfer = download.begin([texture])
    first = transfer.arrays()[0]
    first[0, 0] ^= 1
    download.begin([texture]).arrays()
    download.begin([texture]).arrays()
    assert transfer.arrays()[0] is first
    texture.release()


@pytest.mark.parametrize("sizes", [24, pytest.param(100, marks=pytest.mark.thorough)])
def test_size_changes_leak_nothing(sizes: int, context: moderngl.Context) -> None:
    release_dropped(context)
    before = len(alive(context))
    upload, download = Upload(context), Download(context)
    for number in range(sizes):
        size = (1 + number * 37 % 90, 1 + number * 91 % 120)
        plane = samples(size, (np.uint8, np.uint16, np.float32)[number % 3], number)
        there_and_back(
            context, upload, download, {"luma": plane, "alpha": plane} if number % 2 else {"luma": plane}
        )
        # Two pixel buffers back, and two sets of a buffer and a texture for at most two planes.
        assert len(alive(context)) - before <= 2 + 2 * 2 * 2
    for _ in range(2):
        there_and_back(context, upload, download, {"luma": samples((3, 5), np.uint8)})
    assert sum(thing.size for thing in alive(context) if isinstance(thing, moderngl.Buffer)) < 1000
    del upload, download
    release_dropped(context)
    assert len(alive(context)) == before


def there_and_back(
    context: moderngl.Context, upload: Upload, download: Download, planes: dict[str, np.ndarray]
) -> None:
    textures = upload.send(planes)
    height, width = planes["luma"].shape
    color = context.texture((width, height), 4)
    transfer = download.begin([textures["luma"], color])
    color.release()
    np.testing.assert_array_equal(transfer.arrays()[0], planes["luma"])
