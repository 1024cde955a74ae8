"""Who is answered, who is refused, and what a page gets."""

from __future__ import annotations

import http.client
import re
import socket
import time
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import UsageError
from planarc.live.server import LiveServer, _Handler
from planarc.live.session import Order, Session
from planarc.request.request import Request

Ask = Callable[..., Any]


def test_the_page_is_there_and_may_load_nothing_else(ask: Ask) -> None:
    page = ask()
    assert page.status == 200
    text = page.body.decode()
    assert '<h1 id="name">Swing</h1>' in text
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "connect-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert page.headers["Referrer-Policy"] == "no-referrer"
    assert not re.findall(r'(?:src|href)="(?!data:)', text)


def test_a_wrong_token_is_refused(ask: Ask, server: LiveServer) -> None:
    wrong = "A" * len(server.token)
    for path in (
        "/",
        f"/{wrong}/",
        f"/{server.token}x/",
        f"/{server.token[:-1]}/",
        "//",
        "/x/../y",
    ):
        reply = ask(path=path)
        assert reply.status == 403, path
        assert server.token not in reply.body.decode()
        assert b"Swing" not in reply.body
    assert ask(path=f"/{wrong}/run", body={}).status == 403


def test_nothing_else_is_served(ask: Ask, server: LiveServer) -> None:
    for name in ("swing.pmo", "../../etc/passwd", "%2e%2e/etc/passwd", "run/x", "favicon.ico"):
        assert ask(name).status in (403, 404), name
    assert ask("run").status == 405
    assert ask("", body={}).status == 405


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Origin": "https://127.0.0.1:{port}"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Host": "evil.example"},
        {"Host": "evil.example:{port}"},
        {"Host": "127.0.0.1"},
    ],
    ids=lambda h: " ".join(f"{k}={v}" for k, v in h.items()),
)
def test_pages_of_other_sites_are_refused(
    ask: Ask, server: LiveServer, headers: dict[str, str]
) -> None:
    """Also where the token is right, and where a name of theirs leads to this machine."""
    given = {k: v.format(port=server.port) for k, v in headers.items()}
    assert ask("run", {}, given).status == 403
    assert ask("", None, given).status == 403


def test_the_own_page_is_answered(ask: Ask, server: LiveServer) -> None:
    for name in ("127.0.0.1", "localhost"):
        place = f"{name}:{server.port}"
        headers = {"Host": place, "Origin": f"http://{place}", "Sec-Fetch-Site": "same-origin"}
        assert ask("run", {}, headers).status == 200
    # No header allows others to read it.
    assert not [h for h in ask("run", {}).headers if h.lower().startswith("access-control")]


@pytest.fixture
def framed(session: Session, swing: Request) -> Iterator[LiveServer]:
    live = LiveServer(session, swing, framed=True)
    live.start()
    yield live
    live.stop()


PANEL = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Dest": "iframe", "Sec-Fetch-Mode": "navigate"}


@pytest.mark.parametrize(
    ("name", "headers", "status"),
    [
        ("", PANEL, 200),
        ("", {**PANEL, "Host": "localhost:1"}, 200),  # a port that the editor forwards
        ("", {**PANEL, "Sec-Fetch-Dest": "empty"}, 403),
        ("", {**PANEL, "Sec-Fetch-Dest": "script"}, 403),
        ("", {**PANEL, "Host": "evil.example"}, 403),
        ("", {**PANEL, "Host": "localhost.evil.example:1"}, 403),
        ("", {**PANEL, "Origin": "http://evil.example"}, 403),
        ("events", PANEL, 403),
        ("run", {"Host": "127.0.0.1:1", "Origin": "http://127.0.0.1:1"}, 200),
        ("run", {"Host": "127.0.0.1:1", "Origin": "http://127.0.0.1:2"}, 403),
        ("run", {"Origin": "vscode-webview://a"}, 403),
        ("run", PANEL, 403),
    ],
)
def test_a_framed_page_is_for_a_panel_alone(
    framed: LiveServer, name: str, headers: dict[str, str], status: int
) -> None:
    line = http.client.HTTPConnection("127.0.0.1", framed.port, timeout=300)
    kind = {"Content-Type": "application/json"}
    sent = ("POST", b"{}", {**kind, **headers}) if name == "run" else ("GET", None, headers)
    line.request(sent[0], f"/{framed.token}/{name}", sent[1], sent[2])
    reply = line.getresponse()
    assert reply.status == status
    if status == 200 and not name:
        policy = reply.headers["Content-Security-Policy"]
        assert "frame-ancestors vscode-webview: " in policy
        assert "frame-ancestors *" not in policy
    line.close()


def test_only_the_loopback_device_listens(server: LiveServer) -> None:
    assert server._server.socket.getsockname()[0] == "127.0.0.1"
    assert len(server.token) >= 32


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"{", 400),
        (b"[]", 400),
        (b'{"values": {"L": "2"}}', 400),
        (b'{"values": [1]}', 400),
        (b'{"stop": "x"}', 400),
        (b'{"choices": {"a": 1}}', 400),
        (b"[" * 100_000, 400),
        (b'{"values": ' * 50_000, 400),
        (b'{"values": {"L": ' + b"1" * 2_000_000 + b"}}", 413),
    ],
)
def test_bodies_that_are_no_orders_are_refused(ask: Ask, body: bytes, status: int) -> None:
    assert ask("run", body).status == status
    assert ask("run", {}).status == 200  # and nothing is broken by it


