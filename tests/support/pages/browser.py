"""Headless Chromium with software WebGL 2, controlled by the DevTools protocol."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from waiting import eventually, patience
from websockets.sync.client import ClientConnection, connect

from vidstyle.export import runner_module

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--use-fake-ui-for-media-stream",
    "--use-fake-device-for-media-stream",
    "--autoplay-policy=no-user-gesture-required",
    "--disable-background-networking",
    "--disable-background-timer-throttling",
    "--disable-renderer-backgrounding",
    "--disable-gpu-compositing",
    "--no-first-run",
    "--remote-debugging-port=0",
)

KEYS = {
    "Enter": (13, "\r"), "Escape": (27, ""), "Tab": (9, ""), "Delete": (46, ""), "ArrowLeft": (37, ""),
    "ArrowUp": (38, ""), "ArrowRight": (39, ""), "ArrowDown": (40, ""),
}  # fmt: skip
"""Codes of keys, and the text that they enter."""
MODIFIERS = {"Alt": 1, "Ctrl": 2, "Shift": 8}


class Chromium:
    """A running Chromium.

    Attributes:
        address: of its DevTools.
    """

    def __init__(self, program: str, profile: Path) -> None:
        command = [program, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
        nowhere = subprocess.DEVNULL
        self._process = subprocess.Popen(command, stdout=nowhere, stderr=nowhere)
        told = profile / "DevToolsActivePort"
        eventually(lambda: told.exists() and "\n" in told.read_text(), "Chromium does not start")
        self.address = "ws://127.0.0.1:" + told.read_text().replace("\n", "")

    def close(self) -> None:
        self._process.terminate()
        self._process.wait()


class Browser:
    """A page with separate cookies and storage."""

    def __init__(self, address: str) -> None:
        # Without pings: Chromium may not answer one while it compiles shaders in software.
        self._socket: ClientConnection = connect(address, max_size=None, compression=None, ping_interval=None)
        self._number = 0
        self.events: list[dict[str, Any]] = []
        self._session: str | None = None
        self._profile = self.call("Target.createBrowserContext")
        target = self.call("Target.createTarget", url="about:blank", **self._profile)["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method of the protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        self._socket.send(json.dumps(message))
        while True:
            answer = json.loads(self._socket.recv(patience()))
            if answer.get("id") == self._number:
                assert "error" not in answer, answer["error"]
                return answer["result"]
            self.events.append(answer)

    def download_to(self, folder: Path) -> None:
        """Save downloads to a folder without a dialog."""
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder), **self._profile)

    def run(self, body: str, **names: Any) -> Any:
        """Run the body of an async function with these named values, and return its result."""
        texts = ", ".join(json.dumps(value) for value in names.values())
        code = f"(async ({', '.join(names)}) => {{ {body} }})({texts})"
        result = self.call("Runtime.evaluate", expression=code, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]["exception"].get("description")
        return result["result"].get("value")

    def open(self, url: str) -> None:
        """Load a page."""
        self.events.clear()
        self.call("Page.navigate", url=url)
        while not any(event["method"] == "Page.loadEventFired" for event in self.events):
            self.events.append(json.loads(self._socket.recv(patience())))

    def until(self, expression: str) -> None:
        """Wait until a JavaScript expression is true."""
        eventually(lambda: self.run(f"return Boolean({expression})"), f"it never came to be: {expression}")

    def place(self, selector: str) -> tuple[float, float, float, float]:
        """Scroll an element into view, and return its center, width and height."""
        box = self.run(
            """const element = document.querySelector(selector);
            element.scrollIntoView({ block: "nearest" });
            const { left, top, width, height } = element.getBoundingClientRect();
            return [left + width / 2, top + height / 2, width, height];""",
            selector=selector,
        )
        return tuple(box)

    def mouse(self, kind: str, x: float, y: float) -> None:
        """Press, release or move the mouse: "mousePressed", "mouseReleased", "mouseMoved"."""
        held = {"button": "left", "buttons": 1, "clickCount": int(kind != "mouseMoved")}
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **held)

    def still(self, selector: str) -> tuple[float, ...]:
        """Return `place` once the element is uncovered and does not move."""
        seen: list[tuple[float, ...]] = [()]

        def is_still() -> bool:
            seen.append(self.place(selector))
            hit = """const element = document.querySelector(selector);
            const moves = (each) => each.playState === "running" && each.effect.target.contains(element);
            if (document.getAnimations().some(moves)) return false;
            return Boolean(document.elementFromPoint(x, y)?.closest(selector));"""
            x, y, *_ = seen[-1]
            return bool(self.run(hit, x=x, y=y, selector=selector)) and seen[-1] == seen[-2]

        eventually(is_still, f"{selector} does not lie open")
        return seen[-1]

    def click(self, selector: str) -> None:
        """Click on an element once it is uncovered and does not move."""
        x, y, *_ = self.still(selector)
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y)

    def drag(self, start: tuple[float, float], end: tuple[float, float], parts: int = 4) -> None:
        """Press the mouse at one point and release it at another."""
        self.mouse("mousePressed", *start)
        for part in range(1, parts + 1):
            x, y = (a + (b - a) * part / parts for a, b in zip(start, end, strict=True))
            self.mouse("mouseMoved", x, y)
        self.mouse("mouseReleased", *end)

    def press(self, *keys: str) -> None:
        """Press keys in order: letters or names, such as "a", "Enter" or "Ctrl+z"."""
        for key in keys:
            *held, name = key.split("+") if len(key) > 1 else [key]
            code, text = KEYS.get(name, (ord(name.upper()) if len(name) == 1 else 0, ""))
            what = {"key": name, "code": f"Key{name.upper()}" if name.isalpha() and len(name) == 1 else name}
            what |= {"windowsVirtualKeyCode": code, "modifiers": sum(MODIFIERS[each] for each in held)}
            self.call("Input.dispatchKeyEvent", type="keyDown" if text else "rawKeyDown", text=text, **what)
            self.call("Input.dispatchKeyEvent", type="keyUp", **what)

    def type(self, text: str) -> None:
        """Type text into the focused element, replacing the selection."""
        self.call("Input.insertText", text=text)

    def choose_file(self, selector: str, path: Path) -> None:
        """Choose a file in a file input."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        field = self.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.call("DOM.setFileInputFiles", files=[str(path)], nodeId=field)

    def close(self) -> None:
        """Close the page."""
        self._session = None
        self.call("Target.disposeBrowserContext", **self._profile)
        self._socket.close()


