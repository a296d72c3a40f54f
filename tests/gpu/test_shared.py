"""Compute passes that read through shared memory give the same result as those that read textures."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from covering import of_the_day
from gpu import Sessions, disagreements, faults, film_picture
from pictures import FLOAT, step, style

from vidstyle.blade.bank_file import save_bank, shipped_bank
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.gpu.compile import shared
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import make_plan, plan_for_video
from vidstyle.gpu.compile.shader import Shader
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.style import Style, load_style
from vidstyle.style.resolve import resolve

TWICE = style(
    step("to_gray", save="gray"),
    step("learned", bank="tvf_flat", passes=1, save="soft"),
    step("tvf", source="gray", passes=1),
    step("blend", other="soft", mode="difference"),
)
LOOKS = {
    "wide and narrow": style(
        step("to_gray", save="gray"),
        step("gaussian", sigma=9, save="wide"),
        step("gaussian", source="gray", sigma=0.7),
        step("blend", other="wide", mode="grain_extract"),
    ),
    "RGB": style(step("gaussian", sigma=7), step("posterize")),
    "wider than a group": style(step("to_gray"), step("gaussian", sigma=25)),
    "wider than the room": style(step("gaussian", sigma=60), step("saturation")),
    "no radius": style(step("gaussian", sigma=0), step("sobel")),
    "halftone": style(step("halftone", cell=9)),
    "etf": style(step("etf", passes=2)),
    "etf, broad": style(step("etf", passes=1, rho=4)),
    "etf, then RGB": style(step("etf", passes=1, rho=3), step("saturation")),
    "two choices": TWICE,
}
SHAPES = [(1, 1), (1, 37), (45, 1), (16, 16), (19, 33), (129, 67)]


def shaders_of(look: Style, form: Form = "compute") -> list[Shader]:
    plan = plan_for_video(look, 320, 180, form)
    return [write_shader(plan, each) for each in plan.passes]


@pytest.mark.parametrize(
    "look, radius, groups",
    [
        (style(step("to_gray"), step("gaussian", sigma=2)), [(6, 0), (0, 6)], [(32, 8), (8, 32)]),
        (style(step("gaussian", sigma=2)), [None, (6, 0), (0, 6)], [(16, 16), (32, 8), (16, 32)]),
        (style(step("sobel")), [(1, 1)], [(16, 16)]),
        (style(step("learned", bank="tvf_flat")), [(4, 4)], [(16, 16)]),
        (style(step("etf", passes=2, reselect=False)), [None, (2, 2), (2, 2)], [(16, 16)] * 3),
        (style(step("scale", factor=0.5, method="area"), step("to_gray")), None, None),
        (style(step("halftone", cell=9)), [None, (13, 0), (0, 13), None], None),
    ],
    ids=["gaussian", "gaussian of RGB", "sobel", "learned", "etf", "scale", "halftone"],
)
def test_a_pass_shares_what_its_filters_read(look: Style, radius: list | None, groups: list | None) -> None:
    shaders = shaders_of(look)
    found = [shader.uniforms.get("around_radius") for shader in shaders]
    assert found == (radius or [None] * len(shaders))
    for shader in shaders:
        text, shares = shader.assembly.text, "around_radius" in shader.uniforms
        assert ("load_around(first, area);" in text) == shares
        assert bool(re.search(r"^shared \w+ around\[", text, re.MULTILINE)) == shares
    if groups:
        assert [shader.text.groups for shader in shaders] == groups


def test_fragments_share_nothing() -> None:
    for shader in shaders_of(LOOKS["etf"], "fragment") + shaders_of(LOOKS["RGB"], "fragment"):
        assert "shared" not in shader.assembly.text


def test_one_pass_prepares_one_choice() -> None:
    """Two would need twice the shared memory."""
    calls = [shader.assembly.text.count("chosen_filter_prepare(radius_") for shader in shaders_of(TWICE)]
    assert sorted(calls)[-2:] == [1, 1]


@pytest.mark.parametrize("grid", [(2, 2), (4, 4)])
def test_shared_memory_stays_within_guaranteed_size(grid: tuple[int, int], tmp_path: Path) -> None:
    source = PictureLayout(Encoding(subsampling=grid), (180, 320), "chroma")
    looks = [style(step("gaussian", sigma=number / 4)) for number in range(1, 130)]
    for radius in range(1, 17):
        save_bank(replace(shipped_bank("tvf"), rho=radius / 4), tmp_path / f"{radius}.npz")
        (tmp_path / "look.toml").write_text(
            f'format = 1\n[[background]]\nblock = "learned"\nbank = "{radius}.npz"\n'
            '[[background]]\nblock = "saturation"\n'
        )
        looks.append(load_style(tmp_path / "look.toml"))
    sizes = []
    for look in looks:
        plan = make_plan(look, resolve(look, 180, 320), source, source.encoding, False, "compute")
        sizes += [shared_bytes(write_shader(plan, each)) for each in plan.passes]
    assert 28000 < max(sizes) <= 32768


def rooms_in(shader: Shader) -> dict[str, int]:
    """Return the numbers of values in the shared arrays of a shader, by the names of the constants."""
    return {name: int(room) for name, room in re.findall(r"#define (\w+_ROOM) (\d+)", shader.assembly.text)}


def shared_bytes(shader: Shader) -> int:
    """Return the bytes of all shared arrays of a shader, with vec3 padded to four numbers."""
    rooms, text = rooms_in(shader), shader.assembly.text
    if area := re.search(r"AREA = ivec2\((\d+), (\d+)\)", text):
        rooms["AREA.x * AREA.y"] = int(area[1]) * int(area[2])
    arrays = re.findall(r"^shared (\w+) \w+\[(.+)\];", text, re.MULTILINE)
    return sum({"float": 4, "vec2": 8, "vec3": 16}[kind] * rooms[room] for kind, room in arrays)


sessions = Sessions.fixture()
whole = Sessions.fixture()
tiled = Sessions.fixture(max_side=64)


@pytest.mark.parametrize("name", of_the_day(list(LOOKS), 5))
def test_small_and_odd_pages_agree_with_cpu(name: str, sessions: Sessions) -> None:
    found = [
        line
        for shape in SHAPES
        for line in faults(sessions, LOOKS[name], film_picture(*shape), "x".join(map(str, shape)))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("name", of_the_day(list(LOOKS), 5))
def test_filters_without_shared_memory_agree(
    name: str, sessions: Sessions, whole: Sessions, tiled: Sessions, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = film_picture(97, 131)
    right = sessions.run("compute", LOOKS[name], picture)
    monkeypatch.setattr(shared, "MAX_SHARED_BYTES", 0)
    assert not any(rooms_in(shader) for shader in shaders_of(LOOKS[name]))
    for without_room in (whole, tiled):
        assert disagreements(right, without_room.run("compute", LOOKS[name], picture)) == []


def test_float_picture_is_shared_as_float(sessions: Sessions) -> None:
    source = Picture(FLOAT, luma=film_picture(50, 70).luma.astype("float32") / 255)  # type: ignore[union-attr]
    assert faults(sessions, style(step("gaussian", sigma=3)), source, "float") == []
