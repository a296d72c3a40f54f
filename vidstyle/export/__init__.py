"""Write a style for other programs: browsers, mpv, FFmpeg."""

from __future__ import annotations

from pathlib import Path

RUNNER = Path(__file__).with_name("runner.js")
"""The JavaScript module that runs plans in a browser."""
