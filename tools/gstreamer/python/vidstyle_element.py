"""The GStreamer element `vidstyle`; docs/plug-in.md says how GStreamer finds it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gi
import numpy as np

gi.require_version("Gst", "1.0")
gi.require_version("GstBase", "1.0")
gi.require_version("GstVideo", "1.0")
from gi.repository import GObject, Gst, GstBase, GstVideo  # noqa: E402

from vidstyle.backend import Backend  # noqa: E402
from vidstyle.core.picture import SITINGS, Encoding, Picture  # noqa: E402
from vidstyle.errors import VidstyleError  # noqa: E402
from vidstyle.renderer import open_renderer  # noqa: E402
from vidstyle.style import Style, load_style, override  # noqa: E402

CAPS = Gst.Caps.from_string(
    "video/x-raw, format={I420, RGB}, interlace-mode=progressive,"
    "width=[1,2147483647], height=[1,2147483647], framerate=[0/1,2147483647/1]"
)
MATRICES = {
    GstVideo.VideoColorMatrix.BT601: "bt601",
    GstVideo.VideoColorMatrix.BT709: "bt709",
    GstVideo.VideoColorMatrix.BT2020: "bt2020",
    GstVideo.VideoColorMatrix.FCC: "fcc",
    GstVideo.VideoColorMatrix.SMPTE240M: "smpte240m",
}
FULL_RANGE = getattr(GstVideo.VideoColorRange, "0_255")
RGB = Encoding(full_range=True, subsampling=(1, 1))
STYLE_STEADY_CODE = -1.0
"""Value of the property `steady` that selects the value of the style."""
NOW = GObject.ParamFlags.READWRITE | Gst.PARAM_MUTABLE_PLAYING


class VidstyleElement(GstBase.BaseTransform):
    """Restyles the pictures of a pipeline; its properties may change while it plays."""

    __gtype_name__ = "GstVidstyle"
    __gstmetadata__ = ("vidstyle", "Filter/Effect/Video", "Restyles pictures with filter blocks", "vidstyle")
    __gsttemplates__ = tuple(
        Gst.PadTemplate.new(name, direction, Gst.PadPresence.ALWAYS, CAPS)
        for name, direction in (("sink", Gst.PadDirection.SINK), ("src", Gst.PadDirection.SRC))
    )

    style = GObject.Property(
        type=str, default="comic", flags=NOW, nick="Style", blurb="A style's name, or a style file"
    )
    set = GObject.Property(
        type=str, default="", flags=NOW, nick="Set", blurb="step.parameter=value, several separated by ;"
    )
    steady = GObject.Property(
        type=float, minimum=STYLE_STEADY_CODE, maximum=1.0, default=STYLE_STEADY_CODE, flags=NOW,
        nick="Steady", blurb="0 lets flicker boil, 1 keeps it still, -1 is the style's own",
    )  # fmt: skip
    device = GObject.Property(
        type=str, default="auto", flags=NOW, nick="Device", blurb="auto, cpu, gpu or gpu:N"
    )

    def __init__(self) -> None:
        super().__init__()
        self._renderer: Backend | None = None
        self._asked: tuple[Any, ...] = ()
        self._info: Any = None
        self._encoding = RGB

    def do_start(self) -> bool:
        """Open the device and read the style, so that a mistake ends the pipeline before it plays."""
        try:
            self._renew()
        except VidstyleError as error:
            self._post(Gst.MessageType.ERROR, error)
        return self._renderer is not None

    def do_stop(self) -> bool:
        """Let the device go."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer, self._asked = None, ()
        return True

    def do_set_caps(self, sink_caps: Any, _: Any) -> bool:
        """Learn what the planes mean."""
        self._info = GstVideo.VideoInfo.new_from_caps(sink_caps)
        self._encoding = _encoding(self._info)
        return True

    def do_transform(self, source: Any, target: Any) -> Any:
        """One picture."""
        try:
            self._renew()
        except VidstyleError as error:
            self._post(Gst.MessageType.WARNING, error)
        assert self._renderer is not None
        time = None if source.pts == Gst.CLOCK_TIME_NONE else source.pts / Gst.SECOND
        try:
            with _planes(source, self._info) as read, _planes(target, self._info, write=True) as written:
                picture = _picture(read, self._encoding)
                result = self._renderer.run(picture, time, self._encoding, rgb=len(read) == 1)
                for plane, restyled in zip(written, _arrays(result), strict=True):
                    plane[...] = restyled
        except Exception as error:  # one that got out would count as a picture made
            self._post(Gst.MessageType.ERROR, error)
            return Gst.FlowReturn.ERROR
        return Gst.FlowReturn.OK

    def _renew(self) -> None:
        """Follow the properties; where they are wrong, what runs already continues."""
        asked = self.style, self.set, self.steady, self.device
        if asked == self._asked:
            return
        self._asked = asked
        renderer = open_renderer(_style(*asked[:3]), self.device)
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = renderer

    def _post(self, kind: Any, error: Exception) -> None:
        quark, code = Gst.LibraryError.quark(), Gst.LibraryError.SETTINGS
        self.message_full(
            kind, quark, code, str(error) or repr(error), None, __file__, type(self).__name__, 0
        )


