"""The code of an exported model: one module of LLVM, and the object made of it.

    the model's own functions          `codegen.native.printer`
    the kernel's                       `codegen.native.runtime`
    an instance's                      `export.instance`
    the interface's                    `export.fmi`
    tables of the model, its image     here

All functions but those of the interface are hidden, so that calls between them need no way
through a loader.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from planarc.codegen.native.assembly import FLAG, POINTER, REAL, Code, Value
from planarc.codegen.native.formulas import bit, declarations, formula
from planarc.codegen.native.printer import ir
from planarc.codegen.native.runtime import runtime_text
from planarc.export.image import Image
from planarc.export.instance.block import block_functions
from planarc.export.instance.start import start_functions
from planarc.export.instance.states import state_functions
from planarc.export.instance.steps import step_functions
from planarc.export.plan import Own, Phase, Plan, Stale, make_plan, rules
from planarc.ir.dae import Assertion
from planarc.ir.expr import Expr, Op
from planarc.ir.flat import StateSelect
from planarc.ir.frame import Frame, place
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.export.fmi.entries import Entries

_DECLARED = """
declare ptr @calloc(i64, i64)
declare void @free(ptr)
declare double @llvm.fabs.f64(double)
declare i32 @pc_parameters(ptr, double)
declare i32 @pc_rhs(ptr, double, ptr, ptr)
declare i32 @pc_rest(ptr, double)
declare i32 @pc_accept(ptr, double)
declare double @pc_look(ptr, ptr, i64, ptr)
declare i32 @pc_point(ptr, ptr, ptr)
declare i32 @pc_differences(ptr, ptr, ptr)
declare i32 @pc_solve(ptr, ptr, ptr, ptr, i64)
@pc_blocks = external constant [0 x i64]
"""
_PASSES = ("sroa", "simplify_cfg", "instruction_combine", "loop_rotate", "simplify_cfg")


def errors(program: Program) -> tuple[Assertion, ...]:
    """The assertions that end a run."""
    return tuple(a for a in program.assertions if not a.warning)


def message_text(assertion: Assertion) -> str:
    """The message of an assertion; what it would compute stands there as dots."""
    return "".join(p if isinstance(p, str) else "..." for p in assertion.message.parts)


def compile_library(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float, triple: str
) -> bytes:
    """The object of an exported model for a system and its processor."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        opt=1, reloc="pic", codemodel="small"
    )
    texts = (ir(program), runtime_text(), _own(program, image, entries, token, tolerance))
    whole = None
    for text in texts:
        module = llvm.parse_assembly(text)
        module.triple, module.data_layout = triple, str(machine.target_data)
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    assert whole is not None
    public = set(entries.names)
    for each in (*whole.functions, *whole.global_variables):
        if not each.is_declaration and each.linkage.name == "external" and each.name not in public:
            each.visibility = "hidden"
    whole.verify()
    _tidy(llvm, whole, machine)
    return bytes(machine.emit_object(whole))


def _tidy(llvm: Any, module: Any, machine: Any) -> None:
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options())
    manager = llvm.create_new_module_pass_manager()
    for name in _PASSES:
        getattr(manager, f"add_{name}_pass")()
    manager.run(module, builder)


def _own(program: Program, image: Image, entries: Entries, token: str, tolerance: float) -> str:
    """The module of the instance, the interface, and the model's tables."""
    made = make_plan(program, image.held, len(image.scales))
    functions = (
        *block_functions(),
        *start_functions(),
        *state_functions(),
        *step_functions(),
        _asserts(program),
        entries.text(),
    )
    tables = _tables(program, image, made, tolerance)
    name = program.name.encode("ascii", "replace").decode()
    texts = "".join(
        f'@{key} = constant [{len(value) + 1} x i8] c"{value}\\00"\n'
        for key, value in (("px_token", token), ("px_name", name))
    )
    heads = declarations() + _DECLARED
    lines = dict.fromkeys(heads.splitlines())
    return "\n".join((*lines, texts, tables, *functions))


def _table(name: str, numbers: Iterable[int]) -> str:
    row = list(numbers) or [0]
    return f"@{name} = constant [{len(row)} x i64] [{', '.join(f'i64 {n}' for n in row)}]\n"


def _tables(program: Program, image: Image, made: Plan, tolerance: float) -> str:
    from planarc.solve.states.selector import leaders_of, open_blocks

    placed = place(program)
    records = [1 + sum(map(len, placed.records[:k])) for k in range(len(placed.records))]
    opened = open_blocks(program)
    tears = [
        program.candidates[program.blocks[i].first + j]
        for i in opened
        for j in range(len(program.blocks[i].tears))
    ]
    followers = leaders_of(program)
    follow = [len(followers)]
    for i, (leader, places) in sorted(followers.items(), key=lambda pair: pair[1][0]):
        row = [places.get(j, 0) for j in range(len(program.blocks[i].tears))]
        follow += [records[i], records[leader], *row]
    nominals = [(c.slot, c.nominal) for c in program.candidates if c.nominal is not None]
    rows = image.system[2] + image.system[3] + image.system[4]
    homes = [n for pair in made.homes for n in pair]
    w = dict(made.homes)[Frame.W]
    numbers = (made.words, program.state_count, program.size, len(opened), len(made.given),
               len(made.given), image.system[1], rows, len(nominals), w - Own.PHASE,
               Own.MARGIN - w)  # fmt: skip
    return "".join(
        (
            _table("px_plan", (*map(int, numbers), len(made.homes), *homes)),
            _table("px_open", (records[i] for i in opened)),
            _table("px_stay", (int(c.select is StateSelect.ALWAYS) for c in tears)),
            _table("px_follow", follow),
            _table("px_nominals", (n for pair in nominals for n in pair)),
            _table("px_system", image.system),
            _table("px_wanted", (start for _, start in made.given)),
            _table("px_starts", (start for _, start in made.given)),
            _table("px_rules", rules(program, made.given)),
            _table("px_image", _image(program, image, made, tolerance)),
        )
    )


def _image(program: Program, image: Image, made: Plan, tolerance: float) -> list[int]:
    """The words behind the pointers."""
    words = [0] * made.words
    words[Own.PHASE], words[Own.STALE] = Phase.INSTANTIATED, Stale.ALL
    words[Own.TOLERANCE], words[Own.BOUND] = _bits(tolerance), _bits(image.bound)
    words[Own.STOP] = _bits(1e300)
    homes = dict(made.homes)
    arrays = {Own.Y: image.states, Own.SCALES: image.scales, Frame.W: image.w,
              Frame.NUMBERS: image.numbers, Frame.ACCEPTED: image.accepted}  # fmt: skip
    for which, array in arrays.items():
        for i, value in enumerate(array):
            words[homes[which] + i] = int(value) if which is Frame.NUMBERS else _bits(float(value))
    return words[Own.PHASE :]


def _bits(value: float) -> int:
    found: int = struct.unpack("<q", struct.pack("<d", value))[0]
    return found


def _asserts(program: Program) -> str:
    """Which assertion fails first, counted from 1."""
    c = Code("px_asserts", FLAG, ((POINTER, "frame"), (REAL, "t")))
    frame, t = c.arguments
    w = frame.load(POINTER, Frame.W)

    def leaf(e: Expr) -> Value:
        return t if e.op is Op.TIME else w.load(REAL, program.slots[repr(e)])

    for i, assertion in enumerate(errors(program), 1):
        truth = bit(c, formula(c, assertion.condition, leaf))
        with c.when(~truth, leaves=True):
            c.give(i)
    c.give(0)
    return c.text("noinline optnone ")
