"""Arguments of annotations; what those say that belong to classes and parameters.

Annotations are parsed only when their text holds a word that matters.

Reference: Modelica Language Specification 3.6, chapter 18.
"""

from __future__ import annotations

from planarc.core.source import Span
from planarc.flatten.tree.nodes import Class, Layout, Session
from planarc.ir import syntax


def arguments_of(
    annotation: syntax.Annotation | None, word: str, session: Session
) -> tuple[syntax.Argument, ...]:
    """The arguments of an annotation that mentions `word`, parsed once."""
    if annotation is None:
        return ()
    key = id(annotation)
    known = session.annotations.get(key)
    if known is None:
        if word not in annotation.span.text:
            return ()
        known = annotation, session.library.parse_annotation(annotation)
        session.annotations[key] = known
    return known[1]


def find_argument(
    arguments: tuple[syntax.Argument, ...], name: str
) -> syntax.ElementModification | None:
    for argument in arguments:
        if isinstance(argument, syntax.ElementModification) and argument.name == (name,):
            return argument
    return None


def inside(argument: syntax.ElementModification | None) -> tuple[syntax.Argument, ...]:
    if argument is None or argument.modification is None:
        return ()
    return argument.modification.arguments


def binding_of(argument: syntax.ElementModification | None) -> syntax.Expression | None:
    if argument is None or argument.modification is None:
        return None
    return argument.modification.binding


def warn_obsolete(cls: Class, span: Span, session: Session) -> None:
    """`annotation(obsolete = "use B")`: whoever uses the class is told, once at a place (18.7)."""
    arguments = arguments_of(cls.definition.annotation, "obsolete", session)
    argument = find_argument(arguments, "obsolete")
    if argument is not None:
        value = binding_of(argument)
        advice = value.value if isinstance(value, syntax.String) else None
        kind = cls.definition.kind.value
        message = f"the {kind} `{cls.name}` is obsolete"
        if not any(w.span == span and w.message == message for w in session.warnings):
            session.warn("F266", message, span, advice)


def visual_kind(cls: Class, session: Session) -> str | None:
    """`annotation(__planarc(visual="shape"))`: an instance is drawn, not simulated."""
    arguments = arguments_of(cls.definition.annotation, "__planarc", session)
    value = binding_of(find_argument(inside(find_argument(arguments, "__planarc")), "visual"))
    return value.value if isinstance(value, syntax.String) else None


def find_visual(layout: Layout, session: Session) -> None:
    """Notes in the layout of a class what its instances are drawn as."""
    if layout.visual is None:
        kinds = (visual_kind(part.cls, session) for part in layout.parts)
        layout.visual = next((kind for kind in kinds if kind), "")


def is_evaluated(annotation: syntax.Annotation | None, session: Session) -> bool:
    """`annotation(Evaluate=true)` on a parameter."""
    arguments = arguments_of(annotation, "Evaluate", session)
    value = binding_of(find_argument(arguments, "Evaluate"))
    return isinstance(value, syntax.Boolean) and value.value
