"""Prints syntax trees as Modelica text.

In:   StoredDefinition, ClassDef, Equation ...
Out:  str               text whose tree is the same again

Each declared name gets a line of its own and the elements stand before the
sections; comments in the source (`//`) are no part of a tree.

Example:

    model M   Real x,y ; equation x=y  ;end M;

    model M
      Real x;
      Real y;
    equation
      x = y;
    end M;

Promises:  `parse(definition_text(tree)) == tree` for every tree of the parser.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.ir import syntax
from planarc.ir.text.compound import Compound
from planarc.ir.text.expression import (
    expression_text,
    iterators_text,
    list_text,
    quote,
    ref_text,
    simple_text,
    subscripts_text,
)

_INDENT = "  "


def definition_text(definition: syntax.StoredDefinition) -> str:
    """A whole file."""
    lines: list[str] = []
    if definition.within is not None:
        lines += [" ".join(("within", ".".join(definition.within))).strip() + ";", ""]
    for index, cls in enumerate(definition.classes):
        if index:
            lines.append("")
        lines += _class_lines(cls)
    return "".join(f"{line}\n" for line in lines)


def class_text(cls: syntax.ClassDef) -> str:
    return "".join(f"{line}\n" for line in _class_lines(cls))


# Classes ----------------------------------------------------------------------------------


def _class_lines(cls: syntax.ClassDef) -> Iterator[str]:
    head = f"{_prefixes(cls.prefixes)}{_class_head(cls)}"
    tail = f"{_constraint(cls.constraint)};"
    if isinstance(cls.body, syntax.Composition | syntax.ExtendsClass):
        yield head + _comment(cls.comment)
        body = cls.body if isinstance(cls.body, syntax.Composition) else cls.body.composition
        yield from _composition_lines(body)
        if cls.annotation:
            yield f"{_INDENT}annotation{cls.annotation.span.text};"
        yield f"end {cls.name}{tail}"
    else:
        yield f"{head}{_description(cls.comment, cls.annotation)}{tail}"


def _class_head(cls: syntax.ClassDef) -> str:
    words = ["encapsulated"] * cls.encapsulated + ["partial"] * cls.partial
    if cls.pure is not None:
        words.append("pure" if cls.pure else "impure")
    words.append(cls.kind.value)
    body = cls.body
    match body:
        case syntax.Composition():
            words.append(cls.name)
        case syntax.ExtendsClass():
            words += ["extends", cls.name + _modification(body.modification)]
        case syntax.ShortClass():
            words += [cls.name, "=", *filter(None, (body.flow.value, body.causality.value))]
            dimensions = subscripts_text(body.dimensions)
            words.append(ref_text(body.base) + dimensions + _modification(body.modification))
        case syntax.Enumeration(literals=None):
            words += [cls.name, "= enumeration(:)"]
        case syntax.Enumeration():
            literals = ", ".join(i.name + _comment(i.comment) for i in body.literals or ())
            words += [cls.name, f"= enumeration({literals})"]
        case syntax.DerivativeClass():
            variables = ", ".join((ref_text(body.function), *body.variables))
            words += [cls.name, f"= der({variables})"]
    return " ".join(words)


def _composition_lines(body: syntax.Composition) -> Iterator[str]:
    protected = False
    for element in body.elements:
        here = _is_protected(element)
        if here is not None and here is not protected:
            protected = here
            yield "protected" if protected else "public"
        yield from (_INDENT + line for line in _element_lines(element))
    for section in body.sections:
        initial = "initial " if section.initial else ""
        if isinstance(section, syntax.EquationSection):
            yield f"{initial}equation"
            yield from _body(section.equations)
        else:
            yield f"{initial}algorithm"
            yield from _body(section.statements)
    if body.external:
        yield _INDENT + _external(body.external)


def _external(external: syntax.External) -> str:
    words = ["external"]
    if external.language is not None:
        words.append(quote(external.language))
    if external.result is not None:
        words += [ref_text(external.result), "="]
    if external.function is not None:
        words.append(f"{external.function}({list_text(external.arguments)})")
    return " ".join(words) + _description("", external.annotation) + ";"


# Elements ---------------------------------------------------------------------------------


def _is_protected(element: syntax.Element) -> bool | None:
    if isinstance(element, syntax.Import):
        return None  # an import is never seen from outside
    if isinstance(element, syntax.Extends):
        return element.protected
    return element.prefixes.protected


def _element_lines(element: syntax.Element) -> Iterable[str]:
    match element:
        case syntax.ClassDef():
            return _class_lines(element)
        case syntax.Import():
            return (f"import {_import(element)};",)
        case syntax.Extends():
            arguments = _modification(element.modification)
            annotation = _description("", element.annotation)
            return (f"extends {ref_text(element.base)}{arguments}{annotation};",)
        case syntax.Component():
            clause = _component(element)
            prefixes = _prefixes(element.prefixes)
            return (f"{prefixes}{clause}{_constraint(element.constraint)};",)


def _import(element: syntax.Import) -> str:
    path = ".".join(element.path)
    if element.alias is not None:
        return f"{element.alias} = {path}"
    if element.wildcard:
        return f"{path}.*"
    return f"{path}.{{{', '.join(element.names)}}}" if element.names else path


def _component(c: syntax.Component) -> str:
    words = [w for w in (c.flow.value, c.variability.value, c.causality.value) if w]
    words.append(ref_text(c.type) + subscripts_text(c.type_dimensions))
    words.append(c.name + subscripts_text(c.dimensions) + _modification(c.modification))
    if c.condition is not None:
        words.append(f"if {expression_text(c.condition)}")
    return " ".join(words) + _description(c.comment, c.annotation)


def _prefixes(p: syntax.Prefixes) -> str:
    words = ("redeclare", "final", "inner", "outer", "replaceable")
    return "".join(f"{word} " for word in words if getattr(p, word))


def _constraint(constraint: syntax.Constraint | None) -> str:
    if constraint is None:
        return ""
    return f" constrainedby {ref_text(constraint.base)}{_modification(constraint.modification)}"


def _comment(comment: str) -> str:
    return f" {quote(comment)}" if comment else ""


def _description(comment: str, annotation: syntax.Annotation | None) -> str:
    return _comment(comment) + (f" annotation{annotation.span.text}" if annotation else "")


# Modifications -----------------------------------------------------------------------------


def _modification(modification: syntax.Modification | None) -> str:
    """`(arguments) = binding`, as it follows a name; `()` where both are missing."""
    if modification is None:
        return ""
    arguments = ", ".join(map(argument_text, modification.arguments))
    binding = ""
    if modification.broken:
        binding = " = break"
    elif modification.binding is not None:
        binding = f" = {expression_text(modification.binding)}"
    return f"({arguments}){binding}" if arguments or not binding else binding


def argument_text(argument: syntax.Argument) -> str:
    """An argument of a modification or an annotation."""
    match argument:
        case syntax.ElementModification():
            words = ["each"] * argument.each + ["final"] * argument.final
            words.append(".".join(argument.name) + _modification(argument.modification))
            return " ".join(words) + _comment(argument.comment)
        case syntax.Deselection(target=target):
            return f"break {target if isinstance(target, str) else _connect(target)}"
        case syntax.ElementRedeclaration():
            return _redeclaration(argument)


def _redeclaration(argument: syntax.ElementRedeclaration) -> str:
    element = argument.element
    flags = {
        "redeclare": argument.redeclare,
        "each": argument.each,
        "final": argument.final,
        "replaceable": element.prefixes.replaceable,
    }
    words = [word for word, present in flags.items() if present]
    if isinstance(element, syntax.Component):
        words.append(_component(element))
    else:
        words.append(_class_head(element) + _description(element.comment, element.annotation))
    return " ".join(words) + _constraint(element.constraint)


# Equations and statements -------------------------------------------------------------------


def _connect(equation: syntax.Connect) -> str:
    return f"connect({ref_text(equation.left)}, {ref_text(equation.right)})"


def _plain(item: syntax.Equation | syntax.Statement) -> str:
    match item:
        case syntax.Equality():
            sides = f"{simple_text(item.left)} = {expression_text(item.right)}"
            return f"{sides}{_comment(item.comment)};"
        case syntax.Assignment():
            return f"{ref_text(item.target)} := {expression_text(item.value)};"
        case syntax.TupleAssignment():
            targets = ", ".join("" if t is None else ref_text(t) for t in item.targets)
            return f"({targets}) := {expression_text(item.value)};"
        case syntax.CallEquation() | syntax.CallStatement():
            return f"{expression_text(item.call)};"
        case syntax.Connect():
            return f"{_connect(item)};"
    raise TypeError(f"not an equation: {item!r}")


_body = Compound(expression_text, lambda loop: iterators_text(loop.iterators), _plain).body
