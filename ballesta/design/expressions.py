"""Reads a force that a design states as a formula over coordinates and their rates.

Python's `ast` parses the text, which is never run: numbers, + - * / **, the functions of
`loads.FUNCTIONS`, the names of `where`, coordinates such as B.x and their `rate` pass, all else is
refused. Every step has its unit, so that a sum of a force and a length is refused, too.

`coordinate_of` reads one coordinate, such as A.y or cylinder.length.
"""

import ast
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

import loads
from ballesta.design.files import Reading
from ballesta.design.forces import dimension_of
from checks.design.errors import Problems, listed, nearest, no_such
from checks.design.tables import ExpressionLaw
from checks.design.units import ANGLE, DIMENSIONS, MOST, PLAIN, Powers, powers_of, title_of
from checks.result.words import brief
from geometry.parameters import ParameterError

_LONGEST = 400  # characters
_DEEPEST = 60  # terms within terms
_MOST_POWER = 10.0
_MOST_CONSTANT = 1e30  # N, mm, s, t
_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**",
}  # fmt: skip
_OF_ANGLE = ("sin", "cos", "tan")
_TO_ANGLE = ("asin", "acos", "atan")
_ALIKE = ("min", "max", "abs")  # give what they are given
_CALLED = sorted(name for name in loads.FUNCTIONS if name.isalpha())
_HINTS = {
    ast.BitXor: "a power is written **",
    ast.Compare: "a force that jumps is one of several phases, or { dry = ... } against the motion",
    ast.IfExp: "a force that jumps is one of several phases, or { dry = ... } against the motion",
}


@dataclass(frozen=True)
class _Value:
    """A term and the powers of its unit; None of a plain 0, which has any unit."""

    term: loads.Term
    powers: Powers | None


class _WrongError(ValueError):
    """A fault of a formula, in words."""


def expression_of(read: Reading, key: str, force: str, entry: ExpressionLaw) -> loads.Expression:
    """Return the formula of a force; raises ParameterError."""
    told = len(read.problems)
    where = _constants(f"{key}.where", entry, read.problems)
    if len(read.problems) > told:
        raise ParameterError("", "")
    reader = _Reader(entry.expression, where, lambda text: coordinate_of(read, text))
    try:
        found = reader.read()
        _check_result(force, dimension_of(read.file.forces[force]), found.powers)
    except ParameterError as error:
        raise ParameterError("expression", error.problem) from error
    except _WrongError as error:
        raise ParameterError("expression", str(error)) from error
    unused = next((name for name in where if name not in reader.used), None)
    if unused is not None:
        raise ParameterError(f"where.{unused}", "is not in the expression; leave it out")
    stated = ", ".join(f"{name} = {value.text}" for name, value in (entry.where or {}).items())
    text = " ".join(entry.expression.split())
    return loads.Expression(f"{text} with {stated}" if stated else text, found.term)


def _constants(key: str, entry: ExpressionLaw, problems: Problems) -> dict[str, _Value]:
    found = {}
    for name, value in (entry.where or {}).items():
        if name in (*_CALLED, "rate"):
            problems.add(f"{key}.{name}", f"{name} is a function; choose another name")
            continue
        if not name.isidentifier():
            problems.add(f"{key}.{name}", "a name in a formula has letters, digits and _ only")
            continue
        found[name] = _Value(loads.Number(value.value), value.powers)
    return found


def _check_result(force: str, wanted: str, powers: Powers | None) -> None:
    own = powers_of(DIMENSIONS[wanted].unit)
    if powers is None or powers == own:
        return
    kind = "torque" if wanted == "moment" else "force"
    hint = ""
    if {**powers, "radian": 0} == {**own, "radian": 0}:
        hint = '; a factor of an angle is stated for each rad, such as "60 mm/rad"'
    raise _WrongError(
        f"must come out as {DIMENSIONS[wanted].title}, as {force} is a {kind}; "
        f"it is {title_of(powers)}{hint}"
    )


