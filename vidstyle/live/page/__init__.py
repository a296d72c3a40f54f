"""The page of a live session: the picture in a browser, and controls for all parameters."""

import vidstyle.web  # noqa: F401  # first, since it reports how to install a missing aiohttp
from vidstyle.live.page.page_target import PageTarget

__all__ = ["PageTarget"]
