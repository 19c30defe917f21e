"""Functions of numbers and arrays, written in a small part of Python, as text for LLVM.

The part: arguments of the types below, or records of them (``NamedTuple``), local variables that keep the type of their first
value, arithmetic, comparisons, ``if``, ``while``, ``for`` over a ``range``, calls of each other. A type ``Lanes`` is a vector
of so many numbers, ``Marks`` of so many truth values: arithmetic on them is lane by lane, ``select`` chooses by marks,
``any_lane`` tells whether one is set, and ``array[i][lane]`` is a number of the i-th vector. Python runs the same code on
NumPy's arrays. Numba, which translates much more of Python, needed 26 s of processor time for the stepper, this half a second.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any

from llvmlite import ir

from wucht.numerics.flow.compiled.straight_line_code import CONTRACT, LIBRARY_PREFIX, constant_lanes, intrinsic, lanes_of

_INTEGER, _REAL, _FLAG = ir.IntType(64), ir.DoubleType(), ir.IntType(1)
_OPERATORS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div"}
_MARK_OPERATORS = {ast.BitAnd: "and_", ast.BitOr: "or_"}
_COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
_INTRINSICS = {"abs": "llvm.fabs", "sqrt": "llvm.sqrt", "ceil": "llvm.ceil", "copysign": "llvm.copysign"}
EVALUATE = "evaluate"  # (function, time, state, constants, values, first): machine code of a system is called by its address
INSTRUCTIONS = {
    EVALUATE,
    f"{EVALUATE}_lanes",
    "select",
    "any_lane",
    "larger",
    "smaller",
    "root",
    "ceiling",
}  # not translated, but instructions


def _types(width: int) -> dict[str, Any]:
    lanes = lanes_of(_REAL, width)
    return {
        "int": _INTEGER, "float": _REAL, "bool": _FLAG, "None": ir.VoidType(), "Integers": _INTEGER.as_pointer(),
        "Reals": _REAL.as_pointer(), "Function": _INTEGER, "Lanes": lanes, "Marks": lanes_of(_FLAG, width),
        "LaneArray": lanes.as_pointer(),
    }  # fmt: skip


def kernel_text(source: str, constants: Mapping[str, float], width: int = 1) -> str:
    """Translate the functions of a module. constants: what its other names stand for. width: of vectors."""
    types = _types(width)
    module, body = ir.Module(name="kernel"), ast.parse(source).body
    records = {d.name: _fields(d) for d in body if isinstance(d, ast.ClassDef)}
    definitions = [d for d in body if isinstance(d, ast.FunctionDef) and d.name not in INSTRUCTIONS]
    for definition in definitions:
        kinds = [types[kind] for _, kind in _arguments(definition, records)]
        result_kind = types[ast.unparse(definition.returns)] if definition.returns else types["None"]
        function = ir.Function(module, ir.FunctionType(result_kind, kinds), definition.name)
        function.attributes.add("nounwind")
        arrays = [argument for argument in function.args if argument.type.is_pointer]
        for argument in arrays:  # no two overlap
            argument.add_attribute("noalias")
        if arrays:  # copies of loops in each place where they are called take seconds to compile and save nothing
            function.attributes.add("noinline")
    for definition in definitions:
        names = [name for name, _ in _arguments(definition, records)]
        _Translator(module, module.globals[definition.name], constants, width).translate(names, definition.body)
    return str(module)


def _fields(definition: ast.ClassDef | ast.arguments) -> list[tuple[str, str]]:
    """Return names and types of a record's fields or a function's arguments."""
    if isinstance(definition, ast.arguments):
        return [(a.arg, ast.unparse(a.annotation)) for a in definition.args if a.annotation]
    return [(ast.unparse(s.target), ast.unparse(s.annotation)) for s in definition.body if isinstance(s, ast.AnnAssign)]


def _arguments(definition: ast.FunctionDef, records: Mapping[str, list[tuple[str, str]]]) -> list[tuple[str, str]]:
    """Return names and types of a function's arguments, of a record those of its fields: ``record.field``."""
    pairs = list[tuple[str, str]]()
    for name, kind in _fields(definition.args):
        pairs += [(f"{name}.{field}", k) for field, k in records[kind]] if kind in records else [(name, kind)]
    return pairs


