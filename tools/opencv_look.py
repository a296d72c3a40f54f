"""Restyle a film with an effect of OpenCV: `python tools/opencv_look.py stylization clip.mp4 out.mp4`.

Used by `compare_peers.py`: OpenCV decodes, FFmpeg encodes with the same options.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

ENCODER_OPTIONS = ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt", "yuv420p"]

LOOKS: dict[str, Callable[[np.ndarray], Any]] = {
    "stylization": cv2.stylization,
    "pencilSketch": lambda frame: cv2.pencilSketch(frame)[1],
    "edgePreservingFilter": cv2.edgePreservingFilter,
    "oilPainting": lambda frame: cv2.xphoto.oilPainting(frame, 4, 1),
}


def main(look: str, source: str, target: str) -> None:
    """Restyle a film."""
    film = cv2.VideoCapture(source)
    width, height = (int(film.get(side)) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
    pixels = ["-f", "rawvideo", "-pix_fmt", "bgr24", "-s", f"{width}x{height}"]
    rate = ["-r", str(film.get(cv2.CAP_PROP_FPS))]
    command = ["ffmpeg", "-v", "error", "-y", *pixels, *rate, "-i", "-", *ENCODER_OPTIONS, target]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as encoder:
        assert encoder.stdin
        while (read := film.read())[0]:
            frame = read[1]
            encoder.stdin.write(np.ascontiguousarray(LOOKS[look](frame)).data)


if __name__ == "__main__":
    main(*sys.argv[1:4])
