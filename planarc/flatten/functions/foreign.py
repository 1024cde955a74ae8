"""External functions: which of planarc's own stands for one, and what it is called with.

In:   the `external` clause of a function class
Out:  ExternalCall   a name, expressions of the inputs, the outputs that it sets

Elementary functions (`external "builtin" y = sin(x)`) are planarc's built-ins. Others
that it knows are in `planarc.runtime.external`. Their outputs may stand among the arguments, as
in C; scratch arrays are left out.

Example, with the outputs `info` and `a`, and `work` a protected array:
    external "C" info = fft(u, size(u, 1), work, a)
becomes  ExternalCall("fft", (u, size(u, 1)), ("info", "a"))

Reference: Modelica Language Specification 3.6, section 12.9.
"""

from __future__ import annotations

from planarc.core.data import Data
from planarc.flatten.functions.order import names_in
from planarc.flatten.refusal import unsupported
from planarc.flatten.tree.nodes import Env, Instance, Scope, Session, Signature
from planarc.flatten.values import compute
from planarc.flatten.values.foreign import LOAD_RESOURCE
from planarc.ir import flat, syntax
from planarc.runtime import external


class Clause(Data):
    """An `external` clause and the scope that its names are looked up in."""

    node: syntax.External
    scope: Scope
    function: str

    @property
    def name(self) -> str:
        return self.node.function or self.function


class ExternalCall(Data):
    name: str | None
    given: flat.Expressions = ()
    results: tuple[str, ...] = ()


NOTHING = ExternalCall(None)


def external_clause(instance: Instance) -> Clause | None:
    """The clause of a function or of one that it extends."""
    for index, part in enumerate(instance.layout.parts):
        composition = part.definition.composition
        if composition is not None and composition.external is not None:
            return Clause(composition.external, instance.scope(index), part.definition.name)
    return None


def external_call(clause: Clause, names: flat.Named, signature: Signature) -> ExternalCall:
    """The call that stands for an external function. Raises PlanarcError when there is none."""
    node, name = clause.node, clause.name
    if compute.scalar(name):
        wanted = [v.name for v in signature.inputs]
        given = [a.parts[0].name for a in node.arguments if isinstance(a, syntax.Ref)]
        if given == wanted or not node.arguments:
            signature.builtin = name
        return ExternalCall(name)
    if name != LOAD_RESOURCE and not external.is_known(name):
        language = node.language or "C"
        raise unsupported(f'the external "{language}" function `{name}`', "12.9", node.span)
    if name in external.SILENT:
        _tell_missed(external.SILENT[name], node, clause.scope.session)
    return _matched(clause, names, signature)


def _tell_missed(what: str, node: syntax.External, session: Session) -> None:
    message = f"planarc {what}"
    if all(w.message != message for w in session.warnings):
        session.warn("F289", message, node.span)


def _matched(clause: Clause, names: flat.Named, signature: Signature) -> ExternalCall:
    """The arguments told apart: expressions of inputs, outputs, scratch variables."""
    node = clause.node
    outputs = {v.name for v in signature.outputs}
    scratch = names.keys() - outputs - {v.name for v in signature.inputs}
    if node.function is None:  # the inputs, and the one output that there may be (12.9)
        inputs = tuple(names[v.name] for v in signature.inputs)
        return ExternalCall(clause.name, inputs, tuple(v.name for v in signature.outputs))
    results = [] if node.result is None else [node.result.parts[0].name]
    given = []
    env = Env(clause.scope, names, signature)
    for argument in node.arguments:
        if isinstance(argument, syntax.Ref) and argument.names[0] in outputs:
            results.append(argument.names[0])
        elif scratch.isdisjoint(names_in(argument)):
            given.append(env.typed(argument))
    return ExternalCall(clause.name, tuple(given), tuple(results))
