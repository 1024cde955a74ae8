"""Functions of the standard called in any order, with any numbers: a status, and never a crash.

Calls at random run in a child process; `PLANARC_FUZZ` says how many.
"""

from __future__ import annotations

import ctypes
import math
import os
import platform
import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

if __name__ != "__main__":
    from tests.export.fmus import runs_here
    from tests.export.test_delays import archive as delayed
    from tests.export.test_events import archive as eventful
    from tests.export.test_fmu import Instance, archive
else:  # the child needs no models

    def runs_here(test: Callable[..., None]) -> Callable[..., None]:
        return test


CALLS = int(os.environ.get("PLANARC_FUZZ", "10000"))
ODD = (0.0, 0.01, 1.0, -1.0, 1e300, -1e300, math.inf, math.nan, 5e-324)


@runs_here
@pytest.mark.parametrize("version", (2, 3))
@pytest.mark.parametrize("model", ("four_bar", "Ball", "Stairs", "Given"))
def test_no_order_of_calls_ends_the_host(folder: Path, model: str, version: int) -> None:
    if version == 2 and platform.machine() != "x86_64":
        pytest.skip("not of FMI 2")
    made = {"four_bar": archive, "Ball": eventful}.get(model, delayed)
    path = made(folder, model, version)
    unpacked = fmpy.extract(path)
    library = next(Path(unpacked, "binaries").glob("*/*.so"))
    token = fmpy.read_model_description(path).guid
    done = subprocess.run(
        [sys.executable, __file__, str(library), token, str(version), str(CALLS)],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    calls, fine, told, steps, looks = map(int, done.stdout.split())
    assert calls == CALLS and CALLS / 100 < fine < calls
    assert told > 0  # what is refused is told to the logger
    assert version == 2 or (steps > 30 and looks > 30)


@runs_here
def test_an_instance_that_failed_leaves_the_others_alone(folder: Path) -> None:
    path = archive(folder, "four_bar")
    unpacked = fmpy.extract(path)
    one, other, alone = (Instance(path, unpacked) for _ in range(3))
    one.go(10)
    other.go(10)
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.fmu.doStep(currentCommunicationPoint=5.0, communicationStepSize=0.01)
    one.fmu.terminate()
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.fmu.doStep(currentCommunicationPoint=one.t, communicationStepSize=0.01)
    assert other.go(40) == alone.go(50)
    one.fmu.freeInstance()
    assert other.go(10) == alone.go(10)


@runs_here
@pytest.mark.parametrize("length", (0.0, -0.01, math.nan, math.inf))
def test_a_step_of_no_length_is_refused_and_the_run_goes_on(folder: Path, length: float) -> None:
    path = archive(folder, "four_bar")
    unpacked = fmpy.extract(path)
    one, alone = (Instance(path, unpacked) for _ in range(2))
    one.go(5)
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.fmu.doStep(currentCommunicationPoint=one.t, communicationStepSize=length)
    assert one.go(15) == alone.go(20)


@runs_here
def test_no_step_goes_beyond_the_stop_time(folder: Path) -> None:
    path = archive(folder, "four_bar")
    one = Instance(path, fmpy.extract(path))
    one.fmu.reset()
    one.fmu.enterInitializationMode(startTime=0.0, stopTime=0.1)
    one.fmu.exitInitializationMode()
    one.t = 0.0
    one.go(10)
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.go(1)


@runs_here
def test_what_is_not_finite_is_refused_or_leaves_no_trace(folder: Path) -> None:
    path = archive(folder, "four_bar")
    one = Instance(path, fmpy.extract(path))
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.fmu.setFloat64([one.names["rockerBody.m"]], [math.nan])
    assert all(map(math.isfinite, one.go(10)))


@runs_here
def test_bytes_of_another_model_or_broken_ones_are_no_state(folder: Path) -> None:
    path = archive(folder, "four_bar")
    one = Instance(path, fmpy.extract(path))
    state = one.fmu.getFMUState()
    kept = bytes(one.fmu.serializeFMUState(state))
    one.fmu.deserializeFMUState(kept)
    for place in (0, 8, len(kept) // 2, len(kept) - 1):
        broken = bytearray(kept)
        broken[place] ^= 1
        with pytest.raises(fmpy.fmi1.FMICallException):
            one.fmu.deserializeFMUState(bytes(broken))
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.fmu.deserializeFMUState(kept[:-8])


class _Child:
    """Calls at random of several instances; the library's path, its token, its version."""

    def __init__(self, library: str, token: str, version: int) -> None:
        self.lib, self.token, self.version = ctypes.CDLL(library), token.encode(), version
        self.random = random.Random(7)
        self.room = (ctypes.c_double * 4096)()
        self.references = (ctypes.c_uint32 * 4)()
        self.bytes = (ctypes.c_char * 100_000)()
        self.size, self.time = ctypes.c_size_t(), ctypes.c_double()
        self.saved: list[ctypes.c_void_p] = []
        self.told = 0
        tell = self._tell3 if version == 3 else self._tell2
        kinds = (ctypes.c_void_p, ctypes.c_int) if version == 3 else (
            ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)  # fmt: skip
        self.logger = ctypes.CFUNCTYPE(None, *kinds, ctypes.c_char_p, ctypes.c_char_p)(tell)
        self.host = (ctypes.c_void_p * 5)(ctypes.cast(self.logger, ctypes.c_void_p))
        times = (ctypes.c_double, *(ctypes.c_bool,) * 4, ctypes.c_void_p, ctypes.c_void_p)
        self.look = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *times)(self._look)
        self.at_work: ctypes.c_void_p | None = None  # the instance whose step looks
        self.looks = self.steps = 0
        self.instances = [self.fresh() for _ in range(3)]

    def _tell3(self, host: object, status: int, category: bytes, message: bytes) -> None:
        self.told += bool(message.decode()) and status > 0

    def _tell2(self, host: object, name: object, status: int, *texts: bytes) -> None:
        self.told += bool(texts[1].decode()) and status > 0

    def _look(self, host: object, t: float, *given: object) -> None:
        """Calls at random from within a step, and a wish to end it."""
        self.looks += 1
        m = self.at_work
        assert m is not None
        for _ in range(3):
            name, *arguments = self.random.choice(self.calls())
            call = getattr(self.lib, f"fmi3{name}")
            flag = call(m, *arguments)
            free = str(name).startswith(("Get", "Serializ", "Deserializ", "Free"))
            assert 0 <= flag <= 3 and (flag == 3 or free), (name, flag)
        if self.random.random() < 0.3:
            ctypes.c_bool.from_address(int(str(given[-2]))).value = True
            ctypes.c_double.from_address(int(str(given[-1]))).value = self.random.choice(
                (t, t + 1e-3, *ODD))  # fmt: skip

    def fresh(self) -> ctypes.c_void_p:
        zero, none = ctypes.c_bool(False), ctypes.c_void_p()
        if self.version == 2:
            make = self.lib.fmi2Instantiate
            kind = ctypes.c_int(self.random.randrange(2))
            given: tuple[object, ...] = (b"x", kind, self.token, none, self.host, 0, 0)
        elif self.random.random() < 0.5:
            make = self.lib.fmi3InstantiateModelExchange
            given = (b"x", self.token, none, zero, zero, none, self.logger)
        else:
            make = self.lib.fmi3InstantiateCoSimulation
            ways = (ctypes.c_bool(self.random.random() < 0.7) for _ in range(2))
            look = self.look if self.random.random() < 0.5 else none
            given = (b"x", self.token, none, zero, zero, *ways, none, ctypes.c_size_t(0),
                     none, self.logger, look)  # fmt: skip
        make.restype = ctypes.c_void_p
        made = ctypes.c_void_p(make(*given))
        if self.version == 3 and self.random.random() < 0.5:  # one that is at work
            number = ctypes.c_double(0.0)
            self.lib.fmi3EnterInitializationMode(made, zero, number, number, zero, number)
            self.lib.fmi3ExitInitializationMode(made)
            self.lib.fmi3EnterStepMode(made)
        return made

    def number(self) -> ctypes.c_double:
        return ctypes.c_double(self.random.choice(ODD))

    def calls(self) -> list[tuple[object, ...]]:
        """A call of each function, with other arguments each time."""
        r, room, flags = self.random, self.room, [ctypes.byref(self.room, 8 * k) for k in range(8)]
        truth = ctypes.c_bool if self.version == 3 else ctypes.c_int
        zero, some = truth(False), ctypes.c_size_t(4)
        count = ctypes.c_size_t(r.choice((0, 1, 2, 3)))
        saved = r.choice(self.saved) if self.saved else None
        counted = (some,) if self.version == 3 else ()
        vectors = {
            3: ("SetContinuousStates", "GetContinuousStates", "GetContinuousStateDerivatives",
                "GetNominalsOfContinuousStates", "GetEventIndicators"),
            2: ("SetContinuousStates", "GetContinuousStates", "GetDerivatives",
                "GetNominalsOfContinuousStates", "GetEventIndicators"),
        }[self.version]  # fmt: skip
        kinds = {3: ("Float64", "Int32", "Int64", "Boolean", "String", "Clock"),
                 2: ("Real", "Integer", "Boolean", "String")}[self.version]  # fmt: skip
        times = (truth(r.random() < 0.5), self.number(), self.number(), zero, self.number())
        state = "FMUState" if self.version == 3 else "FMUstate"
        slope = (self.references, ctypes.c_size_t(2), flags[0], ctypes.c_size_t(2), room)
        found: list[tuple[object, ...]] = [
            ("ExitInitializationMode",),
            ("EnterEventMode",),
            ("EnterContinuousTimeMode",),
            ("SetTime", self.number()),
            *((name, room, count) for name in vectors),
            ("CompletedIntegratorStep", zero, *flags[:2]),
            ("Terminate",) if r.random() < 0.1 else ("EnterEventMode",),
            ("Reset",) if r.random() < 0.5 else ("ExitInitializationMode",),
            *((f"{way}{kind}", self.references, some, room, *counted)
              for way in ("Get", "Set") for kind in kinds),
        ]  # fmt: skip
        if self.version == 3:
            found += [
                ("EnterInitializationMode", *times),
                *(("EnterStepMode",),) * 3,
                ("EvaluateDiscreteStates",),
                ("DoStep", self.number(), self.number(), zero, *flags[:4]),
                *(
                    (
                        "DoStep",
                        self.time,
                        ctypes.c_double(r.choice((0.01, 0.3, 1e-30))),
                        zero,
                        *flags[:4],
                    ),
                )
                * 3,
                ("UpdateDiscreteStates", *flags[:6]),
                ("GetDirectionalDerivative", *slope, ctypes.c_size_t(2), flags[4], some),
                ("GetAdjointDerivative", *slope, ctypes.c_size_t(2), flags[4], some),
            ]
        else:
            found += [
                ("SetupExperiment", *times),
                ("EnterInitializationMode",),
                ("DoStep", self.number(), self.number(), zero),
                ("NewDiscreteStates", room),
                ("GetDirectionalDerivative", *slope, flags[4]),
            ]
        if saved is None:
            return [*found, (f"Get{state}", ctypes.byref(self.keep()))]
        return [
            *found,
            (f"Get{state}", ctypes.byref(saved)),
            (f"Set{state}", saved),
            (f"Set{state}", ctypes.c_void_p()),
            (f"Serialize{state}", saved, self.bytes, ctypes.c_size_t(r.choice((8, 100_000)))),
            (f"Serialized{state}Size", saved, ctypes.byref(self.size)),
            (f"De{'s' if self.version == 3 else 'S'}erialize{state}", self.bytes,
             ctypes.c_size_t(r.choice((0, 8, self.size.value))), ctypes.byref(self.keep())),
        ]  # fmt: skip

    def keep(self) -> ctypes.c_void_p:
        self.saved = [s for s in self.saved if s][-20:]
        self.saved.append(ctypes.c_void_p())
        return self.saved[-1]

    def run(self, count: int) -> tuple[int, ...]:
        r, fine = self.random, 0
        for _ in range(count):
            for k in range(4):
                self.references[k] = r.choice((0, 8 * r.randrange(400), r.randrange(2**32)))
            for k in range(8):
                self.room[k] = r.choice(ODD)
            m = self.at_work = r.choice(self.instances)
            if self.version == 3:
                first = (ctypes.c_uint32 * 1)(), ctypes.c_size_t(1)
                self.lib.fmi3GetFloat64(m, *first, ctypes.byref(self.time), first[1])
            name, *given = r.choice(self.calls())
            none = r.random() < 0.01
            call = getattr(self.lib, f"fmi{self.version}{name}")
            flag = call(ctypes.c_void_p() if none else m, *given)
            assert 0 <= flag <= 3, (name, flag)
            assert not none or flag == 3, name
            fine += flag == 0
            self.steps += name == "DoStep" and flag == 0
            self.saved = [s for s in self.saved if s]
            if r.random() < 0.02:
                self.instances.remove(m)
                self.lib[f"fmi{self.version}FreeInstance"](m)
                self.instances.append(self.fresh())
        return fine, self.told, self.steps, self.looks


if __name__ == "__main__":
    child = _Child(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    print(sys.argv[4], *child.run(int(sys.argv[4])))
