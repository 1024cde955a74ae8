"""Inputs of extreme size, depth or cunning, by name."""

from __future__ import annotations

DEPTH = 10_000


def _model(body: str) -> bytes:
    return f"model M\n{body}\nend M;\n".encode()


def _nested(kind: str, count: int) -> bytes:
    opened = "".join(f"{kind} C{i}\n" for i in range(count))
    closed = "".join(f"end C{i};\n" for i in reversed(range(count)))
    return (opened + "Real x = 1;\n" + closed).encode()


def _chain(count: int) -> bytes:
    """Each class extends the one before."""
    classes = "".join(f"model C{i} extends C{i - 1}; end C{i};\n" for i in range(1, count))
    return f"package P\nmodel C0 Real x = 1; end C0;\n{classes}end P;\n".encode()


def _tree(depth: int) -> bytes:
    """2^depth components from a short text."""
    classes = "".join(f"model C{i} C{i - 1} a; C{i - 1} b; end C{i};\n" for i in range(1, depth))
    return f"package P\nmodel C0 Real x = 1; end C0;\n{classes}end P;\n".encode()


_RECURSION = """
function f input Real x; output Real y; algorithm y := f(x + 1); end f;
parameter Real p = f(1);
Real z[integer(f(2))];
"""
_LOOP = """
function f input Real x; output Real y; algorithm y := x;
  while true loop y := y + 1; end while; end f;
constant Real p = f(1);
Real z[integer(f(2))];
"""
_COUNT = """
function f input Real x; output Real y; algorithm y := x;
  for i in 1:1000000000 loop y := y + 1; end for; end f;
Real z[integer(f(2))];
"""

_RANGE = """
function f input Real x; output Real y; algorithm y := sum(0:1e-9:x); end f;
Real z[integer(f(2))];
"""
_STRING = """
function f output String s; algorithm s := "x"; for i in 1:60 loop s := s + s; end for; end f;
constant String s = f();
Real x = if s == "x" then 1 else 2;
"""
_GROWTH = """
function f output Real y; protected Real v[:]; algorithm v := {1.0};
  for i in 1:60 loop v := cat(1, v, v); end for; y := sum(v); end f;
Real z[integer(f())];
"""

