"""A server for the live page, and for nobody else.

Every address begins with a token that only the one knows who started the server; it listens on
the loopback device alone. A request that another site's page makes, or one that reached this
machine by another name (DNS rebinding), is refused before anything is looked at. A `framed`
page may stand in the panel of an editor, which may forward the port: then its frame is filled
from elsewhere, and this machine may be asked under any port. Orders still come from the page.

    GET  /TOKEN/           the page
    POST /TOKEN/run        an order (see `session`); the motion, or what is wrong
    POST /TOKEN/drag       a place of the pointer that drags a part; the poses of all
    POST /TOKEN/report, /TOKEN/csv, /TOKEN/svg       the same, as a file to keep
    GET  /TOKEN/events     tells when a file was edited (server-sent events)
    POST /TOKEN/leave      the page was closed

The HTTP is werkzeug's (one pure package and MarkupSafe, of the Pallets project): its server
speaks HTTP/1.1 with a thread for each connection, which is what one page on one machine needs.
"""

from __future__ import annotations

import hmac
import io
import json
import re
import secrets
from collections.abc import Callable, Iterator, Mapping
from queue import Empty, Queue
from threading import Thread
from typing import TYPE_CHECKING, Any, TypeVar

from msgspec import convert
from msgspec.json import encode
from msgspec.structs import replace
from werkzeug.exceptions import BadRequest, HTTPException, UnsupportedMediaType
from werkzeug.serving import BaseWSGIServer, WSGIRequestHandler, make_server
from werkzeug.wrappers import Request, Response

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, usage_error
from planarc.live.page import live_page
from planarc.live.session import Drag, Order, Overtaken, Session
from planarc.live.watch import Watch
from planarc.request import request as requests
from planarc.view.picture.camera import fit_camera
from planarc.view.picture.motion import still
from planarc.view.picture.svg import render_svg
from planarc.view.scene import make_scene
from planarc.view.storage import shown
from planarc.view.table import csv as table_csv

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.flatten.library.library import Library

Asked = TypeVar("Asked")

HOST = "127.0.0.1"
#: The most bytes of an order.
_MOST = 1_000_000
#: This machine, under any port.
_LOOPBACK = re.compile(r"(127\.0\.0\.1|localhost)(:\d{1,5})?")
#: Seconds between two signs of life to a page; a page that is gone is noticed by them.
_BEAT = 1.0

_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