class StyleBrowser(Browser):
    """A page with the runner loaded."""

    def __init__(self, address: str) -> None:
        super().__init__(address)
        module = base64.b64encode(runner_module().encode()).decode()
        self.run(
            """globalThis.vidstyle = await import("data:text/javascript;base64," + module);
            globalThis.runners = [false, true].map((half) => new vidstyle.Runner({ half }));
            globalThis.bytesOf = (text) => Uint8ClampedArray.from(atob(text), (each) => each.charCodeAt(0));
            globalThis.textOf = (bytes) => {
              let text = "";
              for (let at = 0; at < bytes.length; at += 8192)
                text += String.fromCharCode(...bytes.subarray(at, at + 8192));
              return btoa(text);
            };""",
            module=module,
        )

    def restyled(self, plan: dict[str, Any], pictures: Sequence[np.ndarray], half: bool = False,
                 times: Sequence[float] | None = None) -> list[np.ndarray]:  # fmt: skip
        """Restyle pictures, H x W x 3 uint8, in order with the runner."""
        height, width = pictures[0].shape[:2]
        alpha = np.full((height, width, 1), 255, np.uint8)
        codes = [base64.b64encode(np.dstack([each, alpha]).tobytes()).decode() for each in pictures]
        texts = self.run(
            """const style = await runners[half].load(plan);
            const canvas = Object.assign(document.createElement("canvas"), { width, height });
            const context = canvas.getContext("2d", { willReadFrequently: true });
            const results = codes.map((text, number) => {
              const source = new ImageData(bytesOf(text), width, height);
              runners[half].draw(style, source, canvas, { time: times && times[number] });
              return textOf(context.getImageData(0, 0, width, height).data);
            });
            style.release();
            return results;""",
            plan=plan, half=int(half), codes=codes, width=width, height=height, times=times,
        )  # fmt: skip
        shape = height, width, 4
        return [np.frombuffer(base64.b64decode(text), np.uint8).reshape(shape)[..., :3] for text in texts]


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    """Chromium for all tests, which are skipped if it is missing."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no Chromium here")
    with closing(Chromium(program, tmp_path_factory.mktemp("profile"))) as opened:
        yield opened


@pytest.fixture(scope="module")
def style_browser(chromium: Chromium) -> Iterator[StyleBrowser]:
    """A page with the runner for all tests of a module."""
    with closing(StyleBrowser(chromium.address)) as opened:
        yield opened


@pytest.fixture(scope="module")
def browser(chromium: Chromium) -> Iterator[Browser]:
    """An empty page."""
    with closing(Browser(chromium.address)) as opened:
        yield opened