EXTREMES: dict[str, bytes] = {
    "parentheses": _model("Real x = " + "(" * DEPTH + "1" + ")" * DEPTH + ";"),
    "open parentheses": _model("Real x = " + "(" * DEPTH),
    "braces": _model("Real x = " + "{" * DEPTH + "1" + "}" * DEPTH + ";"),
    "calls": _model("Real x = " + "sin(" * DEPTH + "1" + ")" * DEPTH + ";"),
    "minus signs": _model("Real x = " + "- " * DEPTH + "1;"),
    "nots": _model("Boolean x = " + "not " * DEPTH + "true;"),
    "long sum": _model("Real x = 1" + " + 1" * 100_000 + ";"),
    "long sum in bounds": _model("Real x; equation x = time" + " + x*2" * 900 + ";"),
    "powers": _model("Real x = 2^(2^(2^(2^(2^(2^2)))));"),
    "nested ifs": _model("Real x = " + "if time > 1 then 2 else " * 3_000 + "1;"),
    "if equations": _model("Real x; equation\n" + "if time > 1 then " * 3_000),
    "subscripts": _model("Real x" + "[1" * DEPTH + "]" * DEPTH + ";"),
    "dots": _model("Real x = x" + ".x" * 100_000 + ";"),
    "modifiers": _model("Real x" + "(start" * DEPTH + ")" * DEPTH + ";"),
    "nested classes": _nested("model", 1_000),
    "nested packages": _nested("package", 1_000),
    "nested classes in bounds": _nested("model", 60),
    "chain of bases": _chain(1_000),
    "tree of components": _tree(40),
    "cyclic extends": b"model A extends B; end A; model B extends A; end B;",
    "extends itself": b"model A extends A; end A;",
    "extends its inner class": b"model A extends A.B; model B end B; end A;",
    "extends through an import": b"package P import Q = P.A; model A extends Q; end A; end P;",
    "cyclic short classes": b"package P model A = B; model B = A; end P;",
    "cyclic types": b"package P type A = B; type B = A; model M A x; end M; end P;",
    "cyclic constants": b"package P constant Real a = b; constant Real b = a; "
    b"model M Real x[integer(a)]; end M; end P;",
    "contains itself": _model("M m;"),
    "contain each other": b"package P model A B b; end A; model B A a; end B; end P;",
    "contains arrays of itself": _model("M m[2];"),
    "own parameter": _model("parameter Real p = p; Real x = p;"),
    "own size": _model("parameter Integer n = size(x, 1); Real x[n];"),
    "own condition": _model("parameter Boolean b = a.y; A a if b; model A Boolean y; end A;"),
    "cyclic parameters": _model("parameter Real p = q; parameter Real q = p; Real x[integer(p)];"),
    "cyclic redeclare": _model(
        "replaceable model A = B; replaceable model B = A; A a(redeclare model A = B);"
    ),
    "cyclic imports": b"package P import P.Q.*; package Q import P.*; end Q; model M X x; end M;"
    b" end P;",
    "inner is outer": _model("inner outer Real x = x;"),
    "huge array": _model("Real x[1000000000];"),
    "huge array of components": _model("model A Real x = 1; end A; A a[100000, 100000];"),
    "huge matrices": _model("parameter Real x[100000, 100000] = zeros(100000, 100000);"),
    "huge fill": _model("Real x = sum(fill(1, 1000000000));"),
    "huge fill of nothing": _model("Real x = sum(fill(1, 0, 9223372036854775808));"),
    "huge range": _model("Real x = sum(i for i in 1:1000000000);"),
    "huge step": _model("Real x = sum(0:1e-12:1);"),
    "huge for": _model("Real x; equation for i in 1:1000000000 loop x = i; end for;"),
    "nested for": _model(
        "Real x; equation for i in 1:9999, j in 1:9999, k in 1:9999 loop x = i; end for;"
    ),
    "huge range of reals": _model("Real x = sum(0.0:1e-300:1e300);"),
    "huge range in a function": _model(_RANGE),
    "range of not a number": _model("constant Real n = 0.0*1e400; Real x = sum(0:n:1);"),
    "nested for over huge ranges": _model(
        "Real x; equation for i in 1:1000000000, j in 1:1000000000 loop x = i; end for;"
    ),
    "nested for in an algorithm": _model(
        "Real x; algorithm for i in 1:100000 loop for j in 1:100000 loop x := x + j; end for;"
        " end for;"
    ),
    "for over nothing, hugely often": _model(
        "Real x = 1; equation for i in 1:1000000000 loop end for;"
    ),
    "huge comprehension": _model("Real x = sum(i*j for i in 1:100000, j in 1:100000);"),
    "huge array of arrays": _model(
        "Real x[1000, 1000, 1000, 1000] = fill(1, 1000, 1000, 1000, 1000);"
    ),
    "array of 2^39 components": _tree(40).replace(
        b"model C39 C38 a; C38 b;", b"model C39 C1 a[549755813888];"
    ),
    "array of a deep tree": _tree(12).replace(b"C10 a; C10 b;", b"C10 a[100000]; C10 b;"),
    "huge array of records": _model("record R Real x; Real y[3]; end R; R r[100000000];"),
    "huge array of connectors": _model(
        "connector C Real e; flow Real f; end C; C a[10000000]; C b[10000000];"
        " equation connect(a, b);"
    ),
    "huge parameter array": _model("parameter Integer n = 2147483647; Real x[n] = zeros(n);"),
    "huge cat": _model("Real x[:] = cat(1, ones(100000000), ones(100000000));"),
    "huge transpose": _model("Real x = sum(transpose(ones(100000, 100000)));"),
    "huge diagonal": _model("Real x = sum(diagonal(ones(1000000)));"),
    "huge outer product": _model("Real x = sum(outerProduct(ones(100000), ones(100000)));"),
    "huge product of matrices": _model("Real x = sum(ones(2000, 2000)*ones(2000, 2000));"),
    "huge slice": _model("Real y[3]; Real x = sum(y[1:1000000000]);"),
    "huge power of a matrix": _model("Real x[2, 2] = [1, 2; 3, 4]^1000000000;"),
    "huge string of a loop": _model(_STRING),
    "growing array of a loop": _model(_GROWTH),
    "huge linspace": _model("Real x = sum(linspace(0, 1, 2147483647));"),
    "huge identity": _model("Real x = sum(identity(1000000));"),
    "negative size": _model("Real x[-5];"),
    "size by overflow": _model("Real x[9223372036854775807 + 1];"),
    "huge power": _model("parameter Integer n = 10^(10^10); Real x[n];"),
    "huge integer power": _model("constant Integer n = 9999^9999^9999; Real x = n;"),
    "huge string": _model('constant String s = String(1.0, format="999999999.999999999f");'),
    "string length": _model("constant String s = String(1, minimumLength=2000000000);"),
    "recursion": _model(_RECURSION),
    "endless while": _model(_LOOP),
    "endless for": _model(_COUNT),
    "long identifier": _model("Real " + "x" * 1_000_000 + " = 1;"),
    "long quoted identifier": _model("Real '" + "x" * 1_000_000 + "' = 1;"),
    "long string": _model('Real x "' + "x" * 1_000_000 + '" = 1;'),
    "long number": _model("Real x = " + "1" * 1_000_000 + ";"),
    "long line": b"/*" + b"x" * 3_000_000 + b"*/" + _model("Real x = y;"),
    "many lines": b"\n" * 1_000_000 + _model("Real x = y;"),
    "many components": _model("".join(f"Real x{i} = {i};\n" for i in range(3_000))),
    "many errors": _model("".join(f"Real x{i} = y{i};\n" for i in range(1_000))),
    "many syntax errors": _model("Real = ;\n" * 3_000),
    "deep annotation": _model("annotation(" + "a(" * DEPTH + ")" * DEPTH + ");"),
    "deep experiment": _model("annotation(experiment(StopTime=" + "(" * DEPTH + "1));"),
    "open comment": _model("Real x; /*" + "/*" * DEPTH),
    "open string": _model('Real x "' + "\\" * DEPTH),
    "NUL": _model("Real x\0 = 1;"),
    "BOM": b"\xef\xbb\xbf" + _model("Real x = y;"),
    "BOM of UTF-16": "model M Real x = y; end M;".encode("utf-16"),
    "CRLF": _model("Real x = y;").replace(b"\n", b"\r\n"),
    "CR": _model("Real x = y;").replace(b"\n", b"\r"),
    "Latin-1": _model('Real x "größe" = y;').decode().encode("latin-1"),
    "Latin-1 name": "model M Real größe; end M;".encode("latin-1"),
    "only bytes": bytes(range(256)) * 100,
    "empty": b"",
    "steers the terminal": _model("Real x = '\x1b[2J\x07';"),
    "surrogates": _model("Real x;").replace(b"x", b"\xed\xa0\x80"),
    "division by zero": _model("parameter Integer n = div(1, 0); Real x[n];"),
    "mod by zero": _model("constant Real n = mod(1, 0); Real x = rem(n, 0);"),
    "root of a negative": _model("constant Real n = sqrt(-1)^0.5 + log(0); Real x = n;"),
    "infinite exponent": _model("constant Real n = exp(exp(exp(exp(9)))); Real x = n;"),
    "many derivatives": _model("Real x; equation " + "der(" * 300 + "x" + ")" * 300 + " = 1;"),
}
