"""Formulas as text: what a reader sees is what is computed.

A formula is written as `F/(d*t)` or `von_mises(s_1 - s_2)/2`: numbers, symbols, + - * / ^, brackets
and the functions of `FUNCTIONS`. Nothing else is understood, so a text from a file can do no harm.
A symbol is a number, or a vector: a stress has the six components xx, yy, zz, xy, yz, zx, a normal
three. The same tree is evaluated, written with symbols and written with numbers put in.
"""

import ast
import math
import operator
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial, reduce
from statistics import NormalDist
from typing import Any

import numpy as np

from checks.result.words import number
from geometry.mesh import FloatArray

Value = float | FloatArray
Scope = Mapping[str, Value]
Work = Callable[[Scope], Value]

_LONGEST = 2000  # characters of a formula
_SHOWN = 60  # characters of it in a message
_DEEPEST = 60  # brackets and signs inside each other
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")  # of a stress
_TENSOR = [[0, 3, 5], [3, 1, 4], [5, 4, 2]]
_EQUIVALENT = (
    "sqrt(((s_xx - s_yy)^2 + (s_yy - s_zz)^2 + (s_zz - s_xx)^2)/2 + 3*(s_xy^2 + s_yz^2 + s_zx^2))"
)
_EXPANDED = "von_mises"  # written out where numbers are put in
_GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "eta": "η", "theta": "θ",
    "lam": "λ", "mu": "μ", "nu": "ν", "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ",
    "chi": "χ", "omega": "ω", "Delta": "Δ", "Sigma": "Σ",
}  # fmt: skip
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


class FormulaError(ValueError):
    """A formula that cannot be read, or has no value; says which and why."""


def _von_mises(stress: FloatArray) -> float:
    return float(evaluate(_EQUIVALENT, _components(stress)))


def _components(stress: FloatArray) -> dict[str, Value]:
    return {f"s_{name}": float(value) for name, value in zip(COMPONENTS, stress, strict=True)}


def _traction(stress: FloatArray, normal: FloatArray) -> FloatArray:
    return np.asarray(stress[_TENSOR] @ normal)


def _normal_stress(stress: FloatArray, normal: FloatArray) -> float:
    return float(_traction(stress, normal) @ normal)


def _shear_stress(stress: FloatArray, normal: FloatArray) -> float:
    acting = _traction(stress, normal)
    return float(np.linalg.norm(acting - (acting @ normal) * normal))


def _largest_principal(stress: FloatArray) -> float:
    return float(np.linalg.eigvalsh(stress[_TENSOR])[-1])


def _circumradius(a: float, b: float, c: float) -> float:
    """Radius of the circle through the corners of a triangle with these sides."""
    s = (a + b + c) / 2
    return a * b * c / (4 * math.sqrt(s * (s - a) * (s - b) * (s - c)))


@dataclass(frozen=True)
class Function:
    """A function of formulas.

    shape    of its arguments: "1" a number each, "6" a stress, "63" a stress and a normal, "*" any
             number of numbers
    text     how it is written; {} is the list of arguments
    meaning  in words, empty for what every reader knows
    """

    work: Callable[..., float]
    shape: str
    text: str
    meaning: str = ""