class LiveServer:
    """A server of one session until `stop`. Raises UsageError C280 where the port is taken."""

    def __init__(
        self, session: Session, request: requests.Request, port: int = 0, framed: bool = False
    ) -> None:
        self.session = session
        self._framed = framed
        self.token = secrets.token_urlsafe(24)
        self._pages: list[tuple[str, Queue[str]]] = []  # a page that connects again has two
        try:
            self._server = _listen(port, self._application)
        except OSError as problem:
            reason = getattr(problem, "strerror", None) or "it is in use"
            raise usage_error(
                "C280",
                f"cannot listen on port {port}: {str(reason).lower()}",
                hint="choose another one with `--port`, or leave it out",
            ) from None
        self.port = self._server.port
        self._watch = Watch(request, self._edited)
        self._thread: Thread | None = None

    @property
    def address(self) -> str:
        return f"http://{HOST}:{self.port}/{self.token}/"

    def serve(self) -> None:
        """Serve until `stop` is called from elsewhere, or Ctrl-C."""
        self._server.serve_forever(poll_interval=0.1)

    def start(self) -> None:
        """Serve in a thread."""
        self._thread = Thread(target=self.serve, name="planarc serve", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._watch.stop()
        self._tell("end")
        if self._thread is not None:
            self._server.shutdown()
            self._thread.join()
        self._server.server_close()

    def follow(
        self,
        request: requests.Request,
        model: Model | None = None,
        library: Library | None = None,
    ) -> None:
        """Show another edition of the model from now on."""
        self.session.reload(request, model, library)
        self._tell("edited")

    def _edited(self) -> None:
        self.session.reload()
        self._tell("edited")

    def _tell(self, event: str) -> None:
        for _, events in tuple(self._pages):
            events.put(event)

    # Requests

    def _application(self, environ: dict[str, Any], start: Callable[..., Any]) -> Any:
        request = Request(environ)
        request.max_content_length = _MOST
        try:
            response = self._refusal(request) or self._route(request)
        except HTTPException as problem:
            response = _plain(problem.code or 400, problem.name)
        response.headers.update({k: v for k, v in _HEADERS.items() if k not in response.headers})
        return response(environ, start)

    def _refusal(self, request: Request) -> Response | None:
        """The refusal, 403, of whoever is not the page."""
        host = request.headers.get("Host", "")
        names = {f"{HOST}:{self.port}", f"localhost:{self.port}"}
        if self._framed and _LOOPBACK.fullmatch(host):
            names = {host}
        if host not in names:
            return _plain(403, "this server answers to the loopback address only")
        origin = request.headers.get("Origin")
        if origin is not None and origin not in {f"http://{n}" for n in names}:
            return _plain(403, "another site's page may not ask this server")
        site = request.headers.get("Sec-Fetch-Site", "none")
        if site not in ("same-origin", "none") and not self._fills_frame(request):
            return _plain(403, "another site's page may not ask this server")
        given = request.path.split("/")[1]
        if not hmac.compare_digest(given.encode(), self.token.encode()):
            return _plain(403, "wrong token: open the whole address that `planarc serve` printed")
        return None

    def _fills_frame(self, request: Request) -> bool:
        """True where the page is asked for by the frame that an editor has for it."""
        page = request.method == "GET" and request.path.split("/")[2:] == [""]
        return self._framed and page and request.headers.get("Sec-Fetch-Dest") == "iframe"

    def _route(self, request: Request) -> Response:
        name = request.path.removeprefix(f"/{self.token}").removeprefix("/")
        known: Mapping[str, tuple[str, Callable[[Request], Response]]] = {
            "": ("GET", self._page),
            "events": ("GET", self._events),
            "run": ("POST", self._run),
            "report": ("POST", self._report),
            "csv": ("POST", self._csv),
            "svg": ("POST", self._svg),
            "drag": ("POST", self._drag),
            "leave": ("POST", self._leave),
        }
        if name not in known:
            return _plain(404, "there is nothing here")
        method, answer = known[name]
        if request.method != method:
            return _plain(405, f"use {method}")
        return answer(request)

    def _page(self, request: Request) -> Response:
        text, policy = live_page(self.session.name, self.session.description, self._framed)
        return Response(text, mimetype="text/html", headers={"Content-Security-Policy": policy})

    def _run(self, request: Request) -> Response:
        try:
            answer = self.session.answer(_order(request))
        except Overtaken:
            answer = {"overtaken": True}
        return _json(answer)

    def _drag(self, request: Request) -> Response:
        drag = _read(request, Drag)
        return _json(self.session.drag(replace(drag, page=drag.page[:100])))

    def _leave(self, request: Request) -> Response:
        self.session.leave(request.get_data(as_text=True)[:100])
        return Response(status=204)

    def _events(self, request: Request) -> Response:
        name = request.args.get("page", "")[:100]
        page = name, Queue[str]()
        self._pages.append(page)

        def lines() -> Iterator[str]:
            try:
                yield ": open\n\n"
                while True:
                    try:
                        event = page[1].get(timeout=_BEAT)
                    except Empty:
                        yield ": alive\n\n"
                        continue
                    yield f"event: {event}\ndata:\n\n"
                    if event == "end":
                        return
            finally:  # the page is gone: writing to it failed
                self._pages.remove(page)
                if name not in (other for other, _ in self._pages):  # it did not connect again
                    self.session.leave(name)

        # What forwards the port must hand each line on: it may not pack them together.
        headers = {"Cache-Control": "no-store, no-transform"}
        return Response(lines(), mimetype="text/event-stream", headers=headers)

    # Files

    def _report(self, request: Request) -> Response:
        return self._file(request, "text/html", lambda result: result.animate().text.encode())

    def _csv(self, request: Request) -> Response:
        def write(result: Any) -> bytes:
            file = io.BytesIO()
            columns = [c for c in shown(result.rows.program) if not c.constant]
            table_csv.write(file, result.rows, columns, units=True)
            return file.getvalue()

        return self._file(request, "text/csv", write)

    def _svg(self, request: Request) -> Response:
        asked = _read(request, _Picture)

        def draw(result: Any) -> bytes:
            scene = make_scene(result.rows)
            within = min(max(asked.time or 0.0, float(scene.time[0])), float(scene.time[-1]))
            camera = fit_camera(scene.box, 960)
            return render_svg(still(scene, within), camera, result.name, bool(asked.dark)).encode()

        return self._file(request, "image/svg+xml", draw)

    def _file(self, request: Request, kind: str, write: Callable[[Any], bytes]) -> Response:
        try:
            return Response(write(self.session.result(_order(request))), mimetype=kind)
        except Overtaken:
            return _plain(409, "overtaken")
        except PlanarcError as problem:
            return _plain(422, "\n".join(d.message for d in problem.diagnostics))


def _listen(port: int, application: Any) -> BaseWSGIServer:
    """A server of werkzeug's; it writes no log, and says by itself nothing when a port is taken."""
    import os
    import socket

    # Bound here, since werkzeug would print, and end the process, where the port is taken.
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if os.name != "nt":  # there it would share the port with another server
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((HOST, port))
        listener.listen(64)
        return make_server(
            HOST, port, application, threaded=True, request_handler=_Handler,
            fd=listener.fileno(),
        )  # fmt: skip
    finally:
        listener.close()


class _Handler(WSGIRequestHandler):
    """A handler that writes no log: addresses hold the token."""

    protocol_version = "HTTP/1.1"
    timeout = 60  # seconds in which a connection must say or take something

    def log(self, type: str, message: str, *args: Any) -> None:
        pass


class _Picture(Data):
    """The instant of a picture, and its ground."""

    time: float | None = None
    dark: Any = False


def _order(request: Request) -> Order:
    order = _read(request, Order)
    return replace(order, page=order.page[:100])


def _read(request: Request, kind: type[Asked]) -> Asked:
    """The order in a request; 400 where it is not of that kind."""
    if request.mimetype != "application/json":
        raise UnsupportedMediaType
    try:
        return convert(json.loads(request.get_data()), kind)
    except (ValueError, RecursionError):  # nested too deeply
        raise BadRequest from None


def _json(value: Any) -> Response:
    """The data with null in the place of infinity, which JSON does not know."""
    return Response(encode(value, enc_hook=float), mimetype="application/json")


def _plain(status: int, text: str) -> Response:
    return Response(text + "\n", status=status, mimetype="text/plain")
