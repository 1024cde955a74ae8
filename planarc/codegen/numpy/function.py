"""A function of the NumPy text: values out of the workspace, statements, values back.

A block stands where it is solved:

    position loop      start, then inner unknowns, residuals and Jacobian until done
    linear block       solved at once from residuals at zero and Jacobian
    large linear one   tears from an elimination, checked by the residuals; solved as
                       above only where these are not small
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from msgspec import Struct, field

from planarc.codegen.certain import all_lets, is_hidden, is_part, taken_values
from planarc.codegen.numpy.formulas import formula, is_truth
from planarc.codegen.numpy.names import Names, comment
from planarc.core.prose import counted
from planarc.ir.expr import Expr, Op, postorder, text
from planarc.ir.program import BlockCode, Direct, Let, Program, Solve, Statement
from planarc.ir.sparse import operations_of, read_rows

_INSIDE = " " * 8

Parts = Sequence[tuple[str, tuple[Statement, ...]]]  # with titles


class Line(str):
    """A line of the text that computes an equation; -1 where a function begins."""

    equation: int

    def __new__(cls, text: str, equation: int = -1) -> Line:
        line = super().__new__(cls, text)
        line.equation = equation
        return line


class FunctionText(Struct):
    """A function of the text."""

    _program: Program
    _names: Names
    _always: set[Expr]
    _parts: Parts
    _defined: dict[Expr, None] = field(default_factory=dict)

    @property
    def _slots(self) -> Mapping[str, int]:
        return self._program.slots

    def lines(self, results: Sequence[Expr]) -> list[str]:
        body: list[str] = []
        for title, statements in self._parts:
            if title:
                body.append(f"    # {title}")
            for s in statements:
                body += [self._let(s, "    ")] if isinstance(s, Let) else self._solve(s)
        head = self._loads(results)
        tail = self._stores()
        if results:
            tail.append(f"    return {_tuple(self._names(r) for r in results)}")
        return [*head, *body, *tail] or ["    pass"]

    def lines_of(self, values: Sequence[Expr]) -> list[str]:
        """The lines for values that are formulas; nothing goes back to the workspace."""
        ((_, statements),) = self._parts
        body = [self._let(s, "    ") for s in statements if isinstance(s, Let)]
        parts = [self._formula(e) for e in values]
        return [
            *self._loads(values),
            *body,
            "    return (",
            *(f"        {p}," for p in parts),
            "    )",
        ]

    # Workspace

    def _loads(self, results: Sequence[Expr]) -> list[str]:
        """Every stored value that the function reads and does not compute, by slot."""
        statements = [s for _, part in self._parts for s in part]
        roots = [let.value for let in all_lets(self._program, statements)] + list(results)
        for s in statements:
            if isinstance(s, Solve):
                code = self._program.blocks[s.block]
                roots += taken_values(code)
                roots += code.direct.values if code.direct is not None else ()
        read = {
            self._slots[text(e)]: e
            for e in postorder(roots)
            if e.op in (Op.SYMBOL, Op.PRE, Op.EVENT)
            and e not in self._defined
            and text(e) in self._slots
        }
        return [f"    {self._leaf(e)} = w[{slot}]" for slot, e in sorted(read.items())]

    def _stores(self) -> list[str]:
        """Write back what the function computed, runs of slots at once."""
        stored = sorted((self._slots[text(e)], e) for e in self._defined if text(e) in self._slots)
        lines = []
        run: list[tuple[int, Expr]] = []
        for slot, e in stored:
            if run and slot != run[-1][0] + 1:
                lines.append(self._store(run))
                run = []
            run.append((slot, e))
        return [*lines, self._store(run)] if run else lines

    def _store(self, run: list[tuple[int, Expr]]) -> str:
        names = ", ".join(self._names(e) for _, e in run)
        first, last = run[0][0], run[-1][0]
        place = f"w[{first}]" if first == last else f"w[{first}:{last + 1}]"
        return f"    {place} = {names}"

    # Statements

    def _leaf(self, e: Expr) -> str:
        if e.op is Op.TIME:
            return "t"
        return self._names.of_loop(e.data[0]) if e.op is Op.LOOP else self._names(e)

    def _formula(self, e: Expr, careful: bool = False) -> str:
        return formula(e, self._leaf, careful=careful)

    def _let(self, let: Let, indent: str) -> str:
        target = let.target
        careful = target not in self._always and is_part(self._program, target)
        right = self._formula(let.value, careful)
        if is_truth(let.value) and text(target) in self._slots:
            if let.value.is_const:
                right = "1.0" if let.value.data else "0.0"
            else:
                right = f"1.0 if {right} else 0.0"
        self._defined[target] = None
        line = f"{indent}{self._names(target)} = {right}"
        if is_hidden(target) and let.equation is None:
            return line
        name = "" if is_hidden(target) else comment(text(target))
        if let.equation is None:
            return f"{line}  # {name}".rstrip()
        return Line(f"{line}  # e{let.equation} {name}".rstrip(), let.equation)

    def _solve(self, statement: Solve) -> list[str]:
        code = self._program.blocks[statement.block]
        self._defined.update((tear, None) for tear in code.tears)
        if not code.residuals:
            return [*self._states(statement, code), *(self._let(s, "    ") for s in code.body)]
        kind = "linear" if code.linear else "nonlinear"
        equations = ", ".join(f"e{e}" for e in code.equations)
        head = f"    # block {statement.block}, {kind}: {_count(code)}; residuals {equations}"
        write = self._linear if code.linear else self._nonlinear
        if code.direct is not None:
            write = self._direct
        return [head, *write(f"blocks[{statement.block}]", code)]

    def _linear(self, block: str, code: BlockCode) -> list[str]:
        return [
            *self._matrix(code, "    ", f"{self._tears(code)} = {block}.solve"),
            *(self._let(s, "    ") for s in code.body),
        ]

    def _direct(self, block: str, code: BlockCode) -> list[str]:
        assert code.direct is not None
        values = [self._formula(e) for e in code.direct.values]
        lines, tears = self._operations(code.direct, list(values))
        lines += self._until_done(block, f"take({tears})", code, code.body)
        more, sizes = self._sizes(code.direct, values)
        residuals = _tuple(map(self._formula, code.residuals))
        return [
            *lines,
            *more,
            f"{_INSIDE}if block.fits({residuals}, {sizes}):",
            f"{_INSIDE}    break",
            f"{_INSIDE}tears = block.pivot({_tuple(values)})",
        ]

    def _operations(self, direct: Direct, numbers: list[str]) -> tuple[list[str], str]:
        """The lines of the operations, and the tears that they give."""
        lines = []
        for k, (a, negative, factors) in enumerate(operations_of(direct)):
            value = "*".join(numbers[i] for i in factors)
            if a is None:
                value = f"-{value}" if negative else value
            else:
                sign, first = "-" if negative else "+", numbers[a]
                value = f"{first} {sign} {value}" if factors else f"1.0/{first} if {first} else nan"
            numbers.append(self._hidden(f"$o{k}"))
            lines.append(f"    {numbers[-1]} = {value}")
        return lines, _tuple(f"{'-' * (ref & 1)}{numbers[ref >> 1]}" for ref in direct.tears)

    def _sizes(self, direct: Direct, values: Sequence[str]) -> tuple[list[str], str]:
        """The lines of the sizes of all rows, and those of the residuals."""
        lines, tears = [], direct.unknowns[: len(direct.tears)]
        sizes = [f"abs({self._names(tear)})" for tear in tears]
        for k, (constant, entries) in enumerate(read_rows(direct.rows)):
            terms = [f"abs({values[v]})*{sizes[j]}" for j, v in entries]
            sizes.append(self._hidden(f"$s{k}"))
            total = " + ".join([f"abs({values[constant]})", *terms])
            lines.append(f"{_INSIDE}{sizes[-1]} = {total}")
        return lines, _tuple(sizes[-len(tears) :])

    def _hidden(self, name: str) -> str:
        return self._names(self._program.table.symbol(name))

    def _nonlinear(self, block: str, code: BlockCode) -> list[str]:
        lines = self._until_done(block, "start(t)", code, code.body[: code.inner])
        rest = (*code.body[code.inner :], *code.jacobian_body)
        lines += [self._let(s, _INSIDE) for s in rest]
        return lines + self._matrix(code, _INSIDE, "tears = block.step")

    def _until_done(
        self, block: str, start: str, code: BlockCode, inner: Iterable[Let]
    ) -> list[str]:
        """The head of a loop that gives the unknowns once more when the tears are found."""
        return [
            f"    block = {block}",
            f"    tears = block.{start}",
            "    while True:",
            f"{_INSIDE}{self._tears(code)} = tears",
            *(self._let(s, _INSIDE) for s in inner),
            f"{_INSIDE}if block.done:",
            f"{_INSIDE}    break",
        ]

    def _tears(self, code: BlockCode) -> str:
        names = ", ".join(self._names(tear) for tear in code.tears)
        return names + "," if len(code.tears) == 1 else names

    def _states(self, statement: Solve, code: BlockCode) -> list[str]:
        names = ", ".join(comment(text(tear)) for tear in code.tears)
        lines = [f"    # block {statement.block}: states {names}"]
        for tear in code.tears:
            lines.append(f"    {self._names(tear)} = w[{self._slots[text(tear)]}]")
        return lines

    def _matrix(self, code: BlockCode, indent: str, call: str) -> list[str]:
        """The call that takes residuals and Jacobian."""
        residuals = _tuple(self._names(r) for r in code.residuals)
        if code.tangent is not None:
            columns = self._columns(code, indent)
            return [*columns, f"{indent}{call}({residuals}, by_columns(columns))"]
        rows: list[list[str]] = [["0.0"] * len(code.tears) for _ in code.residuals]
        for i, j, value in code.jacobian:
            rows[i][j] = self._formula(value)
        lines = [f"{indent}{call}(", f"{indent}    {residuals},", f"{indent}    ("]
        lines += [f"{indent}        {_tuple(row)}," for row in rows]
        return [*lines, f"{indent}    ),", f"{indent})"]

    def _columns(self, code: BlockCode, indent: str) -> list[str]:
        """The Jacobian column by column."""
        assert code.tangent is not None
        n, seeds = len(code.tears), ", ".join(self._names(s) for s in code.tangent.seeds)
        deeper = indent + "    "
        self._defined.update((s, None) for s in code.tangent.seeds)
        entries = _tuple(self._formula(e) for e in code.tangent.entries)
        return [
            f"{indent}columns = []",
            f"{indent}for column in range({n}):",
            f"{deeper}seeds = [0.0]*{n}",
            f"{deeper}seeds[column] = 1.0",
            f"{deeper}{seeds}{',' if n == 1 else ''} = seeds",
            *(self._let(s, deeper) for s in code.tangent.body),
            f"{deeper}columns.append({entries})",
        ]


def _tuple(parts: Iterable[str]) -> str:
    found = list(parts)
    return f"({found[0]},)" if len(found) == 1 else f"({', '.join(found)})"


def _count(code: BlockCode) -> str:
    tears = counted(len(code.tears), "tear")
    return f"{tears}, {code.free} free" if code.height else tears