def _style(name: str, changes: str, steady: float) -> Style:
    assignments = [change.strip() for change in changes.split(";") if change.strip()]
    if steady != STYLE_STEADY_CODE:
        assignments.append(f"steady={steady}")
    return override(load_style(name), assignments)


def _encoding(info: Any) -> Encoding:
    if info.finfo.name == "RGB":
        return RGB
    site, flags = info.chroma_site, GstVideo.VideoChromaSite
    cosited_across = bool(site & flags.H_COSITED) or site == flags.UNKNOWN
    siting = SITINGS[
        ("topleft" if cosited_across else "top")
        if site & flags.V_COSITED
        else ("left" if cosited_across else "center")
    ]
    full_range = info.colorimetry.range == FULL_RANGE
    return Encoding(MATRICES.get(info.colorimetry.matrix, "bt601"), full_range, siting=siting)


@contextmanager
def _planes(buffer: Any, info: Any, write: bool = False) -> Iterator[list[np.ndarray]]:
    """The planes of a buffer where they lie: valid until the block ends."""
    is_mapped, memory = buffer.map(Gst.MapFlags.WRITE if write else Gst.MapFlags.READ)
    if not is_mapped:
        raise VidstyleError("vidstyle", "the buffer cannot be mapped")
    try:
        layout = GstVideo.buffer_get_video_meta(buffer) or info
        yield [_plane(memory.data, info, layout, number) for number in range(info.finfo.n_planes)]
    finally:
        buffer.unmap(memory)


def _plane(data: memoryview, info: Any, layout: Any, number: int) -> np.ndarray:
    stride, offset = layout.stride[number], layout.offset[number]
    if info.finfo.n_planes == 1:
        return np.ndarray((info.height, info.width, 3), np.uint8, data, offset, (stride, 3, 1))
    half = number > 0
    shape = (info.height + half) >> half, (info.width + half) >> half
    return np.ndarray(shape, np.uint8, data, offset, (stride, 1))


def _picture(planes: list[np.ndarray], encoding: Encoding) -> Picture:
    if len(planes) == 1:
        return Picture(encoding, color=planes[0])
    return Picture(encoding, luma=planes[0], chroma=(planes[1], planes[2]))


def _arrays(picture: Picture) -> list[np.ndarray]:
    """The planes of a picture in GStreamer's order."""
    if picture.color is not None:
        return [picture.color]
    assert picture.luma is not None and picture.chroma is not None
    return [picture.luma, *picture.chroma]


GObject.type_register(VidstyleElement)
__gstelementfactory__ = ("vidstyle", Gst.Rank.NONE, VidstyleElement)