def test_a_form_of_another_site_is_no_order(ask: Ask) -> None:
    """What a page may send without asking first is not understood."""
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data"):
        assert ask("run", b"{}", {"Content-Type": kind}).status == 415


def test_a_moved_value_gives_another_motion(ask: Ask) -> None:
    first, second = ask("run", {}).json, ask("run", {"values": {"L": 2.0}}).json
    assert first["problems"] == second["problems"] == []
    assert first["scene"]["tracks"] != second["scene"]["tracks"]
    assert first["curves"]["columns"] != second["curves"]["columns"]
    assert first["scene"]["box"][2] == pytest.approx(second["scene"]["box"][2] / 2, rel=0.2)


def test_files_to_keep(ask: Ask, swing: Request) -> None:
    import csv
    import io

    order = {"values": {"L": 2.0}, "time": 0.5}
    rows = list(csv.reader(io.StringIO(ask("csv", order).body.decode())))
    result = planarc.load(str(swing.file)).simulate(parameters={"L": 2.0})
    column = rows[0].index("hinge.phi [rad]")
    np.testing.assert_allclose([float(r[column]) for r in rows[1:]], result["hinge.phi"], atol=1e-6)
    report = ask("report", order)
    assert report.headers["Content-Type"].startswith("text/html")
    assert b"hinge.phi" in report.body
    svg = ElementTree.fromstring(ask("svg", order).body.decode())
    assert svg.tag.endswith("svg")
    assert not [n for n in svg.iter() if "animate" in n.tag]
    assert ask("csv", {"values": {"L": -1.0}, "starts": {"hinge.phi": 1e400}}).status == 422


def test_the_page_is_told_of_an_edit(ask: Ask, server: LiveServer, swing: Request) -> None:
    line = http.client.HTTPConnection("127.0.0.1", server.port, timeout=300)
    line.request("GET", f"/{server.token}/events?page=a")
    events = line.getresponse()
    assert events.getheader("Content-Type", "").startswith("text/event-stream")
    assert "no-transform" in events.getheader("Cache-Control", "")
    assert events.readline() == b": open\n"
    before = ask("run", {}).json["key"]
    assert swing.file is not None
    swing.file.write_text(swing.file.read_text("utf-8").replace("L(min=0.1", "L(min=0.2"), "utf-8")
    while (told := events.readline()) != b"event: edited\n":
        assert told in (b"\n", b": alive\n")
    answer = ask("run", {"known": before}).json
    assert answer["key"] != before
    (own,) = (g for g in answer["model"]["groups"] if g["title"] == "")
    assert next(f for f in own["fields"] if f["name"] == "L")["minimum"] == 0.2
    events.close()
    line.close()
    # The page is gone; the server notices, and goes on.
    _wait_for_pages(server, 0)
    assert ask("run", {}).status == 200


def test_a_page_that_connects_again_loses_no_run(server: LiveServer) -> None:
    lines = []
    for _ in range(2):
        line = http.client.HTTPConnection("127.0.0.1", server.port, timeout=300)
        line.request("GET", f"/{server.token}/events?page=a")
        lines.append((line, line.getresponse()))
    _wait_for_pages(server, 2)
    session = server.session
    for left, (line, events) in zip((1, 0), lines, strict=True):
        with session._turn(Order(page="a")) as number:
            events.close()
            line.close()
            _wait_for_pages(server, left)
            until = time.monotonic() + 300
            while not left and not session.overtaken("a", number) and time.monotonic() < until:
                time.sleep(0.05)
            assert session.overtaken("a", number) == (not left)


def _wait_for_pages(server: LiveServer, count: int) -> None:
    until = time.monotonic() + 300
    while len(server._pages) != count and time.monotonic() < until:
        time.sleep(0.05)
    assert len(server._pages) == count


def test_a_browser_that_closes_in_mid_run_harms_nobody(ask: Ask, server: LiveServer) -> None:
    import json

    body = json.dumps({"stop": 2000.0})
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        line.sendall(
            f"POST /{server.token}/run HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode()
        )
    # Nobody reads the answer. The page said good-bye; the next one does not wait for long.
    assert ask("leave", b"").status == 204
    assert ask("run", {"page": "b"}).json["problems"] == []


def test_a_port_in_use_is_named(server: LiveServer, session: Session, swing: Request) -> None:
    with pytest.raises(UsageError) as caught:
        LiveServer(session, swing, server.port)
    (found,) = caught.value.diagnostics
    assert found.code == "C280"
    assert str(server.port) in found.message
    assert "--port" in str(found.hint)


def test_a_connection_that_says_nothing_is_closed(
    server: LiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert _Handler.timeout is not None
    monkeypatch.setattr(_Handler, "timeout", 0.05)
    for said in (b"", b"GET /x HTTP/1.1\r\n"):
        with socket.create_connection(("127.0.0.1", server.port), timeout=300) as idle:
            idle.sendall(said)
            while idle.recv(1000):
                pass
