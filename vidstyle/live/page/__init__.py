"""The page of a live session: the picture in a browser, and controls for everything that can be set."""

import vidstyle.web  # noqa: F401  # first of all: it says what to install if aiohttp is missing
from vidstyle.live.page.page_target import PageTarget

__all__ = ["PageTarget"]
