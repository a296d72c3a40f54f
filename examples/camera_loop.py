"""Restyles a camera until Control-C, or a film, with OpenCV: python camera_loop.py 0|in.mp4 out.mp4."""

import sys

import cv2

import vidstyle

source, target = sys.argv[1:]
capture = cv2.VideoCapture(int(source) if source.isdigit() else source)
rate = capture.get(cv2.CAP_PROP_FPS) or 25
size = (
    int(capture.get(cv2.CAP_PROP_FRAME_WIDTH)),
    int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT)),
)
writer = cv2.VideoWriter(target, cv2.VideoWriter.fourcc(*"mp4v"), rate, size)
try:
    with vidstyle.Renderer("cartoon") as renderer:
        while True:
            found, bgr = capture.read()
            if not found:
                break
            seconds = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            rgb = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
            restyled = renderer(rgb, seconds)
            writer.write(cv2.cvtColor(restyled, cv2.COLOR_RGB2BGR))
except KeyboardInterrupt:
    pass
finally:
    writer.release()
    capture.release()