class _Reader:
    """One formula; `used` are the names of `where` that it has had so far."""

    def __init__(
        self,
        text: str,
        where: Mapping[str, _Value],
        coordinate: Callable[[str], loads.Coordinate],
    ) -> None:
        self._text, self._where, self._coordinate = text.strip(), where, coordinate
        self.used: set[str] = set()

    def read(self) -> _Value:
        """Return the whole formula."""
        if len(self._text) > _LONGEST:
            raise _WrongError(
                f"has {len(self._text)} characters, at most {_LONGEST} are read; a table says more"
            )
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", SyntaxWarning)
                warnings.simplefilter("ignore", DeprecationWarning)
                tree = ast.parse(self._text, mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise _WrongError(
                f'is no formula such as "-F * (L / spring.length)**1.2", got "{self._shown()}"; '
                'numbers with units stand in where, such as where = { F = "400 N" }'
            ) from None
        return self._value(tree.body, 0)

    def _shown(self, node: ast.AST | None = None) -> str:
        part = self._text if node is None else ast.get_source_segment(self._text, node)
        return brief(part or self._text, 60)

    def _value(self, node: ast.expr, depth: int) -> _Value:
        if depth > _DEEPEST:
            raise _WrongError(f"has more than {_DEEPEST} terms within each other")
        match node:
            case ast.Constant(int() | float() as number) if not isinstance(number, bool):
                if not abs(number) <= MOST:
                    raise _WrongError(f"{self._shown(node)} is beyond any machine")
                return _Value(loads.Number(float(number)), PLAIN if number else None)
            case ast.Name(name):
                if name not in self._where:
                    raise _WrongError(no_such("value in where", name, self._where))
                self.used.add(name)
                return self._where[name]
            case ast.Attribute():
                return self._read(node, rate=False)
            case ast.UnaryOp(ast.UAdd() | ast.USub(), inner):
                value = self._value(inner, depth + 1)
                return self._negative(value) if isinstance(node.op, ast.USub) else value
            case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
                return self._binary(
                    node,
                    _OPERATORS[type(operator)],
                    self._value(left, depth + 1),
                    self._value(right, depth + 1),
                )
            case ast.Call(ast.Name(name), terms, []):
                return self._call(node, name, terms, depth)
        kind = type(node.op) if isinstance(node, ast.BinOp) else type(node)
        hint = _HINTS.get(kind, f"+ - * / **, {', '.join(_CALLED)} and rate are")
        raise _WrongError(f"{self._shown(node)} is not read in a formula; {hint}")

    def _read(self, node: ast.expr, rate: bool) -> _Value:
        coordinate = self._coordinate(self._shown(node))
        unit = DIMENSIONS[dimension_along(coordinate)].unit + ("/s" if rate else "")
        return _Value(loads.Reading(coordinate, rate), powers_of(unit))

    @staticmethod
    def _negative(value: _Value) -> _Value:
        if isinstance(value.term, loads.Number):
            return _Value(loads.Number(-value.term.value), value.powers)
        return _Value(loads.Apply("*", (loads.Number(-1.0), value.term)), value.powers)

    def _call(self, node: ast.Call, name: str, terms: list[ast.expr], depth: int) -> _Value:
        if name == "rate":
            if len(terms) != 1 or not isinstance(terms[0], ast.Attribute):
                raise _WrongError(f"rate takes a coordinate such as B.x, not {self._shown(node)}")
            return self._read(terms[0], rate=True)
        if name not in _CALLED:
            hint = "; a force that jumps is { dry = ... } against the motion"
            raise _WrongError(
                no_such("function", name, (*_CALLED, "rate"))
                + (hint if name in ("sign", "sgn", "step") else "")
            )
        _, least, most = loads.FUNCTIONS[name]
        if not least <= len(terms) <= most:
            count = "one term" if most == 1 else f"{least} to {most} terms"
            raise _WrongError(f"{name} takes {count}, {self._shown(node)} has {len(terms)}")
        values = [self._value(term, depth + 1) for term in terms]
        term = loads.Apply(name, tuple(value.term for value in values))
        powers = self._alike(node, values)
        if name in _ALIKE:
            return _Value(term, powers)
        if name == "sqrt":
            return _Value(term, None if powers is None else _raised(powers, 0.5))
        wanted_powers, what = (
            (ANGLE, "an angle") if name in _OF_ANGLE else (PLAIN, "a plain number")
        )
        if powers is None:
            powers = wanted_powers
        if powers != wanted_powers:
            raise _WrongError(f"{name} takes {what}, {self._shown(terms[0])} is {title_of(powers)}")
        return _Value(term, ANGLE if name in _TO_ANGLE else PLAIN)

    def _alike(self, node: ast.expr, values: list[_Value]) -> Powers | None:
        """The powers that all have; _WrongError where they differ."""
        stated = [value.powers for value in values if value.powers is not None]
        for other in stated[1:]:
            if other != stated[0]:
                raise _WrongError(
                    f"{self._shown(node)} puts {title_of(stated[0])} and {title_of(other)} together"
                )
        return stated[0] if stated else None

    def _binary(self, node: ast.BinOp, operator: str, left: _Value, right: _Value) -> _Value:
        if operator == "**":
            return self._power(node, left, right)
        term = self._joined(node, operator, left.term, right.term)
        if operator in "+-":
            return _Value(term, self._alike(node, [left, right]))
        one, other = left.powers or PLAIN, right.powers or PLAIN
        return _Value(term, _product(one, other, 1.0 if operator == "*" else -1.0))

    def _joined(
        self, node: ast.BinOp, operator: str, left: loads.Term, right: loads.Term
    ) -> loads.Term:
        """Two terms joined; two numbers become one, so that 2/3 may be an exponent."""
        if not (isinstance(left, loads.Number) and isinstance(right, loads.Number)):
            return loads.Apply(operator, (left, right))
        with np.errstate(all="ignore"):
            number = float(loads.FUNCTIONS[operator][0](left.value, right.value))
        if not abs(number) <= _MOST_CONSTANT:
            raise _WrongError(f"{self._shown(node)} is no number of a machine")
        return loads.Number(number)

    def _power(self, node: ast.BinOp, base: _Value, exponent: _Value) -> _Value:
        power = exponent.term
        if not isinstance(power, loads.Number) or exponent.powers not in (None, PLAIN):
            raise _WrongError(
                f"{self._shown(node)}: an exponent must be a plain number, and "
                f"{self._shown(node.right)} is not"
            )
        if abs(power.value) > _MOST_POWER:
            raise _WrongError(f"{self._shown(node)}: exponents go to {_MOST_POWER:g}")
        powers = _raised(base.powers or PLAIN, power.value)
        return _Value(self._joined(node, "**", base.term, power), powers)


def _raised(powers: Powers, power: float) -> Powers:
    return _product(PLAIN, powers, power)


def _product(one: Powers, other: Powers, power: float) -> Powers:
    """Powers of one unit times a power of another one; rounded, so that 3 x 1/3 is 1."""
    names = one.keys() | other.keys()
    summed = {
        name: round(one.get(name, 0.0) + power * other.get(name, 0.0), 9) for name in sorted(names)
    }
    return {name: value for name, value in summed.items() if value}


def coordinate_of(read: Reading, text: str) -> loads.Coordinate:
    """Return the coordinate that a text names; raises ParameterError."""
    file = read.file
    name, _, what = text.rpartition(".")
    pins = dict.fromkeys(pin for body in file.bodies.values() for pin in body.pins)
    pulling = [force for force, entry in file.forces.items() if entry.between is not None]
    kinds = {
        "x": ("point on a body", list(pins)),
        "y": ("point on a body", list(pins)),
        "angle": ("body", list(file.bodies)),
        "length": ("force between two points", pulling),
    }
    if what not in kinds or not name:
        guess = nearest(what, kinds) if name else None
        hint = f", did you mean {name}.{guess}?" if guess else ""
        raise ParameterError(
            "",
            "must be <point>.x, <point>.y, <body>.angle or <force>.length, "
            f'got "{text}"{hint}; points {listed(pins)}; bodies {listed(file.bodies)}; '
            f"forces {listed(pulling)}",
        )
    kind, known = kinds[what]
    if name not in known:
        raise ParameterError("", no_such(kind, name, known))
    if what == "length":
        if name not in read.forces:
            raise ParameterError("", "")  # what is wrong with it was told there
        return read.forces[name].coordinate
    if what == "angle":
        return loads.Angle(name)
    owner = next(body for body, entry in file.bodies.items() if name in entry.pins)
    return loads.PointCoordinate(owner, name, (1.0, 0.0) if what == "x" else (0.0, 1.0))


def dimension_along(coordinate: loads.Coordinate) -> str:
    """Dimension of a coordinate's values: "angle" or "length"."""
    return "angle" if coordinate.angular else "length"
