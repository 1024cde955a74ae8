"""The functions of FMI 2.0, in LLVM.

All functions of the standard are there. Those that a model of planarc does not have say so.

Reference: FMI 2.0.4, headers fmi2FunctionTypes.h and chapters 2 to 4.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value
from planarc.export.fmi.derivatives import directional
from planarc.export.fmi.entries import (
    ALWAYS,
    DISCARD,
    INTEGER,
    NUMBER,
    TRUTH,
    Entries,
    give_flag,
    nominal,
    rate,
    same_text,
    state,
)
from planarc.instance.block import WORD, constant, whole
from planarc.instance.plan import Own, Phase
from planarc.ir.frame import Frame

#: Kinds of a status: `fmi2LastSuccessfulTime`, `fmi2Terminated`.
_LAST_TIME, _TERMINATED = 2, 3

_REFUSED = (
    "fmi2GetString", "fmi2SetString",
    "fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives", "fmi2CancelStep",
    "fmi2GetStatus", "fmi2GetIntegerStatus",
    "fmi2GetStringStatus",
)  # fmt: skip


_EXCHANGED = (
    "fmi2EnterEventMode", "fmi2EnterContinuousTimeMode", "fmi2NewDiscreteStates", "fmi2SetTime",
    "fmi2SetContinuousStates", "fmi2GetContinuousStates", "fmi2GetDerivatives",
    "fmi2GetNominalsOfContinuousStates", "fmi2GetEventIndicators", "fmi2CompletedIntegratorStep",
    "fmi2GetDirectionalDerivative",
)  # fmt: skip


def functions(
    delayed: bool = False, crowded: bool = False, enumerations: bool = False, integers: bool = False
) -> Entries:
    """All of them; those of model exchange refuse what a `crowded` model has none of. Variables of
    enumerations are told as integers are; other `integers` may be large."""
    e = Entries(_log, _plain, delayed, by_uri=True, crowded=crowded, warns=True)
    for name, text in (("fmi2GetVersion", "2.0"), ("fmi2GetTypesPlatform", "default")):
        with e.plain(name, "", POINTER) as (c, _):
            c.give(constant(c, e.string(text)))
    _life(e)
    for name, kind, type in (("Real", NUMBER, "double"), ("Integer", INTEGER, WORD),
                             ("Boolean", TRUTH, WORD)):  # fmt: skip
        e.getter(f"fmi2Get{name}", kind, type, False, integers)
        e.setter(f"fmi2Set{name}", kind, type, False)
    if crowded:
        e.refused(_EXCHANGED)
    else:
        _model_exchange(e)
        arrays = "ptr unknowns, i64 count, ptr knowns, i64 number, ptr seeds, ptr results"
        directional(e, "fmi2GetDirectionalDerivative", arrays, 0)
    with e.entry("fmi2DoStep", "double t, double h, i32 final", (Phase.STEP,)) as (c, given):
        m, t, h, _ = given
        e.step(c, m, t, h)
        with c.when(m.load(INT, Own.OVER).equals(1), leaves=True):
            c.give(DISCARD)
    # behind a step that was discarded: the last time, and whether the run was terminated
    with e.entry("fmi2GetRealStatus", "i32 kind, ptr value") as (c, (m, which, value)):
        with c.when(~which.equals(_LAST_TIME), leaves=True):
            e.fail(c, m, "fmi2GetRealStatus: only the last time of a step is known", DISCARD)
        value.store(m.load(POINTER, Frame.W).load(REAL))
    with e.entry("fmi2GetBooleanStatus", "i32 kind, ptr value") as (c, (m, which, value)):
        with c.when(~which.equals(_TERMINATED), leaves=True):
            e.fail(c, m, "fmi2GetBooleanStatus: only whether the run was terminated is known",
                   DISCARD)  # fmt: skip
        e.give_word(c, value, m.load(INT, Own.OVER), 0)
    e.save("fmi2GetFMUstate")
    e.restore("fmi2SetFMUstate")
    e.forget("fmi2FreeFMUstate")
    e.serialize("fmi2SerializeFMUstate", "fmi2SerializedFMUstateSize", "fmi2DeSerializeFMUstate")
    e.refused(_REFUSED)
    return e


def _plain(message: str) -> str:
    """A message in which nothing stands for an argument or a variable."""
    return message.replace("%", "%%").replace("#", "##")


def _log(c: Code, m: Value, status: Value, category: Value, message: Value) -> None:
    host, logger = m.load(POINTER, Own.HOST), m.load(POINTER, Own.LOGGER)
    given = f"ptr {host.text}, ptr @px_name, i32 {status.text}, ptr {category.text}"
    c.line(f"call void (ptr, ptr, i32, ptr, ptr, ...) {logger.text}({given}, ptr {message.text})")


def _life(e: Entries) -> None:
    """Made, initialized, ended."""
    made = "ptr name, i32 type, ptr token, ptr resources, ptr host, i32 visible, i32 logging"
    with e.plain("fmi2Instantiate", made, POINTER) as (
        c,
        (_, type, token, resources, host, _, logging),
    ):
        none = c.emit("i1", f"icmp eq ptr {host.text}, null")
        with c.when(none, leaves=True):
            c.give(Value(c, POINTER, "null"))
        right = same_text(c, token, constant(c, "px_token"))
        if e.crowded:
            right = right & c.emit("i1", f"icmp eq i32 {type.text}, 1")
        with c.when(~right, leaves=True):
            c.give(Value(c, POINTER, "null"))
        told = c.emit(INT, f"zext i32 {logging.text} to i64")
        m = c.call(POINTER, "px_new", host.load(POINTER), host.load(POINTER, 4), told, resources)
        with c.when(c.emit("i1", f"icmp ne ptr {m.text}, null")):
            steps = c.emit("i1", f"icmp eq i32 {type.text}, 1")
            phases = f"i64 {int(Phase.STEP)}, i64 {int(Phase.EVENT)}"
            m.store(c.emit(INT, f"select i1 {steps.text}, {phases}"), Own.BEGUN)
        c.give(m)
    with e.plain("fmi2FreeInstance", "ptr m", "void") as (c, (m,)):
        c.run("free", m)
        c.give()
    with e.entry("fmi2SetDebugLogging", "i32 on, i64 count, ptr categories"):
        pass
    times = "i32 given, double tolerance, double start, i32 stops, double stop"
    with e.entry("fmi2SetupExperiment", times, (Phase.INSTANTIATED,)) as (c, a):
        e.experiment(c, *a)
    with e.entry("fmi2EnterInitializationMode", "", (Phase.INSTANTIATED,)) as (c, (m,)):
        e.enter(c, m, Phase.INITIALIZATION)
    with e.entry("fmi2ExitInitializationMode", "", (Phase.INITIALIZATION,)) as (c, (m,)):
        e.started(c, m)
    with e.entry("fmi2Terminate", "") as (c, (m,)):
        c.run("px_finish", m)
        e.enter(c, m, Phase.TERMINATED)
    with e.entry("fmi2Reset", "", ALWAYS) as (c, (m,)):
        c.run("px_reset", m)


def _model_exchange(e: Entries) -> None:
    with e.entry("fmi2EnterEventMode", "", (Phase.EVENT, Phase.CONTINUOUS)) as (c, (m,)):
        e.enter(c, m, Phase.EVENT)
    with e.entry("fmi2EnterContinuousTimeMode", "", (Phase.EVENT,)) as (c, (m,)):
        e.mark(c, m)
        e.enter(c, m, Phase.CONTINUOUS)
    with e.entry("fmi2NewDiscreteStates", "ptr info", (Phase.EVENT,)) as (c, (m, info)):
        anew, other, over, then = e.update(c, m)
        known = then < 1e300
        timed = c.emit(INT, f"zext i1 {known.text} to i64")
        # needed, ended, nominals, values, timed: numbers of 4 bytes; then a time
        for place, value in enumerate((whole(c, 0), over, other, anew, timed)):
            e.give_word(c, info, value, place)
        info.store(c.select(known, then, 0.0), 3)
    e.set_time("fmi2SetTime")
    e.set_states("fmi2SetContinuousStates")
    e.vector("fmi2GetContinuousStates", state)
    e.vector("fmi2GetDerivatives", rate)
    e.vector("fmi2GetNominalsOfContinuousStates", nominal)
    e.indicators("fmi2GetEventIndicators")
    with e.entry("fmi2CompletedIntegratorStep", "i32 final, ptr event, ptr ended",
                 (Phase.CONTINUOUS,)) as (c, (m, _, event, ended)):  # fmt: skip
        give_flag(c, ended, 0, WORD)
        give_flag(c, event, e.accept(c, m), WORD)
