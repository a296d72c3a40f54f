"""Restyles a film in a loop of PyAV: python pyav_loop.py in.mp4 out.mp4."""

import sys

import av

import vidstyle

source, target = sys.argv[1:]
with (
    av.open(source) as film,
    av.open(target, "w") as made,
    vidstyle.Renderer("ink") as renderer,
):
    screen = film.streams.video[0]
    screen.thread_type = "AUTO"
    encoder = made.add_stream("libx264", rate=screen.average_rate, pix_fmt="yuv420p")
    encoder.width, encoder.height = screen.width, screen.height
    encoder.codec_context.time_base = screen.time_base
    for tag in ("color_range", "colorspace", "color_primaries", "color_trc"):
        setattr(encoder, tag, getattr(screen, tag))
    for frame in film.decode(screen):
        made.mux(encoder.encode(renderer(frame)))
    made.mux(encoder.encode(None))
