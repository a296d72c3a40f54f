"""Restyles HDR pictures on the tones of SDR, on any device."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.backend import Backend, FrameRequest, PendingPicture
from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.style import Style


@dataclass(frozen=True)
class PendingHdrPicture:
    """A picture that is being restyled on SDR tones; see `PendingPicture`."""

    request: FrameRequest
    pending: PendingPicture

    def result(self) -> Picture:
        """Wait for the picture, and return it in the transfer function that was requested."""
        return convert(self.pending.result(), self.request.encoding, self.request.rgb)


class HdrRenderer(Backend):
    """Converts HDR pictures to the tones that styles are designed for, and the results back.

    The tones and colours of `hdr_curves` let a style look like itself: its paper has diffuse white;
    highlights and wide colours stay where the style keeps tones. SDR pictures, and HDR pictures that the
    style does not change, are not converted.

    Args:
        renderer: restyles; it is closed with this one.
        is_plain: whether its style changes nothing.
    """

    def __init__(self, renderer: Backend, is_plain: bool) -> None:
        self._renderer = renderer
        self._is_plain = is_plain
        self.device_kind = renderer.device_kind

    @property
    def frames_in_flight(self) -> int:
        """See `Backend`."""
        return self._renderer.frames_in_flight

    def begin(self, request: FrameRequest) -> PendingPicture:
        """Start to restyle a picture."""
        if not self._needs_tones(request):
            return self._renderer.begin(request)
        return PendingHdrPicture(request, self._renderer.begin(_in_sdr_tones(request)))

    def restyle(self, request: FrameRequest) -> Picture:
        """Restyle a picture at once; see `Backend.restyle`."""
        if not self._needs_tones(request):
            return self._renderer.restyle(request)
        return convert(self._renderer.restyle(_in_sdr_tones(request)), request.encoding, request.rgb)

    def skip(self, request: FrameRequest) -> None:
        """See `Backend.skip`."""
        self._renderer.skip(_in_sdr_tones(request) if self._needs_tones(request) else request)

    def memory(self) -> Sequence[np.ndarray]:
        """See `Backend.memory`."""
        return self._renderer.memory()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self._is_plain = style.is_plain
        self._renderer.change_style(style)

    def cancel(self) -> None:
        """See `Backend.cancel`."""
        self._renderer.cancel()

    def close(self) -> None:
        """Close the renderer."""
        self._renderer.close()

    def _needs_tones(self, request: FrameRequest) -> bool:
        source, target = request.picture.encoding.transfer, request.encoding.transfer
        return source != target or (request.encoding.is_hdr and not self._is_plain)


def _in_sdr_tones(request: FrameRequest) -> FrameRequest:
    picture = request.picture
    return replace(
        request,
        picture=convert(picture, _sdr_tones(picture.encoding)),
        target=_sdr_tones(request.encoding),
        rgb=False,
    )


def _sdr_tones(encoding: Encoding) -> Encoding:
    """Return the encoding with SDR tones on the same grid, in floats, which are not limited to 0..1."""
    return replace(encoding, matrix="bt709", depth=0, full_range=True, transfer="sdr")
