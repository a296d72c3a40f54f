"""vidstyle restyles video in real time.

>>> import numpy, vidstyle
>>> picture = numpy.full((4, 6, 3), 100, numpy.uint8)
>>> style = vidstyle.load_style({"format": 1, "background": [{"block": "posterize", "levels": 2}]})
>>> vidstyle.stylize(picture, style)[0, 0].tolist()
[0, 0, 0]

A film: `vidstyle.render("in.mp4", "out.mp4", style)`. Frame by frame: `vidstyle.Renderer`.
"""

from __future__ import annotations

from importlib import import_module

from vidstyle.version import __version__ as __version__

# As in `typing`, which takes longer to import than all else before the program can handle signals.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from vidstyle.errors import DeviceError as DeviceError
    from vidstyle.errors import InputError as InputError
    from vidstyle.errors import OutputError as OutputError
    from vidstyle.errors import StyleError as StyleError
    from vidstyle.errors import UsageError as UsageError
    from vidstyle.errors import VidstyleError as VidstyleError
    from vidstyle.media.read.reader import ReadOptions as ReadOptions
    from vidstyle.media.write.writer import WriteOptions as WriteOptions
    from vidstyle.pipeline.progress import Progress as Progress
    from vidstyle.pipeline.progress import Summary as Summary
    from vidstyle.pipeline.render import render as render
    from vidstyle.renderer import Renderer as Renderer
    from vidstyle.renderer import stylize as stylize
    from vidstyle.style import Style as Style
    from vidstyle.style import load_style as load_style
    from vidstyle.style import save_style as save_style
    from vidstyle.style import style_names as style_names

_HOMES = {
    "vidstyle.errors": "DeviceError InputError OutputError StyleError UsageError VidstyleError",
    "vidstyle.media.read.reader": "ReadOptions",
    "vidstyle.media.write.writer": "WriteOptions",
    "vidstyle.pipeline.render": "render",
    "vidstyle.pipeline.progress": "Progress Summary",
    "vidstyle.renderer": "Renderer stylize",
    "vidstyle.style": "Style load_style save_style style_names",
}
__all__ = sorted(name for names in _HOMES.values() for name in names.split())


def __getattr__(name: str) -> Any:
    """A public name, imported when it is first used, so that `import vidstyle` costs next to nothing."""
    for home, names in _HOMES.items():
        if name in names.split():
            globals()[name] = getattr(import_module(home), name)
            return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
