"""Learns a slow filter and restyles a film with it: python train_bank.py photographs/ in.mp4 out.mp4."""

import sys

import cv2
import numpy as np

import vidstyle
from vidstyle.cli import main


def smooth(picture: np.ndarray) -> np.ndarray:
    """The slow filter: takes and returns H x W x 3 uint8 RGB."""
    return cv2.bilateralFilter(picture, 9, 30, 3)


if __name__ == "__main__":
    photographs, source, target = sys.argv[1:]
    code = main(["train", "smooth.npz", "--images", photographs, "--function", "train_bank:smooth"])
    if code:
        sys.exit(code)
    with open("smooth.toml", "w") as file:
        file.write('format = 1\n\n[[background]]\nblock = "learned"\nbank = "smooth.npz"\n')
    vidstyle.render(source, target, "smooth.toml")
