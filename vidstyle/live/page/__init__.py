"""The page of a live session: the picture in a browser, with all that can be set beside it."""

try:
    import websockets  # noqa: F401
except ImportError as error:
    raise ImportError("it needs websockets: pip install 'vidstyle[live]'") from error

from vidstyle.live.page.target import PageTarget

__all__ = ["PageTarget"]
