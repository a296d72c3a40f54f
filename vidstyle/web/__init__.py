"""A web server for the program's own pages, reachable from this machine only unless asked otherwise."""

from vidstyle.errors import UsageError

try:
    import aiohttp  # noqa: F401
except ImportError as error:
    raise UsageError("page", "cannot be shown: it needs aiohttp", "pip install 'vidstyle[web]'") from error

from vidstyle.web.server import WebServer

__all__ = ["WebServer"]
