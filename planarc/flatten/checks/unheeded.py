"""What a model says that nobody heeds: misspelt annotations, imports of nothing, self-connections,
connectors that were asked for and not connected.

In:   the root instance, all instances, the connections
Out:  warnings F226 to F228, F319

The specification lets a tool ignore annotations that it does not know, so that one misspelt letter
silently takes an experiment away. Only names that were meant for planarc are told: those near to a
known one, and settings of an experiment outside of it. Of other tools' annotations nothing is said.

Reference: Modelica Language Specification 3.6, chapter 18 (`mustBeConnected` in 18.8) and section
13.2.1.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from planarc.core.diagnostic import PlanarcError, Severity, Unconnected
from planarc.core.mend import Meant
from planarc.core.nearest import nearest
from planarc.core.prose import listed, ticked
from planarc.flatten.connect.connect import Connection
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.lookup import import_target
from planarc.flatten.tree.nodes import Element, Instance, Leaf, Session
from planarc.ir import flat, syntax

#: Settings of an experiment, in the order of the specification.
SETTINGS = ("StartTime", "StopTime", "Interval", "Tolerance")
_TEXT = re.compile(r"exper|start_?time|stop_?time", re.IGNORECASE)
#: Letters that a misspelt name must share, in their order, with the one that was meant.
_NEAR = 0.75


def check_unheeded(
    root: Instance,
    instances: Sequence[Instance],
    connections: Sequence[Connection],
    session: Session,
) -> None:
    """Warn of what has no effect in the model itself."""
    _check_experiment(root, session)
    _check_imports(root, session)
    _check_unconnected(instances, connections, session)
    _check_inputs_in_a_row(root, connections, session)
    for connection in connections:
        if connection.left == connection.right:
            name = connection.left.name
            message = f"`{name}` is connected to itself, which says nothing"
            hint = "connect it to the other part"
            session.warn("F228", message, connection.span, hint)


def _check_unconnected(
    instances: Sequence[Instance], connections: Sequence[Connection], session: Session
) -> None:
    """Connectors whose declaration says what is wrong if nothing is connected from outside."""
    if any(isinstance(w, flat.LeftOut) for w in session.warnings):
        return  # what is left out is told already, and may be what is missing here
    found: list[tuple[Instance, Instance, str]] = []  # the connector, its part, and why
    connected: dict[str, list[Connection]] = {}
    for connection in connections:
        for side in (connection.left, connection.right):
            connected.setdefault(side.name, []).append(connection)
    for instance in instances:
        owner, element = instance.parent, instance.element
        if not instance.is_connector or element is None or owner is None or owner.prefix is None:
            continue
        of_all = None if element.protected else _why_all(owner, session)
        reason = _why(element.definition.annotation, session) or of_all
        if reason is None:
            continue
        if all(_declares(owner, element, c) for c in connected.get(instance.name, ())):
            why = f": {reason.value}" if isinstance(reason, syntax.String) else ""
            found.append((instance, owner, why))
    kinds = {frozenset(connector.elements) for connector, _, _ in found}
    if len(found) == 2 and len(kinds) == 1 and not _are_of_one(found[0][1], found[1][1]):
        (first, owner, _), (other, _, _) = found
        message = f"nothing is connected to `{first.name}`, and nothing to `{other.name}`"
        hint = f"write `connect({first.name}, {other.name});`, if they belong together"
        session.warn("F319", message, owner.span, hint)
        return
    for connector, owner, why in found:
        message = f"nothing is connected to `{connector.name}`"
        if (beside := _connected_beside(connector, owner, connected)) is None:
            told, wanted = f"{message}{why}", _condition(connector) or ""
            asks = wanted.isidentifier() and wanted not in why
            mend = f"connect it, or leave out `{wanted}=true`" if asks else None
            lonely = _lonely(connector, owner, instances, connected)
            if lonely is not None and not asks:
                mend = f"write `connect({connector.name}, {lonely.name});`, if they belong together"
            session.warnings.append(
                Unconnected(
                    "F319", told, owner.span, Severity.WARNING, mend, connector=connector.name
                )
            )
            continue
        connection, end, other = beside
        message += f", but `{end.name}` to `{other.name}`"
        if said := _definition(other).comment:
            message += f' ("{said}")'
        meant = _free_beside(end, connected) or end
        hint = f"write `connect({meant.name}, {connector.name});`"
        session.warnings.append(
            flat.Misplaced(
                "F319",
                message,
                connection.span,
                Severity.WARNING,
                hint,
                component=end.parent.name if end.parent else "",
            )
        )


def _are_of_one(first: Instance, second: Instance) -> bool:
    """Whether two parts are the same one, or members of one array."""
    names = [re.sub(r"\[[\d,]+\]$", "", part.name) for part in (first, second)]
    return names[0] == names[1]


def _lonely(
    connector: Instance,
    owner: Instance,
    instances: Iterable[Instance],
    connected: Mapping[str, Sequence[Connection]],
) -> Instance | None:
    """The only connector of the kind beside a part to which nothing at all is connected, nor to any
    other one of its own part."""
    free = [
        other
        for other in instances
        if other.is_connector
        and other.element is not None
        and not other.element.protected
        and other.parent is not None
        and other.parent is not owner
        and other.parent.parent is owner.parent
        and other.parent.element is not None
        and not other.parent.element.definition.prefixes.inner
        and other.elements.keys() == connector.elements.keys()
        and not any(name.startswith(f"{other.parent.name}.") for name in connected)
    ]
    return free[0] if len(free) == 1 else None


def _connected_beside(
    connector: Instance, owner: Instance, connected: Mapping[str, Sequence[Connection]]
) -> tuple[Connection, Instance, Instance] | None:
    """A connector that is there whenever one is to which nothing is connected, and what is
    connected to it: it was taken for that one."""
    for other in _alike(connector, owner):
        condition = _condition(connector)
        if condition is None or _condition(other) != condition or other.element is None:
            continue
        for connection in connected.get(other.name, ()):
            sides = (connection.left.node, connection.right.node)
            end = sides[1] if sides[0] is other else sides[0]
            outside = not _declares(owner, other.element, connection)
            if outside and isinstance(end, Instance) and end.parent is not owner:
                return connection, end, other
    return None


def _free_beside(end: Instance, connected: Mapping[str, Sequence[Connection]]) -> Instance | None:
    """The only connector beside another one of the same kind to which nothing is connected."""
    owner = end.parent
    if owner is None or owner.parent is None:
        return None
    free = [
        other
        for other in _alike(end, owner)
        if other.element is not None
        and all(_declares(owner, other.element, c) for c in connected.get(other.name, ()))
    ]
    return free[0] if len(free) == 1 else None


def _alike(connector: Instance, owner: Instance) -> Iterable[Instance]:
    """The connectors of a component, seen from outside, that hold what one of them holds."""
    for element in owner.elements.values():
        node = element.node
        if not isinstance(node, Instance) or not node.is_connector or node is connector:
            continue
        if not element.protected and node.elements.keys() == connector.elements.keys():
            yield node


def _condition(connector: Instance) -> str | None:
    """The text of the condition under which a connector is there."""
    condition = _definition(connector).condition
    return None if condition is None else condition.span.text


def _definition(connector: Instance) -> syntax.Component:
    assert connector.element is not None
    assert isinstance(connector.element.definition, syntax.Component)
    return connector.element.definition


def _check_inputs_in_a_row(
    root: Instance, connections: Sequence[Connection], session: Session
) -> None:
    """An input that is connected to the next one past its block, whose outputs nobody takes."""
    text = root.cls.definition.span.text
    for connection in connections:
        sides = (connection.left, connection.right)
        if connection.component != root.name or not all(_is_inner_input(s.node) for s in sides):
            continue
        for side, other in (sides, sides[::-1]):
            block = side.node.parent
            assert block is not None
            outputs = [
                f"{block.name}.{name}"
                for name, element in block.elements.items()
                if isinstance(leaf := element.node, Leaf)
                and leaf.causality is syntax.Causality.OUTPUT
                and not element.protected
            ]
            if outputs and not any(re.search(rf"\b{re.escape(name)}\b", text) for name in outputs):
                message = f"`{side.name}` and `{other.name}` are both inputs, and nothing takes "
                message += f"`{outputs[0]}`: `{block.name}` does nothing"
                hint = f"write `connect({outputs[0]}, {other.name});`"
                session.warn("F319", message, connection.span, hint)
                break


def _is_inner_input(node: Leaf | Instance) -> bool:
    """Whether a connector is an input of a component."""
    if not isinstance(node, Leaf) or node.causality is not syntax.Causality.INPUT:
        return False
    return node.parent.parent is not None


def _declares(owner: Instance, element: Element, connection: Connection) -> bool:
    """Whether the class that declares a connector connects it itself, and none that extends it."""
    if connection.component != owner.name:
        return False
    spans = (part.definition.span for part in owner.layout.parts)
    home = next((s for s in spans if s.covers(element.definition.span)), None)
    return home is None or home.covers(connection.span)


def _why_all(owner: Instance, session: Session) -> syntax.Expression | None:
    """What a class, or a base of it, says of all of its connectors that others see."""
    found = (_why(part.definition.annotation, session) for part in owner.layout.parts)
    return next((reason for reason in found if reason is not None), None)


def _why(annotation: syntax.Annotation | None, session: Session) -> syntax.Expression | None:
    return binding_of(find_argument(arguments_of(annotation, _MUST, session), _MUST))


_MUST = "mustBeConnected"


def _check_experiment(root: Instance, session: Session) -> None:
    annotation = root.cls.definition.annotation
    if annotation is None or not _TEXT.search(annotation.span.text):
        return
    arguments = session.library.parse_annotation(annotation)
    for argument in _modifications(arguments):
        name = argument.name[0]
        if name == "experiment":
            continue
        if nearest(name, SETTINGS, 1, _NEAR):
            hint = f"write `experiment({nearest(name, SETTINGS, 1, _NEAR)[0]}=...)`"
            message = f"`{name}` is no annotation, but a setting of an experiment"
            session.warn("F226", message, argument.span, hint)
        elif nearest(name, ("experiment",), 1, _NEAR):
            message = f"`{name}` is no annotation that planarc knows"
            session.warn("F226", message, argument.span, Meant(name, ("experiment",)))
    for argument in _modifications(inside(find_argument(arguments, "experiment"))):
        name = argument.name[0]
        if name in SETTINGS or name.startswith("__"):
            continue
        near = nearest(name, SETTINGS, 1, _NEAR)
        meant = Meant(name, tuple(near)) if near else _setting_of(name)
        session.warn("F226", f"an experiment has no `{name}`", argument.span, meant)


#: Words in names of other tools for settings of an experiment, before the names that they mean.
_OF_OTHERS = (
    ("interval", "Interval"),
    ("step", "Interval"),
    ("tol", "Tolerance"),
    ("begin", "StartTime"),
    ("start", "StartTime"),
    ("end", "StopTime"),
    ("stop", "StopTime"),
    ("final", "StopTime"),
    ("duration", "StopTime"),
)


def _setting_of(name: str) -> str:
    meant = next((setting for word, setting in _OF_OTHERS if word in name.lower()), None)
    if meant == "Interval" and "number" in name.lower():
        return "write `Interval=...`, the time between two rows in s"
    return f"write `{meant}=...`" if meant else f"its settings are {listed(ticked(SETTINGS))}"


def _modifications(arguments: tuple[syntax.Argument, ...]) -> Iterable[syntax.ElementModification]:
    return (a for a in arguments if isinstance(a, syntax.ElementModification))


def _check_imports(root: Instance, session: Session) -> None:
    """An import of what does not exist is an error only for who uses it."""
    scope = root.scope()
    for clause in scope.part.imports:
        for path in [(*clause.path, n) for n in clause.names] or [clause.path]:
            try:
                import_target(scope, path, clause.span, clause.wildcard)
            except PlanarcError as problem:
                first = problem.diagnostics[0]
                session.warn("F227", first.message, first.span, first.hint, first.mend)
