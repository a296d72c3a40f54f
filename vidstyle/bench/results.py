"""Measurements as JSON data and as Markdown tables."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from typing import Any

import vidstyle
from vidstyle.bench import Bench, Timed
from vidstyle.bench.films import FilmTimes
from vidstyle.bench.paper_figures import (
    MOBILE_FILTER_SPEEDS,
    OTHER_FILTERS,
    PAPER_FIGURES,
    XEON_ETF_SPEED,
    figure_for,
)
from vidstyle.core.machine.cores import available_cores
from vidstyle.gpu.compile.explain import explain
from vidstyle.gpu.timing import GpuTimes

EMPTY_CELL = "-"
"""Shown in place of a missing number."""

TableRow = dict[str, str]
"""A row of a table: texts by column names."""


def as_dict(bench: Bench, timed: Sequence[Timed], bandwidth: float | None = None) -> dict[str, Any]:
    """All measurements, and the machine.

    Args:
        bandwidth: of the GPU's memory, in gigabytes a second, if it is known.
    """
    return {"machine": _machine(bench)} | {"results": [_result(each, bandwidth) for each in timed]}


def _machine(bench: Bench) -> dict[str, Any]:
    facts = {
        "vidstyle": vidstyle.__version__,
        "cores": available_cores(),
        "processor": platform.machine(),
        "system": platform.system(),
    }
    if bench.device is None:
        return facts
    opengl = f"{bench.device.version // 100}.{bench.device.version % 100 // 10}"
    return facts | {"device": str(bench.device), "opengl": opengl, "software": bench.device.software}


def _result(timed: Timed, bandwidth: float | None) -> dict[str, Any]:
    subject, size = timed.subject, timed.size
    figure = figure_for(subject.name) if subject.kind == "style" else None
    return {
        "kind": subject.kind,
        "name": subject.name,
        "on": subject.on,
        "size": list(size),
        "cpu": _speed(size, timed.cpu),
        "gpu": [_gpu_result(size, times, bandwidth) for times in timed.gpu],
        "paper": vars(figure) if figure else None,
    }


def _gpu_result(size: tuple[int, int], times: GpuTimes, bandwidth: float | None) -> dict[str, Any]:
    passes = sum(times.passes)
    explained = explain(times.plan)
    rate = explained["bytes"] * size[0] * size[1] / passes / 1e9 if passes else None
    return {
        "form": times.plan.form,
        "clock": times.clock,
        "all_passes": _speed(size, passes),
        "upload": _speed(size, times.upload),
        "download": _speed(size, times.download),
        "whole": _speed(size, times.whole),
        **{name: explained[name] for name in ("bytes", "bytes_up", "bytes_down")},
        "gigabytes_per_s": rate,
        "share_of_bandwidth": rate / bandwidth if rate and bandwidth else None,
        "passes": [each | {"ms": t * 1e3} for each, t in zip(explained["passes"], times.passes, strict=True)],
    }


def _speed(size: tuple[int, int], seconds: float) -> dict[str, float | None]:
    megapixels = size[0] * size[1] / 1e6
    return {"ms": seconds * 1e3, "mp_per_s": megapixels / seconds if seconds else None}


def markdown(data: dict[str, Any]) -> str:
    """Return `data` as Markdown: for each size, tables for the CPU and each form of GPU passes."""
    machine, results = data["machine"], data["results"]
    lines = [", ".join(f"{name}: {fact}" for name, fact in machine.items())]
    for size in dict.fromkeys(tuple(result["size"]) for result in results):
        alike = [result for result in results if tuple(result["size"]) == size]
        name = f"{size[0]}x{size[1]}"
        lines += ["", f"## {name}, CPU", "", *_table([_cpu_row(result) for result in alike])]
        for number, first in enumerate(alike[0]["gpu"]):
            title = f"## {name}, {machine['device']}: {first['form']} passes, timed by {first['clock']}"
            rows = [_gpu_row(result, result["gpu"][number]) for result in alike]
            lines += ["", title, "", *_table(rows)]
    return "\n".join([*lines, "", *_legend(results)]) + "\n"


def film_markdown(timed: Sequence[FilmTimes]) -> str:
    """Return a table of a film in several styles: ms per frame of each part, and total frames per second."""
    parts = ("decode", "style", "steady", "encode")
    rows = [
        {"style": each.name}
        | {f"{part}, ms": _number(1e3 * getattr(each, part)) for part in parts}
        | {"frames/s": _number(1 / each.whole)}
        for each in timed
    ]
    return "\n".join(_table(rows)) + "\n"


def _cpu_row(result: dict[str, Any]) -> TableRow:
    return _subject(result) | {
        "ms": _number(result["cpu"]["ms"]),
        "MP/s": _number(result["cpu"]["mp_per_s"]),
        "paper, MP/s": _paper(result),
    }


def _gpu_row(result: dict[str, Any], gpu: dict[str, Any]) -> TableRow:
    """Return times in ms; empty without GPU passes."""
    runs = bool(gpu["passes"])
    share = gpu["share_of_bandwidth"]
    return _subject(result) | {
        "passes": str(len(gpu["passes"])),
        "bytes a pixel": _number(gpu["bytes"]),
        "up, down": f"{_number(gpu['bytes_up'])}, {_number(gpu['bytes_down'])}",
        "passes, ms": _number(gpu["all_passes"]["ms"] if runs else None),
        "MP/s": _number(gpu["all_passes"]["mp_per_s"]),
        "GB/s": _number(gpu["gigabytes_per_s"]),
        "of bandwidth": EMPTY_CELL if share is None else f"{share:.0%}",
        "upload, ms": _number(gpu["upload"]["ms"] if runs else None),
        "download, ms": _number(gpu["download"]["ms"] if runs else None),
        "whole, ms": _number(gpu["whole"]["ms"] if runs else None),
        "whole, MP/s": _number(gpu["whole"]["mp_per_s"] if runs else None),
        "paper, MP/s": _paper(result),
    }


def _subject(result: dict[str, Any]) -> TableRow:
    return {"block or style": result["name"], "works on": result["on"] or EMPTY_CELL}


def _paper(result: dict[str, Any]) -> str:
    figure = result["paper"]
    return f"{figure['desktop']:.0f}, {figure['mobile']:.0f}" if figure else EMPTY_CELL


def _number(value: float | None) -> str:
    """Format a number with at least three significant digits.

    >>> [_number(value) for value in (0.01234, 1.5, 1719.4, None)]
    ['0.0123', '1.5', '1719', '-']
    """
    if value is None:
        return EMPTY_CELL
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _table(rows: list[TableRow]) -> Iterator[str]:
    """An aligned Markdown table without its empty columns; the first is aligned to the left."""
    columns = [name for name in rows[0] if any(row[name] != EMPTY_CELL for row in rows)]
    cells = [[row[name] for name in columns] for row in rows]
    first, *others = (max(map(len, column)) for column in zip(columns, *cells, strict=True))
    rule = ["-" * first, *("-" * (width - 1) + ":" for width in others)]
    aligned = [f"<{first}", *(f">{width}" for width in others)]
    for texts in (columns, rule, *cells):
        yield f"| {' | '.join(map(format, texts, aligned))} |"


def _legend(results: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Notes below the tables."""
    if any(result["gpu"] for result in results):
        yield (
            "Passes, upload and download are measured separately. Whole: from picture to picture, with the "
            "next upload before the previous download. Bytes: by the plan, each picture counted once."
        )
        yield ""
    desktop, mobile = (
        sorted(getattr(each, name) for each in PAPER_FIGURES) for name in ("desktop", "mobile")
    )
    yield (
        f"Paper: on a GTX 1080, on a Pixel 2018. Its {len(PAPER_FIGURES)} styles run at {desktop[0]:.0f} to "
        f"{desktop[-1]:.0f} and {mobile[0]:.0f} to {mobile[-1]:.0f} MP/s; single filters have no figures."
    )
    if any(result["name"] in ("learned", "etf") for result in results):
        cpu, gpu = MOBILE_FILTER_SPEEDS
        yield (
            f"Its learned edge tangent flow runs at {XEON_ETF_SPEED} MP/s on a Xeon E5-1650v3, its learned "
            f"5 x 5 filters at {cpu} and {gpu} on CPU and GPU of a Pixel 2018; `learned` is one pass, `etf` "
            "is three."
        )
    if alike := {result["name"]: result["paper"]["style"] for result in results if result["paper"]}:
        yield _paper_alike(alike)


def _paper_alike(alike: dict[str, int]) -> str:
    """Which style of the paper each style is compared with.

    >>> _paper_alike({"noir": 4, "ink": 1})
    'Its style 1 is compared with `ink`, 4 with `noir`: similar in look, not in the work done.'
    """
    pairs = sorted((number, name) for name, number in alike.items())
    names = [f"`{name}`{f' ({OTHER_FILTERS[name]})' if name in OTHER_FILTERS else ''}" for _, name in pairs]
    first, *others = (f"{number} with {name}" for (number, _), name in zip(pairs, names, strict=True))
    texts = [first.replace(" with ", " is compared with ", 1), *others]
    return f"Its style {', '.join(texts)}: similar in look, not in the work done."