FUNCTIONS: Mapping[str, Function] = {
    "sqrt": Function(math.sqrt, "1", "√({})"),
    "sin": Function(math.sin, "1", "sin({})"),
    "cos": Function(math.cos, "1", "cos({})"),
    "asin": Function(math.asin, "1", "asin({})"),
    "log10": Function(math.log10, "1", "lg({})"),
    "abs": Function(abs, "1", "|{}|"),
    "min": Function(min, "*", "min({})"),
    "max": Function(max, "*", "max({})"),
    "quantile": Function(
        lambda share: NormalDist().inv_cdf(share),
        "1",
        "z({})",
        "z(P): the standard normal variate that a share P lies below",
    ),
    "choose": Function(
        lambda value, limit, above, below: above if value > limit else below,
        "1111",
        "choose({})",
        "choose(a, b, c, d): c where a is above b, else d",
    ),
    "von_mises": Function(
        _von_mises,
        "6",
        "σ_vM({})",
        "σ_vM(s): von Mises stress, √(((s_xx − s_yy)² + (s_yy − s_zz)² + (s_zz − s_xx)²)/2 + "
        "3·(s_xy² + s_yz² + s_zx²))",
    ),
    "largest_principal": Function(
        _largest_principal, "6", "σ_I({})", "σ_I(s): largest principal stress of s"
    ),
    "normal_stress": Function(
        _normal_stress, "63", "σ_n({})", "σ_n(s, n) = n·s·n: stress of s across the plane of n"
    ),
    "shear_stress": Function(
        _shear_stress, "63", "τ_n({})", "τ_n(s, n): size of the shear stress of s in the plane of n"
    ),
    "circumradius": Function(
        _circumradius,
        "111",
        "R({})",
        "R(a, b, c): radius of the circle through the corners of a triangle with sides a, b, c",
    ),
}
# Functions of numbers as they are taken of the values at all positions.
_WORK_OF_EACH: Mapping[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "asin": np.arcsin,
    "log10": np.log10,
    "abs": np.abs,
    "min": lambda *values: reduce(np.minimum, values),
    "max": lambda *values: reduce(np.maximum, values),
}
_EACH = {name: replace(FUNCTIONS[name], work=work) for name, work in _WORK_OF_EACH.items()}
_BINARY: Mapping[type, tuple[str, int, Callable[[Value, Value], Value]]] = {
    ast.Add: (" + ", 1, operator.add),
    ast.Sub: (" − ", 1, operator.sub),
    ast.Mult: ("·", 2, operator.mul),
    ast.Div: ("/", 2, operator.truediv),
    ast.Pow: ("^", 4, operator.pow),
}
_SIGN, _POWER = 3, 4  # how strongly a sign and a power bind


