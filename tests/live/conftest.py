"""Sessions and servers of small models, and a browser-less client."""

from __future__ import annotations

import http.client
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from planarc.core.options import Backend
from planarc.live.server import LiveServer
from planarc.live.session import Session
from planarc.request.request import Request

#: A rod that swings, with a bound, a whole number, a choice of structure and a start value.
SWING = """
model Swing "A rod that swings"
  parameter Modelica.Units.SI.Length L(min=0.1, max=5) = 1 "Length of the rod";
  parameter Boolean heavy = false "= true, if a second mass hangs there" annotation(Evaluate=true);
  parameter Integer n(min=1) = 2 "How many";
  final parameter Real twice = 2*L "Follows from L";
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0.5, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.FixedTranslation rod(r={L, 0});
  PlanarMultiBody.Parts.Body bob(m=n, I=0);
  PlanarMultiBody.Parts.Body second(m=1, I=0) if heavy;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
  connect(rod.frame_b, second.frame_a);
  annotation(experiment(StopTime=1, Interval=0.1, Tolerance=1e-8));
end Swing;
"""
CAM = "PlanarMultiBody.Examples.CurveCurveJoint.CamFollower"


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One place for all tests, so that what is compiled is remembered."""
    return tmp_path_factory.mktemp("live")


@pytest.fixture
def swing(folder: Path) -> Request:
    file = folder / "swing.pmo"
    file.write_text(SWING, "utf-8")
    return Request(file)


@pytest.fixture
def session(swing: Request) -> Session:
    return Session(swing, Backend.NUMPY)


@dataclass(frozen=True)
class Reply:
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)


@pytest.fixture
def server(session: Session, swing: Request) -> Iterator[LiveServer]:
    live = LiveServer(session, swing)
    live.start()
    yield live
    live.stop()


@pytest.fixture
def ask(server: LiveServer) -> Callable[..., Reply]:
    """`ask("run", {...}, headers)`: POST with a body, else GET; `path` replaces all of it."""

    def ask(
        name: str = "",
        body: Any = None,
        headers: dict[str, str] | None = None,
        path: str | None = None,
        method: str | None = None,
    ) -> Reply:
        line = http.client.HTTPConnection("127.0.0.1", server.port, timeout=300)
        sent = {"Content-Type": "application/json"} if body is not None else {}
        data = None if body is None else body if isinstance(body, bytes) else json.dumps(body)
        line.request(
            method or ("GET" if body is None else "POST"),
            f"/{server.token}/{name}" if path is None else path,
            data,
            {**sent, **(headers or {})},
        )
        reply = line.getresponse()
        found = Reply(reply.status, dict(reply.getheaders()), reply.read())
        line.close()
        return found

    return ask
