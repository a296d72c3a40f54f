"""vidstyle restyles moving pictures as fast as they play."""

__version__ = "0.1.0"
