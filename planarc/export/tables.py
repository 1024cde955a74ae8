"""Tables of an exported model: its plan, first content, messages, and what else functions read.

Of a large model those that grow with it stand in the file of numbers, once for all platforms
(`MOVED`): a function that reads one finds it in the instance then.

    @px_touches    ->    a pointer of the instance
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from itertools import chain

from planarc.codegen.certain import all_lets
from planarc.codegen.native.assembly import FLAG, INT, POINTER, SELDOM, Code, Value, table
from planarc.export.image import Image
from planarc.export.pruned import FUNCTION, numbers_of
from planarc.instance.actions import endings
from planarc.instance.block import BYTE, load_narrow
from planarc.instance.plan import Own, Phase, Plan, Stale, Table, count_loops, starts_anew, swings
from planarc.instance.relations import relation_table
from planarc.instance.text import text_constant
from planarc.ir.dae import INITIAL, START_TIME, TERMINAL
from planarc.ir.expr import text
from planarc.ir.flat import StateSelect
from planarc.ir.frame import Frame, angles_of_loops, place
from planarc.ir.program import Program
from planarc.solve.contact.touches import Points
from planarc.solve.events.crossings import AHEAD, unknowns

#: The tables of large models that stand in the file, and the words that point to them there.
MOVED = {
    "pc_blocks": Own.BLOCKS,
    "px_relations": Own.OF_RELATIONS,
    "px_touches": Own.OF_TOUCHES,
    "px_system": Own.SYSTEM,
    "px_nominals": Own.NOMINALS,
    "px_quiet_slots": Own.QUIET,
}
_INSTANCE = re.compile(r"ptr %(m|frame)\b")


def take_tables(text: str) -> tuple[str, dict[int, list[int]]]:
    """The text without them; their numbers, by the words that point to them."""
    found: dict[int, list[int]] = {}
    for name, word in MOVED.items():
        found[int(word)] = numbers_of(text, name)
        text = re.sub(rf"^@{name} = .*\n?", "", text, flags=re.MULTILINE)
    return text, found


def lead(text: str) -> str:
    """The text, whose functions find them in the instance."""

    def led(function: re.Match[str]) -> str:
        body, loads = function[0], ""
        for name, word in MOVED.items():
            if f"@{name}" not in body:
                continue
            body = re.sub(rf"@{name}\b", f"%{name}", body)
            instance = _INSTANCE.search(body)
            assert instance is not None, f"{function[1]} knows no instance"
            loads += f"  %at_{name} = getelementptr inbounds i64, ptr %{instance[1]}, i64 {word}\n"
            loads += f"  %{name} = load ptr, ptr %at_{name}, align 8\n"
        return body.replace("\nentry:\n", f"\nentry:\n{loads}", 1)

    return FUNCTION.sub(led, text)


def plan_table(
    program: Program, image: Image, made: Plan, unpacked: int, slopes: bool, stored: int
) -> str:
    """`Table`, and where those arrays begin that the file of numbers does not tell of."""
    rows = image.system[2] + image.system[3] + image.system[4]
    told = [(k, at) for k, at in made.homes if not stored or k in (Own.STORED, Own.TEXT)]
    w = dict(made.homes)[Frame.W]
    numbers = counts(program) | {
        Table.WORDS: made.words,
        Table.GIVEN: len(made.given),
        Table.HELD: len(made.given),
        Table.WIDTH: rows,
        Table.WORKSPACE: w - Own.PHASE,
        Table.MARGIN: Own.MARGIN - w,
        Table.ROOM: made.room,
        Table.INDICATORS: len(program.relations) - len(image.timed),
        Table.JAMS: len(endings(program)) + 1,
        Table.PACKED: unpacked,
        Table.SLOPES: int(slopes),
        Table.STORED: stored,
        Table.SWINGS: swings(program, image.timed),
        Table.POINTERS: len(told),
    }
    return table("px_plan", (*(numbers[k] for k in Table), *(n for pair in told for n in pair)))


def counts(program: Program) -> dict[Table, int]:
    """What of it the model alone tells."""
    from planarc.solve.states.selector import open_blocks

    initial, terminal, begin = (
        program.slots.get(name, -1) for name in (INITIAL, TERMINAL, START_TIME)
    )
    return {
        Table.STATES: program.state_count,
        Table.SIZE: program.size,
        Table.OPEN: len(open_blocks(program)),
        Table.MOVED: len(program.candidates),
        Table.NOMINALS: sum(c.nominal is not None for c in program.candidates),
        Table.RELATIONS: len(program.relations),
        Table.DISCRETES: len(program.discretes),
        Table.SAMPLES: len(program.samplers),
        Table.QUIET: len(unknowns(program)),
        Table.INITIAL: initial,
        Table.TERMINAL: terminal,
        Table.BEGIN: begin,
        Table.NONLINEAR: sum(not b.linear for b in program.blocks),
        Table.TOUCHES: len(Points(program).all),
        Table.LOOPS: count_loops(program),
        Table.SWINGS: swings(program),
    }


def tables_of(program: Program, image: Image) -> tuple[str, ...]:
    """What the functions of an instance read."""
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
    angles = angles_of_loops(program)
    return (
        table("px_open", (records[i] for i in opened)),
        table("px_stay", (int(c.select is StateSelect.ALWAYS) for c in tears)),
        table("px_follow", follow),
        table("px_angles", (len(angles), *(n for pair in angles for n in pair))),
        table("px_nominals", (n for pair in nominals for n in pair)),
        table("px_system", image.system),
        table("px_wanted", (start for _, start in image.held)),
        table("px_starts", (start for _, start in image.held)),
        relation_table(program, image.timed),
    )


def image_words(
    program: Program, image: Image, made: Plan, tolerance: float, constants: Sequence[float]
) -> list[int]:
    """The words behind the pointers."""
    words = [0] * made.image
    words[Own.PHASE] = Phase.INSTANTIATED
    words[Own.STALE] = Stale.START if starts_anew(program) else Stale.ALL
    words[Own.AHEAD] = _bits(AHEAD * (image.span or 1.0))
    words[Own.TOLERANCE], words[Own.BOUND] = _bits(tolerance), _bits(image.bound)
    choice = float(image.stiff) if image.step is None else image.step
    words[Own.STOP], words[Own.STIFF] = _bits(1e300), _bits(choice)
    homes = dict(made.homes)
    near = image.states if count_loops(program) else ()
    arrays = {Own.CONSTANTS: constants[::-1], Own.Y: image.states, Own.NEAR: near,
              Own.SCALES: image.scales,
              Frame.W: _given(program, image), Frame.NUMBERS: image.numbers,
              Frame.ACCEPTED: image.accepted}  # fmt: skip
    for which, array in arrays.items():
        told = map(int, array) if which is Frame.NUMBERS else map(_bits, map(float, array))
        words[homes[which] : homes[which] + len(array)] = told
    return words[Own.PHASE :]


def _given(program: Program, image: Image) -> list[float]:
    """The workspace without what is computed before anything reads it. Unknowns stay: what solves
    for them begins there."""
    w = [float(x) for x in image.w]
    kept = {tear for block in program.blocks for tear in block.tears}
    evaluated = chain(*program.levels, program.rest)
    for let in all_lets(program, evaluated):
        slot = program.slots.get(text(let.target))
        if slot is not None and let.target not in kept:
            w[slot] = 0.0
    return w


def _bits(value: float) -> int:
    found: int = struct.unpack("<q", struct.pack("<d", value))[0]
    return found


def messages_by_number(texts: Sequence[str], together: bool) -> str:
    """The messages of assertions and the like, by their numbers from 1; `together`: one behind the
    other, which takes less code and is less easy to read."""
    c = Code("px_message", POINTER, ((POINTER, "m"), (FLAG, "number")))
    number = c.arguments[1]
    if together:
        constants = [text_constant("px_messages", "\0".join(texts))]
        count_texts(c, number, Value(c, POINTER, "@px_messages"))
    else:
        constants = [text_constant(f"px_message_{i}", text) for i, text in enumerate(texts, 1)]
        for k in range(1, len(texts) + 1):
            with c.when(number.equals(k), leaves=True):
                c.give(Value(c, POINTER, f"@px_message_{k}"))
        c.give(Value(c, POINTER, "null"))
    return "\n".join((*constants, c.text(SELDOM)))


def message_in_text() -> str:
    """The same where the file of numbers holds them."""
    c = Code("px_message", POINTER, ((POINTER, "m"), (FLAG, "number")))
    m, number = c.arguments
    count_texts(c, number, m.load(POINTER, Own.MESSAGES))
    return c.text(SELDOM)


def home_words(made: Plan) -> list[int]:
    """Where arrays begin, and how many are told of, at the end of the file."""
    return [*(n for pair in made.homes for n in pair), len(made.homes)]


def text_words(texts: Sequence[str]) -> list[int]:
    """The messages one behind the other, as words."""
    data = "".join(f"{text}\0" for text in texts).encode()
    data += bytes(-len(data) % 8)
    return list(struct.unpack(f"<{len(data) // 8}q", data))


def count_texts(c: Code, number: Value, first: Value) -> None:
    """In a function: give the text of this number, from 1."""
    left, at = c.variable(number, FLAG), c.variable(0, INT)
    again, inside, behind = c.label(), c.label(), c.label()
    c.enter(again)
    c.branch(left.get().equals(1), behind, inside)
    c.begin(inside)
    with c.when(load_narrow(c, BYTE, first, at.get()).equals(0)):
        left.set(left.get() - 1)
    at.set(at.get() + 1)
    c.jump(again)
    c.begin(behind)
    c.give(c.emit(POINTER, f"getelementptr i8, ptr {first.text}, i64 {at.get().text}"))
