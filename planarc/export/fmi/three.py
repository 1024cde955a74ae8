"""The functions of FMI 3.0, in LLVM.

All functions of the standard are there. Those for kinds of variables, clocks and derivatives
that a model of planarc does not have say so.

Reference: FMI 3.0.2, headers fmi3FunctionTypes.h and chapters 2 to 4.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value
from planarc.export.fmi.derivatives import adjoint, directional
from planarc.export.fmi.entries import (
    ALWAYS,
    ANYWHERE,
    INTEGER,
    NUMBER,
    OK,
    RUNNING,
    TRUTH,
    Entries,
    give_flag,
    indicator_count,
    nominal,
    rate,
    same_text,
    state,
)
from planarc.instance.block import BYTE, constant, plan, whole
from planarc.instance.plan import Own, Phase, Table
from planarc.ir.frame import Frame

_OTHER_KINDS = ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "UInt64")
_REFUSED = (
    *(f"fmi3{way}{kind}" for kind in (*_OTHER_KINDS, "String", "Binary", "Clock")
      for way in ("Get", "Set")),
    "fmi3GetNumberOfVariableDependencies", "fmi3GetVariableDependencies",
    "fmi3EnterConfigurationMode", "fmi3ExitConfigurationMode",
    "fmi3GetIntervalDecimal", "fmi3GetIntervalFraction", "fmi3GetShiftDecimal",
    "fmi3GetShiftFraction", "fmi3SetIntervalDecimal", "fmi3SetIntervalFraction",
    "fmi3SetShiftDecimal", "fmi3SetShiftFraction",
    "fmi3GetOutputDerivatives", "fmi3ActivateModelPartition",
)  # fmt: skip


_EXCHANGED = (
    "fmi3EnterContinuousTimeMode", "fmi3GetNumberOfContinuousStates",
    "fmi3GetNumberOfEventIndicators", "fmi3SetTime", "fmi3SetContinuousStates",
    "fmi3GetContinuousStates", "fmi3GetContinuousStateDerivatives",
    "fmi3GetNominalsOfContinuousStates", "fmi3GetEventIndicators", "fmi3CompletedIntegratorStep",
    "fmi3GetDirectionalDerivative", "fmi3GetAdjointDerivative",
)  # fmt: skip


def functions(
    delayed: bool = False, crowded: bool = False, enumerations: bool = False, integers: bool = False
) -> Entries:
    """All of them, for models with delays, variables of enumerations and `integers`, which may be
    large, or without; those of model exchange refuse what a `crowded` model has none of."""
    e = Entries(_log, delayed=delayed, crowded=crowded, warns=True)
    with e.plain("fmi3GetVersion", "", POINTER) as (c, _):
        c.give(constant(c, e.string("3.0")))
    _life(e)
    kinds = [("Float64", NUMBER, "double"), ("Int32", INTEGER, "i32"), ("Boolean", TRUTH, BYTE)]
    if enumerations:
        kinds.append(("Int64", INTEGER, INT))
    for name, kind, type in kinds:
        e.getter(f"fmi3Get{name}", kind, type, True, integers)
        e.setter(f"fmi3Set{name}", kind, type, True)
    _events(e)
    _steps(e)
    if crowded:
        e.refused(_EXCHANGED)
    else:
        _model_exchange(e)
        _derivatives(e)
    e.save("fmi3GetFMUState")
    e.restore("fmi3SetFMUState")
    e.forget("fmi3FreeFMUState")
    e.serialize("fmi3SerializeFMUState", "fmi3SerializedFMUStateSize", "fmi3DeserializeFMUState")
    e.refused((*_REFUSED, *(() if enumerations else ("fmi3GetInt64", "fmi3SetInt64"))))
    return e


def _log(c: Code, m: Value, status: Value, category: Value, message: Value) -> None:
    host, logger = m.load(POINTER, Own.HOST), m.load(POINTER, Own.LOGGER)
    given = f"ptr {host.text}, i32 {status.text}, ptr {category.text}, ptr {message.text}"
    c.line(f"call void {logger.text}({given})")


def _life(e: Entries) -> None:
    """Made, initialized, ended."""
    with e.plain(
        "px_instantiate", "ptr token, i8 logging, ptr host, ptr logger, ptr resources", POINTER
    ) as (
        c,
        a,
    ):
        token, logging, host, logger, resources = a
        right = same_text(c, token, constant(c, "px_token"))
        with c.when(~right, leaves=True):
            c.give(Value(c, POINTER, "null"))
        told = c.emit(INT, f"zext i8 {logging.text} to i64")
        c.give(c.call(POINTER, "px_new", logger, host, told, resources))
    e.names.remove("px_instantiate")
    head = "ptr name, ptr token, ptr resources, i8 visible, i8 logging"
    tails = (
        ("ModelExchange", "ptr host, ptr logger"),
        ("CoSimulation", "i8 events, i8 early, ptr required, i64 count, ptr host, ptr logger, "
                         "ptr intermediate"),
    )  # fmt: skip
    for name, tail in tails:
        with e.plain(f"fmi3Instantiate{name}", f"{head}, {tail}", POINTER) as (c, a):
            if e.crowded and name == "ModelExchange":
                c.give(Value(c, POINTER, "null"))
                continue
            own = {v.text: v for v in a}
            m = c.call(POINTER, "px_instantiate", own["%token"], own["%logging"],
                       own["%host"], own["%logger"], own["%resources"])  # fmt: skip
            with c.when(c.emit("i1", f"icmp ne ptr {m.text}, null")):
                phase = whole(c, Phase.EVENT)
                if "%events" in own:
                    used = _truth(c, own["%events"])
                    phase = c.select(used.equals(1), whole(c, Phase.PAUSE), whole(c, Phase.STEP))
                    for word, name in ((Own.EVENTS, "%events"), (Own.EARLY, "%early")):
                        m.store(_truth(c, own[name]), word)
                    m.store(own["%intermediate"], Own.UPDATE)
                m.store(phase, Own.BEGUN)
            c.give(m)
    with e.plain("fmi3InstantiateScheduledExecution", "ptr name", POINTER) as (c, _):
        c.give(Value(c, POINTER, "null"))
    with e.plain("fmi3FreeInstance", "ptr m", "void") as (c, (m,)):
        c.run("free", m)
        c.give()
    with e.entry("fmi3SetDebugLogging", "i8 on, i64 count, ptr categories"):
        pass
    times = "i8 given, double tolerance, double start, i8 stops, double stop"
    with e.entry("fmi3EnterInitializationMode", times, (Phase.INSTANTIATED,)) as (c, a):
        e.experiment(c, *a)
        e.enter(c, a[0], Phase.INITIALIZATION)
    with e.entry("fmi3ExitInitializationMode", "", (Phase.INITIALIZATION,)) as (c, (m,)):
        e.started(c, m)
    with e.entry("fmi3Terminate", "", ANYWHERE) as (c, (m,)):
        c.run("px_finish", m)
        e.enter(c, m, Phase.TERMINATED)
    with e.entry("fmi3Reset", "", ALWAYS) as (c, (m,)):
        c.run("px_reset", m)


def _derivatives(e: Entries) -> None:
    arrays = (
        "ptr unknowns, i64 count, ptr knowns, i64 number, ptr seeds, i64 some, ptr results, i64 all"
    )
    directional(e, "fmi3GetDirectionalDerivative", arrays, 2)
    adjoint(e, "fmi3GetAdjointDerivative", arrays)


def _events(e: Entries) -> None:
    name = "fmi3EnterEventMode"
    with e.entry(name, "", RUNNING) as (c, (m,)):
        steps = m.load(INT, Own.PHASE) >= Phase.STEP
        with c.when(steps & m.load(INT, Own.EVENTS).equals(0), leaves=True):
            e.fail(c, m, f"{name}: the instance was made without event mode")
        m.store(c.select(steps, whole(c, Phase.PAUSE), whole(c, Phase.EVENT)), Own.PHASE)
        m.store(whole(c, 0), Own.CALLED)
    events = (Phase.EVENT, Phase.PAUSE)
    with e.entry("fmi3EvaluateDiscreteStates", "", (Phase.INITIALIZATION, *events)):
        pass
    flags = "ptr needed, ptr ended, ptr nominals, ptr values, ptr timed, ptr next"
    with e.entry("fmi3UpdateDiscreteStates", flags, events) as (c, (m, *places)):
        anew, other, over, then = e.update(c, m)
        needed, ended, nominals, values, timed, following = places
        known = then < 1e300
        for place, truth in ((ended, over), (nominals, other), (values, anew)):
            give_flag(c, place, truth)
        give_flag(c, needed, 0)
        give_flag(c, timed, c.emit(INT, f"zext i1 {known.text} to i64"))
        following.store(c.select(known, then, 0.0))


def _model_exchange(e: Entries) -> None:
    with e.entry("fmi3EnterContinuousTimeMode", "", (Phase.EVENT,)) as (c, (m,)):
        e.mark(c, m)
        e.enter(c, m, Phase.CONTINUOUS)
    with e.entry("fmi3GetNumberOfContinuousStates", "ptr count") as (c, (_, to)):
        to.store(plan(c, Table.STATES))
    with e.entry("fmi3GetNumberOfEventIndicators", "ptr count") as (c, (_, to)):
        to.store(indicator_count(c))
    e.set_time("fmi3SetTime")
    e.set_states("fmi3SetContinuousStates")
    e.vector("fmi3GetContinuousStates", state)
    e.vector("fmi3GetContinuousStateDerivatives", rate)
    e.vector("fmi3GetNominalsOfContinuousStates", nominal)
    e.indicators("fmi3GetEventIndicators")
    with e.entry("fmi3CompletedIntegratorStep", "i8 final, ptr event, ptr ended",
                 (Phase.CONTINUOUS,)) as (c, (m, _, event, ended)):  # fmt: skip
        give_flag(c, ended, 0)
        give_flag(c, event, e.accept(c, m))


def _steps(e: Entries) -> None:
    with e.entry("fmi3EnterStepMode", "", (Phase.PAUSE,)) as (c, (m,)):
        e.enter(c, m, Phase.STEP)
    arguments = "double t, double h, i8 final, ptr event, ptr ended, ptr early, ptr last"
    with e.entry("fmi3DoStep", arguments, (Phase.STEP,)) as (c, (m, t, h, _, *flags, last)):
        for place in flags:
            give_flag(c, place, 0)
        last.store(t)
        over, early = (m.load(INT, k).equals(1) for k in (Own.OVER, Own.EARLY))
        with c.when(over & early, leaves=True):
            give_flag(c, flags[1], 1)
            give_flag(c, flags[2], 1)
            c.give(OK)
        e.step(c, m, t, h)
        now = m.load(POINTER, Frame.W).load(REAL)
        early = (now < t + h) & m.load(INT, Own.EARLY).equals(1)
        give_flag(c, flags[0], m.load(INT, Own.CALLED))
        give_flag(c, flags[1], m.load(INT, Own.OVER))
        give_flag(c, flags[2], c.emit(INT, f"zext i1 {early.text} to i64"))
        last.store(now)


def _truth(c: Code, given: Value) -> Value:
    """A truth value of the host as a whole number."""
    used = c.emit("i1", f"icmp ne {BYTE} {given.text}, 0")
    return c.emit(INT, f"zext i1 {used.text} to i64")
