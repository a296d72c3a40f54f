"""Restyles a picture with a style written in Python: python restyle_still.py in.jpg out.png."""

import sys

import cv2

import vidstyle

OUTLINES = {
    "format": 1,
    "background": [{"block": "luma_posterize", "levels": 5}],
    "lines": [{"block": "flow_xdog", "sigma": 1.2}],
    "ink": "#203080",
}
source, target = sys.argv[1:]
rgb = cv2.cvtColor(cv2.imread(source), cv2.COLOR_BGR2RGB)
restyled = vidstyle.stylize(rgb, vidstyle.load_style(OUTLINES))
cv2.imwrite(target, cv2.cvtColor(restyled, cv2.COLOR_RGB2BGR))
