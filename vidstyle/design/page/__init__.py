"""The page of the designer: its server, its messages and its pictures."""

from __future__ import annotations

from vidstyle.design.designer import Designer
from vidstyle.design.front_door import FrontDoor
from vidstyle.design.page.design_connection import DesignConnection
from vidstyle.design.page.design_server import DesignServer


def open_page(
    designer: Designer, port: int = 0, device: str = "auto", front: FrontDoor | None = None
) -> DesignServer:
    """Serve the page of the designer, see `DesignServer`."""
    return DesignServer(designer, DesignConnection, port, device, front)
