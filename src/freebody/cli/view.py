"""``freebody view``: a page on this computer whose sliders move a machine.

The server listens on the loopback address alone. Every address begins with a token that only the page knows, and
requests that come from other pages, or under another name of this computer, are refused.
"""

from __future__ import annotations

import hmac
import json
import secrets
import signal
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import click

from ..errors import FreebodyError
from .model import Setting, find, settings_of

LARGEST_REQUEST = 1_000_000
"""Bytes."""

HOME = "127.0.0.1"


@click.command()
@click.argument("model")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Of the page; a free one if not given."
)
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter at the start; may be repeated.")  # fmt: skip
@click.option(
    "--browser/--no-browser", "browser", default=True, help="Whether the page is opened in the browser."
)
def view(model: str, port: int, settings: tuple[tuple[str, str], ...], browser: bool) -> None:
    """Show MODEL in a page with sliders for its parameters and its start; every change gives a new motion.

    The page can be reached from this computer only. It is closed with its button or with Ctrl-C.
    """
    live = machine(model, settings)
    try:
        server = Server(live, port)
    except OSError as error:
        raise click.BadParameter(
            f"Can not listen on port {port}: {error.strerror}.", param_hint="--port"
        ) from None
    click.echo(f"{server.address}\nClose with Ctrl-C.")
    if browser:
        import webbrowser

        threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
    # Python hears the keyboard between two of its own instructions only, and one of them may be a long computation
    heard = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        server.serve_forever(poll_interval=0.1)
    finally:
        signal.signal(signal.SIGINT, heard)
        server.server_close()
    click.echo("Closed.")


def machine(model: str, settings: tuple[tuple[str, str], ...]) -> Any:
    """The live machine of a gallery name or a model file."""
    from ..formats.case import Case
    from ..formats.toml.write import toml_text
    from ..picture.page.live import Live
    from .model import FileEntry

    entry = find(model)
    system = entry.build()
    if isinstance(entry, FileEntry):
        case = entry.case
    else:
        case = Case(system, dict(entry.start), entry.until, None, dict(entry.near))
    try:
        text = toml_text(
            system, initial=case.initial, until=case.until, tolerance=case.tolerance, near=case.near
        )
    except FreebodyError as error:
        text = f"# This machine has no text: {error}\n".replace("\n", "\n# ").rstrip("# ")
    live = Live(case, text)
    live.values.update(settings_of(system, settings))
    return live


class Server(ThreadingHTTPServer):
    """Serves one live machine on the loopback address.

    Attributes
    ----------
    address : str
        Of the page, its token included.
    """

    daemon_threads = True

    def __init__(self, live: Any, port: int = 0) -> None:
        self.live = live
        self.token = secrets.token_urlsafe(24)
        super().__init__((HOME, port), Handler)
        self.names = {f"{host}:{self.server_address[1]}" for host in (HOME, "localhost")}
        self.address = f"http://{HOME}:{self.server_address[1]}/{self.token}/"


class Handler(BaseHTTPRequestHandler):
    """Answers the requests of the page."""

    server: Server
    protocol_version = "HTTP/1.1"
    timeout = 30

    def do_GET(self) -> None:
        if self._refused():
            return
        if self._asked() != "":
            self._send(404, b"No such page.", "text/plain; charset=utf-8")
            return
        from ..picture.page.live import body
        from ..picture.page.page import page

        try:
            given = self.server.live.machine()
        except FreebodyError as error:
            self._send(500, str(error).encode("utf-8"), "text/plain; charset=utf-8")
            return
        text = page(given["name"], given, body(given["name"]), live=True)
        self._send(200, text.encode("utf-8"), "text/html; charset=utf-8")

    def do_POST(self) -> None:
        if self._refused():
            return
        # a page elsewhere can send a form, but neither this type nor this origin
        if self.headers.get("Origin") is None or self.headers.get_content_type() != "application/json":
            self._send(403, b"Expected a request of the page itself.", "text/plain; charset=utf-8")
            return
        answers: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
            "motion": lambda data: self.server.live.motion(
                _mapping(data, "values"), _mapping(data, "initial"), data.get("until")
            ),
            "model": lambda data: self.server.live.change(str(data.get("text", ""))),
            "close": lambda data: {},
        }
        answer = answers.get(self._asked())
        data = self._data()
        if answer is None or data is None:
            self._send(400, b"Expected a request of the page.", "text/plain; charset=utf-8")
            return
        from ..picture.page.live import problem

        try:
            found = answer(data)
        except FreebodyError as error:
            found = problem(error)
        self._send(200, json.dumps(found).encode("utf-8"), "application/json")
        if self._asked() == "close":
            threading.Thread(target=self.server.shutdown, daemon=True).start()

    # -- parts ----------------------------------------------------------------------------------------------

    def _asked(self) -> str:
        return self.path.partition("/")[2].partition("/")[2]

    def _refused(self) -> bool:
        """Whether the request is none of the page's; it is answered then."""
        token = self.path.partition("/")[2].partition("/")[0]
        origin = self.headers.get("Origin")
        right = (
            hmac.compare_digest(token.encode("utf-8"), self.server.token.encode("utf-8"))
            and self.headers.get("Host") in self.server.names
            and (origin is None or origin.removeprefix("http://") in self.server.names)
            and self.headers.get("Sec-Fetch-Site", "none") in ("none", "same-origin")
        )
        if not right:
            self._send(403, b"Refused.", "text/plain; charset=utf-8")
        return not right

    def _data(self) -> dict[str, Any] | None:
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > LARGEST_REQUEST:
            self.close_connection = True
            return None
        try:
            data = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):  # no JSON, or lists within lists without end
            return None
        return data if isinstance(data, dict) else None

    def _send(self, code: int, content: bytes, kind: str) -> None:
        if code >= 400:  # what was sent with the request is not read
            self.close_connection = True
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("X-Frame-Options", "DENY")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing is logged: the address holds the token."""


def _mapping(data: dict[str, Any], name: str) -> dict[str, Any]:
    found = data.get(name, {})
    return found if isinstance(found, dict) else {}
