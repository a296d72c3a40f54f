"""The renderer of a film, by what its pictures need: HDR, or an alpha channel to restyle."""

from __future__ import annotations

from collections.abc import Callable

from vidstyle.backend import Backend
from vidstyle.cpu.hdr_renderer import HdrRenderer
from vidstyle.cues.cue_list import CueList
from vidstyle.errors import UsageError
from vidstyle.media.options import AlphaHandling, VideoInfo
from vidstyle.style import Style


def film_renderer(
    renderer: Backend,
    style: Style | CueList,
    info: VideoInfo,
    alpha: AlphaHandling,
    open_another: Callable[[Style], Backend],
) -> Backend:
    """Return a renderer for the pictures of a film; itself, if they need nothing else.

    Args:
        renderer: restyles with the style; it is closed with the returned one.
        info: the pictures.
        alpha: what happens to the alpha channel.
        open_another: opens a renderer for another style.

    Raises:
        UsageError: alpha cannot be restyled with styles that change over time.
    """
    if info.encoding.is_hdr:
        return HdrRenderer(renderer, style.is_plain)
    if alpha == "keep" or not info.alpha:
        return renderer
    if isinstance(style, CueList):
        raise UsageError("--alpha style", "needs one style for the whole film", "use --alpha keep")
    from vidstyle.cpu.alpha_renderer import AlphaRenderer, edge_style

    edges = edge_style(style)
    return renderer if edges is None else AlphaRenderer(renderer, open_another(edges))