class _Translator:
    """Translator of one function. places: of its variables. loops: where ``continue`` and ``break`` lead."""

    def __init__(self, module: ir.Module, function: ir.Function, constants: Mapping[str, float], width: int) -> None:
        self.module, self.function, self.constants, self.width = module, function, constants, width
        self.lanes = lanes_of(_REAL, width)
        self.builder = ir.IRBuilder(function.append_basic_block())
        self.places: dict[str, Any] = {}
        self.loops: list[tuple[Any, Any]] = []

    def translate(self, names: Sequence[str], statements: Sequence[ast.stmt]) -> None:
        for name, value in zip(names, self.function.args, strict=True):
            self._assign(name, value)
        body = self.function.append_basic_block()
        self.builder.branch(body)
        self.builder.position_at_end(body)
        self._statements(statements)
        if not self.builder.block.is_terminated:  # behind a loop that ends with the function it is never reached
            is_procedure = isinstance(self.function.function_type.return_type, ir.VoidType)
            (self.builder.ret_void if is_procedure else self.builder.unreachable)()

    def _statements(self, statements: Sequence[ast.stmt]) -> None:
        for statement in statements:
            if not self.builder.block.is_terminated:
                self._statement(statement)

    def _statement(self, statement: ast.stmt) -> None:  # noqa: PLR0912 - one branch for each kind
        match statement:
            case ast.Expr(value=ast.Constant()):
                pass  # a docstring
            case ast.Expr(value=value):
                self._value(value)
            case ast.Assign(targets=targets, value=ast.Tuple(elts=values)):
                (target,) = targets
                assert isinstance(target, ast.Tuple)
                for one, value in zip(target.elts, [self._value(v) for v in values], strict=True):
                    self._store(one, value)
            case ast.Assign(targets=targets, value=node):
                value = self._value(node)
                for target in targets:
                    self._store(target, value)
            case ast.AnnAssign(target=target, value=ast.expr() as node):
                self._store(target, self._value(node))
            case ast.AugAssign(target=target, op=op, value=node):
                self._store(target, self._operation(op, self._value(target), self._value(node)))
            case ast.If(test=test, body=body, orelse=orelse):
                self._branch(test, lambda: self._statements(body), lambda: self._statements(orelse))
            case ast.While(test=test, body=body):
                self._loop(lambda: self._value(test), body, lambda: None)
            case ast.For(target=ast.Name(id=name), iter=ast.Call(args=arguments), body=body):
                self._count(name, [self._value(a) for a in arguments], body)
            case ast.Return(value=None):
                self.builder.ret_void()
            case ast.Return(value=node) if node is not None:
                self.builder.ret(self._conversion(self._value(node), self.function.function_type.return_type))
            case ast.Continue():
                self.builder.branch(self.loops[-1][0])
            case ast.Break():
                self.builder.branch(self.loops[-1][1])
            case _:
                raise TypeError(f"this statement is outside the part of Python that is translated: {ast.unparse(statement)}")

    def _branch(self, test: ast.expr, first: Callable[[], None], second: Callable[[], None]) -> None:
        blocks = [self.function.append_basic_block() for _ in range(3)]
        self.builder.cbranch(self._value(test), *blocks[:2])
        for block, translate in zip(blocks, (first, second), strict=False):
            self.builder.position_at_end(block)
            translate()
            if not self.builder.block.is_terminated:
                self.builder.branch(blocks[2])
        self.builder.position_at_end(blocks[2])
        if not any(blocks[2] in block.terminator.operands for block in self.function.blocks if block.is_terminated):
            self.builder.unreachable()

    def _loop(self, test: Callable[[], Any], body: Sequence[ast.stmt], advance: Callable[[], None]) -> None:
        test_block, body_block, increment_block, end = (self.function.append_basic_block() for _ in range(4))
        self.builder.branch(test_block)
        self.builder.position_at_end(test_block)
        self.builder.cbranch(test(), body_block, end)
        self.builder.position_at_end(body_block)
        self.loops.append((increment_block, end))
        self._statements(body)
        self.loops.pop()
        if not self.builder.block.is_terminated:
            self.builder.branch(increment_block)
        self.builder.position_at_end(increment_block)
        advance()
        self.builder.branch(test_block)
        self.builder.position_at_end(end)

    def _count(self, name: str, arguments: Sequence[Any], body: Sequence[ast.stmt]) -> None:
        start, stop = arguments[:2] if len(arguments) > 1 else (ir.Constant(_INTEGER, 0), arguments[0])
        step = arguments[2] if len(arguments) > 2 else ir.Constant(_INTEGER, 1)
        self._assign(name, start)
        place, comparison = self.places[name], "<" if step.constant > 0 else ">"
        self._loop(
            lambda: self.builder.icmp_signed(comparison, self.builder.load(place), stop),
            body,
            lambda: self.builder.store(self.builder.add(self.builder.load(place), step), place),
        )

    def _store(self, target: ast.expr, value: Any) -> None:
        match target:
            case ast.Name(id=name):
                self._assign(name, value)
            case ast.Subscript():
                place = self._place(target)
                self.builder.store(self._conversion(value, place.type.pointee), place)

    def _assign(self, name: str, value: Any) -> None:
        if name not in self.places:
            with self.builder.goto_entry_block():
                self.places[name] = self.builder.alloca(value.type)
        place = self.places[name]
        self.builder.store(self._conversion(value, place.type.pointee), place)

    def _conversion(self, value: Any, kind: Any) -> Any:
        if value.type == _INTEGER and kind in (_REAL, self.lanes):
            value = self.builder.sitofp(value, _REAL)
        if value.type == _REAL and kind == self.lanes != _REAL:
            return self._splat(value)
        if value.type != kind:
            raise TypeError(f"{value.type} is no {kind}")
        return value

    def _splat(self, number: Any) -> Any:
        if isinstance(number, ir.Constant):
            return constant_lanes(_REAL, number.constant, self.width)
        integer = ir.IntType(32)
        first = self.builder.insert_element(ir.Constant(self.lanes, ir.Undefined), number, ir.Constant(integer, 0))
        mask = ir.Constant(ir.VectorType(integer, self.width), [ir.Constant(integer, 0)] * self.width)
        return self.builder.shuffle_vector(first, ir.Constant(self.lanes, ir.Undefined), mask)

    def _real_kind(self, *values: Any) -> Any:
        """Return the type of numbers, or of vectors where one of the values is one."""
        return self.lanes if any(value.type == self.lanes for value in values) else _REAL

    def _place(self, node: ast.Subscript) -> Any:
        if isinstance(node.value, ast.Subscript):  # a number of a vector
            numbers = self.builder.bitcast(self._place(node.value), _REAL.as_pointer())
            return self.builder.gep(numbers, [self._value(node.slice)])
        return self.builder.gep(self._value(node.value), [self._value(node.slice)])

    def _value(self, node: ast.expr) -> Any:  # noqa: PLR0911 - one for each kind
        match node:
            case ast.Constant(value=float() | int() as value):
                return _constant(value)
            case ast.Name(id=name):
                return self.builder.load(self.places[name]) if name in self.places else _constant(self.constants[name])
            case ast.Attribute():
                return self.builder.load(self.places[ast.unparse(node)])
            case ast.Subscript():
                return self.builder.load(self._place(node))
            case ast.BinOp(left=left, op=op, right=right):
                return self._operation(op, self._value(left), self._value(right))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self._negative(self._value(operand))
            case ast.UnaryOp(op=ast.Not() | ast.Invert(), operand=operand):
                return self.builder.not_(self._value(operand))
            case ast.Compare(left=left, ops=ops, comparators=comparators):
                values = [self._value(v) for v in (left, *comparators)]
                return reduce(self.builder.and_, map(self._comparison, ops, values, values[1:]))
            case ast.BoolOp(op=op, values=[first, *rest]):
                return reduce(lambda value, n: self._choice(value, n, isinstance(op, ast.And)), rest, self._value(first))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self._conditional(test, body, orelse)
            case ast.Call(func=function, args=arguments):
                values = [value for argument in arguments for value in self._argument_values(argument)]
                return self._call(ast.unparse(function).removeprefix("math."), values)
        raise TypeError(f"this expression is outside the part of Python that is translated: {ast.unparse(node)}")

    def _argument_values(self, node: ast.expr) -> list[Any]:
        """Return the value of an argument, of a record those of its fields."""
        fields = [place for name, place in self.places.items() if name.startswith(f"{ast.unparse(node)}.")]
        return [self.builder.load(place) for place in fields] if fields else [self._value(node)]

    def _operation(self, op: ast.operator, left: Any, right: Any) -> Any:
        if isinstance(op, ast.Pow):
            return self._power(left, right)
        if type(op) in _MARK_OPERATORS:
            return getattr(self.builder, _MARK_OPERATORS[type(op)])(left, right)
        if isinstance(op, ast.Mod):  # of numbers that are not negative
            return self.builder.srem(left, right)
        if left.type == right.type == _INTEGER and not isinstance(op, ast.Div):
            return getattr(self.builder, _OPERATORS[type(op)])(left, right, flags=("nsw",))
        kind, flags = self._real_kind(left, right), () if isinstance(op, ast.Div) else CONTRACT
        return getattr(self.builder, f"f{_OPERATORS[type(op)]}")(
            self._conversion(left, kind), self._conversion(right, kind), flags=flags
        )

    def _power(self, base: Any, exponent: Any) -> Any:
        if isinstance(exponent, ir.Constant) and exponent.constant == 2:
            return self.builder.fmul(base, base, flags=CONTRACT)
        name = LIBRARY_PREFIX + "pow"
        if name not in self.module.globals:
            ir.Function(self.module, ir.FunctionType(_REAL, [_REAL, _REAL]), name)
        return self.builder.call(self.module.globals[name], [self._conversion(v, _REAL) for v in (base, exponent)])

    def _negative(self, value: Any) -> Any:
        if isinstance(value, ir.Constant):
            return ir.Constant(value.type, -value.constant)
        return self.builder.fneg(value) if value.type in (_REAL, self.lanes) else self.builder.neg(value)

    def _comparison(self, op: ast.cmpop, left: Any, right: Any) -> Any:
        sign = _COMPARISONS[type(op)]
        kind = self._real_kind(left, right)
        if left.type == right.type != kind:
            return self.builder.icmp_signed(sign, left, right)
        compare = self.builder.fcmp_unordered if sign == "!=" else self.builder.fcmp_ordered
        return compare(sign, self._conversion(left, kind), self._conversion(right, kind))

    def _temporary(self, kind: Any) -> Any:
        with self.builder.goto_entry_block():
            return self.builder.alloca(kind)

    def _choice(self, value: Any, rest: ast.expr, is_and: bool) -> Any:
        """Return a logical ``and`` or ``or`` whose second part is evaluated only where it decides."""
        place = self._temporary(_FLAG)
        self.builder.store(value, place)
        second_block, end = self.function.append_basic_block(), self.function.append_basic_block()
        self.builder.cbranch(value, *((second_block, end) if is_and else (end, second_block)))
        self.builder.position_at_end(second_block)
        self.builder.store(self._value(rest), place)
        self.builder.branch(end)
        self.builder.position_at_end(end)
        return self.builder.load(place)

    def _conditional(self, test: ast.expr, body: ast.expr, orelse: ast.expr) -> Any:
        places: list[Any] = []

        def store(node: ast.expr) -> None:
            value = self._value(node)
            if not places:
                places.append(self._temporary(value.type))
            self.builder.store(self._conversion(value, places[0].type.pointee), places[0])

        self._branch(test, lambda: store(body), lambda: store(orelse))
        return self.builder.load(places[0])

    def _call(self, name: str, arguments: Sequence[Any]) -> Any:
        if name in INSTRUCTIONS:
            return getattr(self, f"_{name.removesuffix('_lanes')}")(*arguments)
        if name in ("min", "max"):
            return self._extreme(ast.Lt() if name == "min" else ast.Gt(), arguments)
        if name == "float":
            return self._conversion(arguments[0], _REAL)
        if name in _INTRINSICS:
            values = [self._conversion(a, self._real_kind(*arguments)) for a in arguments]
            return self.builder.call(intrinsic(self.module, _INTRINSICS[name], values), values)
        function = self.module.globals[name]
        return self.builder.call(function, list(map(self._conversion, arguments, function.function_type.args)))

    def _extreme(self, sign: ast.cmpop, arguments: Sequence[Any]) -> Any:
        kind = _INTEGER if all(a.type == _INTEGER for a in arguments) else self._real_kind(*arguments)
        values = [self._conversion(a, kind) for a in arguments]
        return reduce(lambda a, b: self.builder.select(self._comparison(sign, b, a), b, a), values)

    def _evaluate(self, function: Any, *arguments: Any) -> Any:
        *rest, values, first = arguments
        kind = ir.FunctionType(ir.VoidType(), [value.type for value in (*rest, values)])
        code = self.builder.inttoptr(function, kind.as_pointer())
        return self.builder.call(code, [*rest, self.builder.gep(values, [first])])

    def _select(self, marks: Any, first: Any, second: Any) -> Any:
        return self.builder.select(marks, self._conversion(first, self.lanes), self._conversion(second, self.lanes))

    def _larger(self, first: Any, second: Any) -> Any:
        return self._extreme(ast.Gt(), (first, second))

    def _smaller(self, first: Any, second: Any) -> Any:
        return self._extreme(ast.Lt(), (first, second))

    def _root(self, value: Any) -> Any:
        return self._call("sqrt", (value,))

    def _ceiling(self, value: Any) -> Any:
        return self._call("ceil", (value,))

    def _any_lane(self, marks: Any) -> Any:
        bits = self.builder.bitcast(marks, ir.IntType(self.width))
        return self.builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


def _constant(value: float) -> Any:
    kind = {bool: _FLAG, int: _INTEGER, float: _REAL}[type(value)]
    return ir.Constant(kind, value)
