"""Operators on numbers, as Numba computes them and as JavaScript must write them for the same bits."""

from __future__ import annotations

import ast

from rss_gym.javascript.kinds import BOOL, FLOAT, INT, Array, Kind, Number, TranslationError, Value, Wide, described
from rss_gym.javascript.values import literal

SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**"}
BITS = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^", ast.LShift: "<<", ast.RShift: ">>"}
COMPARED = {ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
WORD = 2**31  # JavaScript's own bit operations take the low 32 bits, as signed numbers


def binary(operator: ast.operator, a: Value, b: Value) -> Value:
    """The value of `a operator b`."""
    sign = SIGNS.get(type(operator)) or BITS.get(type(operator))
    if sign is None:
        raise TranslationError(f"operator {type(operator).__name__} is not known")
    if sign == "**":
        if a.constant is None or b.constant is None:
            raise TranslationError("** is known for constants only")
        power = a.constant**b.constant
        return Value(literal(power), FLOAT if isinstance(power, float) else INT, power)
    if isinstance(a.kind, Wide) or isinstance(b.kind, Wide):
        return _wide(sign, a, b)
    if not (isinstance(a.kind, Number) and isinstance(b.kind, Number)):
        raise TranslationError(f"{described(a.kind)} {sign} {described(b.kind)} is not known")
    if sign in BITS.values():
        return _bits(sign, a, b)
    whole = a.kind != FLOAT and b.kind != FLOAT
    if sign == "/":
        return Value(f"({a.code} / {b.code})", FLOAT)
    if sign in ("//", "%"):
        if not whole:
            raise TranslationError(f"{sign} is known for whole numbers only")
        code = f"Math.floor({a.code} / {b.code})" if sign == "//" else f"$mod({a.code}, {b.code})"
        return Value(code, INT)
    return Value(f"({a.code} {sign} {b.code})", INT if whole else FLOAT)


def _bits(sign: str, a: Value, b: Value) -> Value:
    """Bit operations on numbers of JavaScript."""
    if a.kind == BOOL and b.kind == BOOL and sign in "&|^":
        return Value(f"Boolean({a.code} {sign} {b.code})", BOOL)
    if a.kind != INT or b.kind != INT:
        raise TranslationError(f"{described(a.kind)} {sign} {described(b.kind)} is not known")
    if sign == "<<":  # a pattern of bits in the making
        return _wide(sign, Value(f"BigInt({a.code})", Wide(True)), b)
    if sign == ">>":
        if b.constant is None or not 0 <= b.constant < 53:
            raise TranslationError(">> of whole numbers is known for constant shifts only")
        return Value(f"Math.floor({a.code} / {2 ** int(b.constant)})", INT)
    if sign == "&" and b.constant is not None and 0 <= b.constant < WORD:
        return Value(f"({a.code} & {b.code})", INT)
    return Value(f"Number(BigInt({a.code}) {sign} BigInt({b.code}))", INT)


def _wide(sign: str, a: Value, b: Value) -> Value:
    """Operations in which a BigInt takes part."""
    if FLOAT in (a.kind, b.kind):
        if sign not in "+-*/":
            raise TranslationError(f"{described(a.kind)} {sign} {described(b.kind)} is not known")
        return Value(f"({as_number(a).code} {sign} {as_number(b).code})", FLOAT)
    signed = {kind.signed if isinstance(kind, Wide) else True for kind in (a.kind, b.kind)}
    if len(signed) > 1 or BOOL in (a.kind, b.kind):  # Numba makes a float of signed and unsigned together
        raise TranslationError(
            f"{described(a.kind)} {sign} {described(b.kind)} is not known: Numba makes a float of it"
        )
    if sign in ("/", "//", "%"):
        raise TranslationError(f"{sign} of 64-bit whole numbers is not known")
    kind = Wide(signed.pop())
    code = f"({as_bigint(a)} {sign} {as_bigint(b)})"
    return Value(code if sign in ("&", "|", "^", ">>") else wrapped(code, kind), kind)


def wrapped(code: str, kind: Wide) -> str:
    """A BigInt modulo 2^64."""
    return f"BigInt.as{'Int' if kind.signed else 'Uint'}N(64, {code})"


def as_number(value: Value) -> Value:
    """A value as a number of JavaScript."""
    if isinstance(value.kind, Wide):
        return Value(f"Number({value.code})", INT)
    if value.kind == BOOL:
        return Value(f"Number({value.code})", INT)
    if not isinstance(value.kind, Number):
        raise TranslationError(f"{described(value.kind)} is no number")
    return value


def as_bigint(value: Value) -> str:
    """Code of a whole number as a BigInt."""
    if isinstance(value.kind, Wide):
        return value.code
    if value.kind != INT:
        raise TranslationError(f"{described(value.kind)} is no whole number")
    return f"{value.constant}n" if value.constant is not None and value.constant >= 0 else f"BigInt({value.code})"


def unary(operator: ast.unaryop, a: Value) -> Value:
    """The value of `operator a`."""
    if isinstance(operator, ast.Not):
        return Value(f"!{truth(a)}", BOOL)
    if isinstance(operator, ast.USub) and a.kind in (FLOAT, INT):
        if a.constant is not None:
            return Value(literal(-a.constant), a.kind, -a.constant)
        # A whole number has no negative zero.
        return Value(f"(-{a.code})" if a.kind == FLOAT else f"(0 - {a.code})", a.kind)
    raise TranslationError(f"{type(operator).__name__} of {described(a.kind)} is not known")


def compared(operator: ast.cmpop, a: Value, b: Value) -> str:
    """Code of one comparison."""
    sign = COMPARED.get(type(operator))
    if sign is None:
        raise TranslationError(f"comparison {type(operator).__name__} is not known")
    for value in (a, b):
        if not isinstance(value.kind, (Number, Wide)):
            raise TranslationError(f"a comparison of {described(value.kind)} is not known")
    same = a.kind == b.kind or {a.kind, b.kind} == {FLOAT, INT}
    exact = {"==": "===", "!=": "!=="}.get(sign, sign) if same else sign  # a BigInt equals a number with == only
    return f"({a.code} {exact} {b.code})"


def truth(value: Value) -> str:
    """Code of a value as a condition."""
    if value.kind == BOOL:
        return value.code
    if isinstance(value.kind, (Number, Wide)):
        return f"({value.code} !== {'0n' if isinstance(value.kind, Wide) else '0'})"
    raise TranslationError(f"{described(value.kind)} is no condition")


def stored(value: Value, kind: Kind) -> str:
    """Code of a value as a field or an element of this kind keeps it."""
    if kind == BOOL:
        return truth(value)
    if isinstance(kind, Wide):
        if kind == value.kind:
            return value.code
        return wrapped(as_bigint(value), kind)
    if isinstance(kind, Number):
        number = as_number(value)
        return f"(Math.trunc({number.code}) + 0)" if kind == INT and number.kind == FLOAT else number.code
    if isinstance(kind, Array):
        raise TranslationError("an array cannot be assigned whole: assign its elements")
    raise TranslationError(f"a {described(kind)} cannot be assigned")