@lru_cache(maxsize=4096)
def _tree(text: str) -> ast.expr:
    """The tree of a formula; raises FormulaError for what is none."""
    if len(text) > _LONGEST:
        raise FormulaError(f"a formula of {len(text)} characters is too long")
    try:
        tree = ast.parse(text.replace("^", "**").strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise FormulaError(f"{_cut(text)} is no formula: {error}") from None
    _check(tree, text, 0)
    return tree


def _check(node: ast.expr, text: str, depth: int) -> None:
    if depth > _DEEPEST:
        raise FormulaError(f"{_cut(text)} has more than {_DEEPEST} brackets inside each other")
    match node:
        case ast.Constant(value=bool()):
            raise FormulaError(f"{_cut(text)}: {ast.unparse(node)} is no number")
        case ast.Constant(value=int() | float() as value):
            if not abs(value) <= sys.float_info.max:
                raise FormulaError(f"{_cut(text)} has a number that is too large")
        case ast.Name():
            return
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            _check(inner, text, depth + 1)
        case ast.BinOp(left=left, right=right) if type(node.op) in _BINARY:
            _check(left, text, depth + 1)
            _check(right, text, depth + 1)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            shape = FUNCTIONS[name].shape
            if shape != "*" and len(arguments) != len(shape):
                told = f"{name} takes {len(shape)}, got {len(arguments)}"
                raise FormulaError(f"{_cut(text)}: {told}")
            for argument in arguments:
                _check(argument, text, depth + 1)
        case _:
            said = ast.get_source_segment(text.replace("^", "**").strip(), node)
            raise FormulaError(f"{_cut(text)}: {_cut(said or '')} is not understood")


def _cut(text: str) -> str:
    """A formula in a message: quoted, and not longer than a line."""
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…")


@lru_cache(maxsize=4096)
def functions_of(text: str) -> tuple[str, ...]:
    """Names of the functions of a formula, each once; raises FormulaError."""
    named = [
        node.func
        for node in ast.walk(_tree(text))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    ]
    named.sort(key=lambda name: (name.lineno, name.col_offset))
    return tuple(dict.fromkeys(name.id for name in named))


def evaluate(text: str, scope: Scope) -> Value:
    """Value of a formula: a float, or a float64 vector as the symbols are; raises FormulaError."""
    return _finite(_value_in(_work(text, each=False), text, scope), text)


def evaluate_each(text: str, scope: Scope) -> Value:
    """Values (n,) of a formula at n positions: of symbols that are numbers or have (n,) values.

    A float where no symbol has a value for each position. Raises FormulaError, also for a function
    that is none of numbers.

    >>> evaluate_each("max(F, 2)/d", {"F": np.array([1.0, 4.0]), "d": 2.0}).tolist()
    [1.0, 2.0]
    """
    return _finite(_value_in(_work(text, each=True), text, scope), text)


def _finite(value: Value, text: str) -> Value:
    if not (math.isfinite(value) if isinstance(value, float) else np.isfinite(value).all()):
        raise FormulaError(f"{_cut(text)} has no finite value")
    return value


def _value_in(work: Work, text: str, scope: Scope) -> Value:
    """Value of a formula, or of a part of it, which may be infinite; raises FormulaError."""
    try:
        with np.errstate(all="ignore"):
            return work(scope)
    except FormulaError as error:
        raise FormulaError(f"{_cut(text)}: {error}") from None
    except (ArithmeticError, TypeError, ValueError, np.linalg.LinAlgError) as error:
        raise FormulaError(f"{_cut(text)} has no value: {error}") from None


@lru_cache(maxsize=8192)
def _work(text: str, *, each: bool) -> Work:
    """A formula as a function of its symbols' values; raises FormulaError for what is none.

    each  True for values at all positions
    """
    return _work_of(_tree(text), _EACH if each else FUNCTIONS)


def _sound(value: object) -> Value:
    """A float or a float64 vector: no other number passes on the way."""
    if isinstance(value, float):
        return value
    if isinstance(value, np.ndarray) and value.dtype == np.float64 and value.ndim == 1:
        return value
    raise FormulaError(f"it has no value: {value!r} is neither a real number nor a vector")


def _work_of(node: ast.expr, functions: Mapping[str, Function]) -> Work:
    """A node as a function of the symbols' values: its tree is walked once for all values."""
    match node:
        case ast.Constant(value=int() | float() as value):
            constant = float(value)
            return lambda scope: constant
        case ast.Name(id=name):
            return partial(_symbol, name)
        case ast.UnaryOp(operand=inner):
            inside = _work_of(inner, functions)
            return lambda scope: _sound(-inside(scope))
        case ast.BinOp(left=left, right=right):
            one, other = (_work_of(side, functions) for side in (left, right))
            join = _BINARY[type(node.op)][2]
            return lambda scope: _sound(join(one(scope), other(scope)))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            works = [_work_of(argument, functions) for argument in arguments]
            return lambda scope: _sound(_called(name, [work(scope) for work in works], functions))
        case _:
            raise AssertionError("checked before")


def _symbol(name: str, scope: Scope) -> Value:
    if name in scope:
        return _sound(scope[name])
    if name == "pi":
        return math.pi
    raise FormulaError(f"the symbol {name!r} has no value")


def _called(name: str, values: Sequence[Value], functions: Mapping[str, Function]) -> object:
    """Value of a function at its arguments."""
    if name not in functions:
        raise FormulaError(f"{name} is no function of numbers")
    function = functions[name]
    if functions is _EACH:
        found = function.work(*values)
        return found if np.ndim(found) else float(found)
    shapes = function.shape if function.shape != "*" else "1" * len(values)
    for given, size in zip(values, shapes, strict=True):
        fits = size == "1" if isinstance(given, float) else len(given) == int(size) > 1
        if not fits:
            wanted = "a number" if size == "1" else f"a vector of {size}"
            raise FormulaError(f"{name} takes {wanted}, got {_size_text(given)}")
    return float(function.work(*values))


def _size_text(value: Value) -> str:
    return "a number" if isinstance(value, float) else f"a vector of {len(value)}"


def symbolic(text: str) -> str:
    """The formula with its symbols, as people read it; raises FormulaError.

    >>> symbolic("32*M/(pi*d^3)"), symbolic("k_a*S_e - a/(b*c)")
    ('32·M/(π·d³)', 'k_a·S_e − a/(b·c)')
    """
    return _written(_tree(text), lambda name: shown_symbol(name))


def substituted(text: str, scope: Scope, digits: int = 4) -> str:
    """The formula with numbers put in, to so many significant digits; raises FormulaError.

    >>> substituted("32*M/(pi*d^3)", {"M": 566000.0, "d": 40.0})
    '32·566000/(π·40³)'
    """
    tree = _tree(text)
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == _EXPANDED:
        try:
            stress = _value_in(_work_of(tree.args[0], FUNCTIONS), text, scope)
        except FormulaError:
            stress = 0.0
        if np.shape(stress) == (len(COMPONENTS),):
            return substituted(_EQUIVALENT, _components(np.asarray(stress)), digits)

    def put_in(name: str) -> str:
        if name not in scope:
            return shown_symbol(name)
        value = scope[name]
        return number_text(value, digits) if isinstance(value, float) else vector_text(value)

    return _written(tree, put_in)


def number_text(value: float, digits: int = 4) -> str:
    """A number to so many significant digits, with a true minus; whole numbers as they are.

    >>> number_text(-0.0123456), number_text(3.0), number_text(61180.4)
    ('−0.01235', '3', '61180')
    """
    if math.isfinite(value) and value == int(value) and abs(value) < 1000:
        return str(int(value)).replace("-", "−")
    return number(value, digits).replace("-", "−")


def vector_text(value: FloatArray) -> str:
    """The components of a vector in brackets."""
    return f"[{', '.join(number_text(float(one)) for one in value)}]"


def shown_symbol(name: str) -> str:
    """A symbol as people write it: Greek letters as such.

    >>> shown_symbol("sigma_a"), shown_symbol("F_cr"), shown_symbol("Delta_s")
    ('σ_a', 'F_cr', 'Δ_s')
    """
    first, _, rest = name.partition("_")
    shown = _GREEK.get(first, first)
    return f"{shown}_{_GREEK.get(rest, rest)}" if rest else shown or name


def _written(node: ast.expr, leaf: Callable[[str], str]) -> str:
    return _bound(node, leaf)[0]


def _bound(node: ast.expr, leaf: Callable[[str], str]) -> tuple[str, int]:
    """Text of a node, and how strongly its outermost sign binds."""
    match node:
        case ast.Constant(value=int() | float() as constant):
            return f"{float(constant):.12g}", 9
        case ast.Name(id=name):
            text = leaf(name)
            scaled = text[0].isdigit() and "e" in text  # a power of ten is no single sign
            return text, _SIGN if text.startswith("−") else _POWER if scaled else 9
        case ast.UnaryOp(operand=inner):
            text, strength = _bound(inner, leaf)
            return f"−{text if strength > _SIGN else f'({text})'}", _SIGN
        case ast.BinOp(left=left, right=right):
            sign, own, _ = _BINARY[type(node.op)]
            one, strength = _bound(left, leaf)
            other, second = _bound(right, leaf)
            if sign == "^":
                base = one if strength > _POWER else f"({one})"
                return _power(base, other, second), _POWER
            if strength < own:
                one = f"({one})"
            if second < own or (second == own and sign in (" − ", "/")) or other.startswith("−"):
                other = f"({other})"
            return f"{one}{sign}{other}", own
        case ast.Call(func=ast.Name(id=name), args=arguments):
            inside = ", ".join(_bound(argument, leaf)[0] for argument in arguments)
            return FUNCTIONS[name].text.replace("{}", inside), 9
        case _:
            raise AssertionError("checked before")


def _power(base: str, exponent: str, strength: int) -> str:
    plain = exponent.replace("−", "-")
    if plain.lstrip("-").isdigit():
        return f"{base}{plain.translate(_RAISED)}"
    return f"{base}^{exponent if strength > _POWER else f'({exponent})'}"
