"""The checker of the flat model: what every FlatModel promises to `lower`.

In:   FlatModel
Out:  nothing, or BrokenPromise, which is a bug of `flatten` and never the user's fault

Checked: names are declared once, every reference is declared and its subscripts fit,
the sides of equations have one type, calls have all arguments of their function,
bindings fit their variables, conditions are Boolean.
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.ir import flat
from planarc.ir.flatwalk import children


class BrokenPromise(AssertionError):
    """The flat model breaks one of its invariants."""


class _Checker:
    def __init__(self, model: flat.FlatModel) -> None:
        self.types = {v.name: v.type for v in model.variables}
        self.functions = {f.name: f for f in model.functions}
        self.where = ""
        if len(self.types) != len(model.variables):
            raise BrokenPromise("a variable is declared twice")
        if len(self.functions) != len(model.functions):
            raise BrokenPromise("a function is declared twice")

    def fail(self, what: str) -> None:
        raise BrokenPromise(f"{what} in {self.where}" if self.where else what)

    # Expressions ------------------------------------------------------------------------

    def expression(self, root: flat.Expression) -> None:
        stack: list[flat.Expression] = [root]
        while stack:
            node = stack.pop()
            self.node(node)
            if isinstance(node, flat.Comprehension):
                continue  # its body sees its iterators, which are not declared
            stack.extend(children(node))

    def expressions(self, *roots: flat.Expression | None) -> None:
        for root in roots:
            if root is not None:
                self.expression(root)

    def node(self, node: flat.Expression) -> None:
        match node:
            case flat.Reference():
                self.reference(node)
            case flat.Call():
                self.call(node)
            case flat.Record():
                if len(node.items) != len(node.type.fields):
                    self.fail(f"the record {node.type.name} lacks fields")
            case flat.Array():
                if node.type.dims[:1] != (len(node.items),):
                    self.fail("an array has another length than its type")
            case flat.If():
                for condition, _ in node.branches:
                    self.boolean(condition)
            case flat.Literal():
                self.literal(node)

    def literal(self, node: flat.Literal) -> None:
        wanted: dict[flat.Base, tuple[type, ...]] = {
            flat.Base.REAL: (float, int),
            flat.Base.INTEGER: (int,),
            flat.Base.BOOLEAN: (bool,),
            flat.Base.STRING: (str,),
            flat.Base.ENUMERATION: (int,),
        }
        if not isinstance(node.value, wanted[node.type.base]):
            self.fail(f"the literal {node.value!r} is no {node.type.base.value}")

    def reference(self, node: flat.Reference) -> None:
        type_ = self.types.get(node.name)
        if type_ is None:
            self.fail(f"`{node.name}` is not declared")
            return
        if len(node.subscripts) > len(type_.dims):
            self.fail(f"`{node.name}` has too many subscripts")
        for subscript, size in zip(node.subscripts, type_.dims, strict=False):
            if isinstance(subscript, flat.Literal) and size is not None:
                inside = 1 <= int(subscript.value) <= size
                if not inside:
                    self.fail(f"a subscript of `{node.name}` is out of range")

    def call(self, node: flat.Call) -> None:
        local = self.types.get(node.function)
        if local is not None and local.base is flat.Base.FUNCTION:
            return
        function = self.functions.get(node.function)
        if function is None:
            self.fail(f"the function `{node.function}` is not declared")
        elif len(function.inputs) != len(node.arguments):
            self.fail(f"the call of `{node.function}` is not complete")

    def boolean(self, condition: flat.Expression) -> None:
        if condition.type.base is not flat.Base.BOOLEAN:
            self.fail("a condition is not Boolean")

    # Equations and statements ----------------------------------------------------------------

    def equations(self, equations: tuple[flat.Equation, ...]) -> None:
        for equation in equations:
            self.where = f"an equation of `{equation.component}`"
            self.item(equation)

    def items(self, items: Iterable[flat.Equation | flat.Statement]) -> None:
        for item in items:
            self.item(item)

    def item(self, item: flat.Equation | flat.Statement) -> None:
        match item:
            case flat.Equality(left=flat.Targets(items=items), right=right):
                self.expressions(right, *items)
            case flat.Equality(left=left, right=right):
                assert not isinstance(left, flat.Targets)
                self.expressions(right, left)
                if not same_shape(left.type, right.type):
                    self.fail(f"an equation of {left.type} and {right.type}")
            case flat.Assignment(target=target, value=value):
                self.target(target)
                self.expression(value)
            case flat.TupleAssignment(targets=targets, value=call):
                for each in targets:
                    if each is not None:
                        self.target(each)
                self.expression(call)
            case flat.IfEquation(otherwise=otherwise) | flat.IfStatement(otherwise=otherwise):
                self.branches(item.branches)
                self.items(otherwise)
            case flat.WhenEquation() | flat.WhenStatement():
                self.branches(item.branches)
            case flat.ForStatement(iterator=iterator, range=range_, body=body):
                self.expression(range_)
                outer = self.types
                self.types = {**outer, iterator: range_.type.element()}
                self.items(body)
                self.types = outer
            case flat.WhileStatement(condition=condition, body=body):
                self.branches(((condition, body),))
            case flat.Assert(condition=condition, message=message):
                self.boolean(condition)
                self.expressions(condition, message)
            case flat.Terminate(message=message):
                self.expression(message)
            case flat.Reinit(variable=variable, value=value):
                self.expressions(variable, value)

    def branches(
        self,
        branches: Iterable[tuple[flat.Expression, Iterable[flat.Equation | flat.Statement]]],
    ) -> None:
        for condition, body in branches:
            self.boolean(condition)
            self.expression(condition)
            self.items(body)

    def target(self, target: flat.Expression) -> None:
        """A variable; inside a function also a field, `r.x`; or several ones."""
        if isinstance(target, flat.Record | flat.Array):
            for item in target.items:
                self.target(item)
            return
        if not isinstance(target, flat.Reference):
            self.fail("what is assigned is no variable")
            return
        if target.name not in self.types and target.name.split(".")[0] not in self.types:
            self.fail(f"the target `{target.name}` is not declared")
        self.expressions(*target.subscripts)

    # Declarations -------------------------------------------------------------------------------

    def variable(self, variable: flat.Variable) -> None:
        self.where = f"the declaration of `{variable.name}`"
        a = variable.attributes
        for value in (a.start, a.fixed, a.min, a.max, a.nominal):
            if value is not None:
                self.expression(value)
                if value.type.dims not in ((), variable.type.dims):
                    self.fail("an attribute has other dimensions than its variable")
        if variable.binding is not None:
            self.expression(variable.binding)
            if not same_shape(variable.type, variable.binding.type):
                self.fail("the binding has another type")

    def function(self, function: flat.Function) -> None:
        own = (*function.inputs, *function.outputs, *function.locals)
        outer = self.types
        self.types = {v.name: v.type for v in own}
        for variable in own:
            self.variable(variable)
        self.where = f"the function `{function.name}`"
        self.items(function.body)
        self.expressions(*function.given)
        if not set(function.results) <= {v.name for v in function.outputs}:
            self.fail("an external function sets what is no output")
        self.types = outer


def same_shape(left: flat.Type, right: flat.Type) -> bool:
    """Equal but for Integer and Real, and for sizes known only when run."""
    numeric = (flat.Base.REAL, flat.Base.INTEGER)
    bases = left.base is right.base or (left.base in numeric and right.base in numeric)
    return (
        bases
        and len(left.dims) == len(right.dims)
        and all(
            a is None or b is None or a == b for a, b in zip(left.dims, right.dims, strict=True)
        )
    )


def check_model(model: flat.FlatModel) -> None:
    """Raise BrokenPromise when the model breaks an invariant."""
    checker = _Checker(model)
    for variable in model.variables:
        checker.variable(variable)
    checker.equations(model.equations)
    checker.equations(model.initial_equations)
    for algorithm in (*model.algorithms, *model.initial_algorithms):
        checker.where = f"an algorithm of `{algorithm.component}`"
        checker.items(algorithm.statements)
    for function in model.functions:
        checker.function(function)
    checker.where = "a visual"
    for visual in model.visuals:
        checker.expressions(*(value for _, value in visual.attributes))
    checker.where = "what a component declares"
    checker.expressions(*(declared.value for declared in model.declared))
