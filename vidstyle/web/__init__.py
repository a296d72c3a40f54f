"""The web server for local pages, on the loopback interface unless configured otherwise."""

from vidstyle.errors import UsageError

try:
    import aiohttp  # noqa: F401
except ImportError as error:
    raise UsageError("page", "cannot be shown: it needs aiohttp", "pip install 'vidstyle[web]'") from error

from vidstyle.web.server import WebServer

__all__ = ["WebServer"]
