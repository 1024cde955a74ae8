"""The connections of all instances, before any equation is typed.

In:   the instances
Out:  Joined   connections, and the graph of overconstrained connectors

Equations may ask for what connections give (`Connections.isRoot`, `cardinality`), so
`connect` and `Connections.*` are looked for first, through loops and structural ifs.

Reference: Modelica Language Specification 3.6, sections 9.1, 9.4 and 3.7.4.3.
"""

from __future__ import annotations

from collections import Counter

from msgspec import Struct, field

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.connect.connect import Connection, collect_connection
from planarc.flatten.connect.expand import Statement, expand_connectors
from planarc.flatten.connect.kinds import told_once
from planarc.flatten.tree.nodes import Env, Instance, Node, Session
from planarc.flatten.tree.repeated import without_repeated
from planarc.flatten.typing.comprehension import turns
from planarc.flatten.typing.connections import overconstrained_name
from planarc.flatten.values import evaluate
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat, syntax


class Branch(Data):
    """`Connections.branch(a, b)`: an edge that cannot be broken."""

    left: str
    right: str
    span: Span


class Root(Data):
    """`Connections.root(a)` or `Connections.potentialRoot(a, priority)`."""

    name: str
    priority: int | None  # None: a definite root
    span: Span


class Joined(Struct):
    """The statements of all connection equations of a model."""

    connections: list[Connection] = field(default_factory=list)
    branches: list[Branch] = field(default_factory=list)
    roots: list[Root] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)
    added: list[Node] = field(default_factory=list)  # to expandable connectors

    def cardinalities(self) -> Counter[str]:
        """The number of connections that each connector stands in."""
        return Counter(s.name for c in self.connections for s in (c.left, c.right))


def join(instances: list[Instance], session: Session) -> Joined:
    """All connections, in the order of the instances and of their text."""
    joined = Joined()
    for instance in instances:
        for index, part in enumerate(instance.layout.parts):
            for section in part.definition.sections:
                if isinstance(section, syntax.EquationSection) and not section.initial:
                    equations = without_repeated(section.equations, instance.layout, index)
                    _collect(equations, Env(instance.scope(index)), joined)
    joined.added = expand_connectors(joined.statements, instances)
    for statement in joined.statements:
        try:
            joined.connections += collect_connection(statement.node, statement.env)
        except PlanarcError as problem:
            session.keep(problem)
    session.errors[:] = told_once(session.errors)
    return joined


def _collect(equations: tuple[syntax.Equation, ...], env: Env, to: Joined) -> None:
    for equation in equations:
        try:
            _collect_one(equation, env, to)
        except PlanarcError as problem:
            env.session.keep(problem)


def _collect_one(equation: syntax.Equation, env: Env, to: Joined) -> None:
    match equation:
        case syntax.Connect():
            if env.scope.part.holds(equation):
                to.statements.append(Statement(equation, env))
        case syntax.CallEquation(call=call) if is_connection_operator(call):
            _operator(call, env, to)
        case syntax.ForEquation() if holds_connection(equation.body):
            _loop(equation, env, to)
        case syntax.IfEquation() if holds_connection(all_branches(equation)):
            _collect(_chosen(equation, env), env, to)


def all_branches(node: syntax.IfEquation) -> tuple[syntax.Equation, ...]:
    return (*(e for _, body in node.branches for e in body), *node.otherwise)


def is_connection_operator(call: syntax.Call) -> bool:
    names = call.function.names
    return len(names) == 2 and names[0] == "Connections"


def holds_connection(equations: tuple[syntax.Equation, ...]) -> bool:
    """True when a `connect` or `Connections.*` stands somewhere inside."""
    stack = list(equations)
    while stack:
        equation = stack.pop()
        if isinstance(equation, syntax.Connect):
            return True
        if isinstance(equation, syntax.CallEquation) and is_connection_operator(equation.call):
            return True
        if isinstance(equation, syntax.IfEquation):
            stack += all_branches(equation)
        elif isinstance(equation, syntax.ForEquation):
            stack += equation.body
    return False


def _loop(node: syntax.ForEquation, env: Env, to: Joined) -> None:
    errors = len(env.session.errors)
    for turn in turns(node, env):
        _collect(node.body, turn, to)
        if len(env.session.errors) > errors:
            break  # the same error would be found in each turn


def _chosen(node: syntax.IfEquation, env: Env) -> tuple[syntax.Equation, ...]:
    """The branch that counts: whether something is connected never changes."""
    for expression, body in node.branches:
        condition = evaluate.condition_of(expression, env, "the condition of `if`")
        if variability_of(condition, env.session, env.hidden) > flat.Variability.PARAMETER:
            raise error(
                "F306",
                "`connect` stands in an `if` whose condition changes",
                node.span,
                hint="what is connected stays so for a whole run, only parameters decide it: what "
                "is to catch or to let go is a contact, a clutch or a force",
            )
        if evaluate.structural_value(condition, env, "the condition of `if`"):
            return body
    return node.otherwise


def _operator(call: syntax.Call, env: Env, to: Joined) -> None:
    name = call.function.names[1]
    if name == "branch" and len(call.arguments) == 2:
        left, right = (overconstrained_name(a, env) for a in call.arguments)
        to.branches.append(Branch(left, right, call.span))
    elif name == "root" and len(call.arguments) == 1:
        to.roots.append(Root(overconstrained_name(call.arguments[0], env), None, call.span))
    elif name == "potentialRoot" and 1 <= len(call.arguments) + len(call.named) <= 2:
        place = overconstrained_name(call.arguments[0], env)
        rest = [*call.arguments[1:], *(n.value for n in call.named)]
        to.roots.append(Root(place, _priority(rest, env), call.span))
    else:
        raise error("F315", f"`{call.function}` cannot stand here like this", call.span)


def _priority(rest: list[syntax.Expression], env: Env) -> int:
    if not rest:
        return 0
    typed = env.typed(rest[0])
    value = evaluate.structural_value(typed, env, "the priority of a potential root")
    if not isinstance(value, int):
        raise error("F315", "the priority of a potential root must be an Integer", rest[0].span)
    return value
