"""Measurements as JSON data."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from typing import Any

import vidstyle
from vidstyle.bench import Bench, Timed
from vidstyle.bench.paper_figures import figure_for
from vidstyle.gpu.compile.explain import download_bytes, explain, plan_traffic, upload_bytes
from vidstyle.gpu.timing import GpuTimes


def as_dict(bench: Bench, timed: Sequence[Timed], bandwidth: float | None = None) -> dict[str, Any]:
    """All measurements, and the machine.

    Args:
        bandwidth: of the GPU's memory, in gigabytes a second, if it is known.
    """
    return {"machine": _machine(bench)} | {"results": [_result(each, bandwidth) for each in timed]}


def _machine(bench: Bench) -> dict[str, Any]:
    facts = {
        "vidstyle": vidstyle.__version__,
        "cores": os.cpu_count(),
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
    moved = plan_traffic(times.plan).total
    rate = moved * size[0] * size[1] / passes / 1e9 if passes else None
    explained = explain(times.plan)["passes"]
    return {
        "form": times.plan.form,
        "clock": times.clock,
        "all_passes": _speed(size, passes),
        "upload": _speed(size, times.upload),
        "download": _speed(size, times.download),
        "whole": _speed(size, times.whole),
        "bytes": round(moved, 3),
        "bytes_up": round(upload_bytes(times.plan), 3),
        "bytes_down": round(download_bytes(times.plan), 3),
        "gigabytes_per_s": rate,
        "share_of_bandwidth": rate / bandwidth if rate and bandwidth else None,
        "passes": [each | {"ms": t * 1e3} for each, t in zip(explained, times.passes, strict=True)],
    }


def _speed(size: tuple[int, int], seconds: float) -> dict[str, float | None]:
    megapixels = size[0] * size[1] / 1e6
    return {"ms": seconds * 1e3, "mp_per_s": megapixels / seconds if seconds else None}
