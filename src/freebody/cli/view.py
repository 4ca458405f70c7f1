"""``freebody view``: a page on this computer whose sliders and text change a machine.

The page computes motions itself where it can (``fb.report(…, live=True)``), and asks this program for all others, and
for another machine.

The server listens on the loopback address only. Every address begins with a token that only the page knows. Requests
from other pages, or under another name of this computer, are refused.
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
from .model import Setting, find, model_argument, settings_of

LARGEST_REQUEST = 1_000_000
"""Most bytes of a request."""

HOME = "127.0.0.1"


@click.command()
@model_argument
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Port of the page; a free port if not given."
)
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter in the first motion; may be repeated.")  # fmt: skip
@click.option("--browser/--no-browser", "browser", default=True, help="Open the page in the browser.")
def view(model: str, port: int, settings: tuple[tuple[str, str], ...], browser: bool) -> None:
    """Show MODEL in a page with sliders for its parameters and initial values; every change gives a new motion.

    Behind the unit of each coordinate stands the force or torque that holds the machine at rest where it starts. A
    robot's file is read with numbers: --read symbols=masses gives sliders for masses, too.

    Only this computer can reach the page. Close it with its button or with Ctrl-C.
    """
    live = machine(model, settings)
    try:
        server = Server(live, port)
    except OSError as error:
        raise click.BadParameter(
            f"Cannot listen on port {port}: {error.strerror}.", param_hint="--port"
        ) from None
    click.echo(f"{server.address}\nClose with Ctrl-C.")
    if browser:
        import webbrowser

        threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
    # Python handles Ctrl-C only between its own instructions, and one of them may be a long computation
    handler = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        server.serve_forever(poll_interval=0.1)
    finally:
        signal.signal(signal.SIGINT, handler)
        server.server_close()
    click.echo("Closed.")


def machine(model: str, settings: tuple[tuple[str, str], ...]) -> Any:
    """Return the live machine of a gallery name or a model file."""
    from ..formats.case import Case
    from ..formats.toml.write import toml_text
    from ..picture.page.live import Live
    from .model import FileEntry

    entry = find(model, symbols="none")
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
        Address of the page, with its token.
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
        """Send the page."""
        if self._refused():
            return
        if self._name() != "":
            self._send(404, b"No such page.", "text/plain; charset=utf-8")
            return
        from ..picture.page.live import body
        from ..picture.page.page import page

        try:
            data = self.server.live.machine()
        except FreebodyError as error:
            self._send(500, str(error).encode("utf-8"), "text/plain; charset=utf-8")
            return
        text = page(data["name"], data, body(data["name"]), view=True)
        self._send(200, text.encode("utf-8"), "text/html; charset=utf-8")

    def do_POST(self) -> None:
        """Send the answer to a request of the page: a motion, another machine, or the end."""
        if self._refused():
            return
        # another page can send a form, but neither with this type nor from this origin
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
        answer = answers.get(self._name())
        data = self._data()
        if answer is None or data is None:
            self._send(400, b"Expected a request of the page.", "text/plain; charset=utf-8")
            return
        from ..picture.page.live import problem
        from ..picture.page.packing import packed

        try:
            result = answer(data)
        except FreebodyError as error:
            result = problem(error)
        self._send(200, packed(result).encode("ascii"), "text/plain; charset=utf-8")
        if self._name() == "close":
            threading.Thread(target=self.server.shutdown, daemon=True).start()

    # -- parts ----------------------------------------------------------------------------------------------

    def _name(self) -> str:
        """Part of the address after the token."""
        return self.path.partition("/")[2].partition("/")[2]

    def _refused(self) -> bool:
        """Answer a request that does not come from the page; return True for such a request."""
        token = self.path.partition("/")[2].partition("/")[0]
        origin = self.headers.get("Origin")
        allowed = (
            hmac.compare_digest(token.encode("utf-8"), self.server.token.encode("utf-8"))
            and self.headers.get("Host") in self.server.names
            and (origin is None or origin.removeprefix("http://") in self.server.names)
            and self.headers.get("Sec-Fetch-Site", "none") in ("none", "same-origin")
        )
        if not allowed:
            self._send(403, b"Refused.", "text/plain; charset=utf-8")
        return not allowed

    def _data(self) -> dict[str, Any] | None:
        """Data of a request, or None if it is too large or no JSON object."""
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > LARGEST_REQUEST:
            self.close_connection = True
            return None
        try:
            data = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):  # no JSON, or too deeply nested
            return None
        return data if isinstance(data, dict) else None

    def _send(self, code: int, content: bytes, kind: str) -> None:
        if code >= 400:  # the rest of the request is not read
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
        """Log nothing: the address contains the token."""


def _mapping(data: dict[str, Any], name: str) -> dict[str, Any]:
    value = data.get(name, {})
    return value if isinstance(value, dict) else {}
