"""A web server for the program's own pages, reachable from this machine only unless asked otherwise."""

try:
    import aiohttp  # noqa: F401
except ImportError as error:
    raise ImportError("it needs aiohttp: pip install 'vidstyle[web]'") from error

from vidstyle.web.server import WebServer

__all__ = ["WebServer"]
