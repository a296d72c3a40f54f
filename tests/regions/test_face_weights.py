"""Weights of the networks for faces, read without joblib."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import joblib
import lz4.frame
import numpy as np
import pytest

from vidstyle.regions.face_detection.face_networks import NETWORKS, weights_folder
from vidstyle.regions.face_detection.face_weights import read_weights


@pytest.mark.parametrize("name", NETWORKS)
def test_arrays_equal_those_that_joblib_reads(name: str) -> None:
    folder = weights_folder()
    assert folder is not None
    with lz4.frame.open(folder / f"{name}.lz4") as file:
        expected = joblib.load(file)
    found = read_weights(folder / f"{name}.lz4")
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected, strict=True):
        assert one.dtype == other.dtype == np.float32
        np.testing.assert_array_equal(one, other)


def test_joblib_is_not_imported() -> None:
    code = "from vidstyle.regions.face_detection.face_networks import *; load_networks(weights_folder())"
    code += "; import sys; sys.exit('joblib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_file_cannot_call_other_functions(tmp_path: Path) -> None:
    with lz4.frame.open(tmp_path / "bad.lz4", "wb") as file:
        file.write(pickle.dumps([print]))
    with pytest.raises(KeyError, match="print"):
        read_weights(tmp_path / "bad.lz4")
