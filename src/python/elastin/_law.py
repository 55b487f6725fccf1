"""Cell laws of one's own, from an energy of the invariants."""

import inspect
import numbers
import operator

import numpy

from . import _elastin
from ._elastin import InputError, Parameter

OF_MATERIAL = ("E", "nu", "mu", "lam", "kappa")


OPERATORS = {numpy.add: operator.add, numpy.subtract: operator.sub, numpy.multiply: operator.mul,
             numpy.divide: operator.truediv, numpy.power: operator.pow, numpy.float_power: operator.pow,
             numpy.negative: operator.neg, numpy.positive: operator.pos, numpy.less: operator.lt,
             numpy.less_equal: operator.le, numpy.greater: operator.gt, numpy.greater_equal: operator.ge}


class Value:
    """A value of an energy, as the operations that make it: `operation` (kind, values that it takes, number, parameter)
    plus `offset`. The offset is kept apart, so that I1 - 3 and J - 1 lose no digit near rest."""

    __array_priority__ = 1000

    def __init__(self, kind, of=(), number=0.0, parameter="", offset=0.0):
        self.operation, self.offset = (kind, of, float(number), parameter), float(offset)

    def moved(self, by):
        result = Value("number")
        result.operation, result.offset = self.operation, self.offset + by
        return result

    def whole(self):
        """With its offset among the operations."""
        if self.offset == 0:
            return self
        return Value("add", (self.moved(-self.offset), Value("number", number=self.offset)))

    def __add__(self, other):
        if isinstance(other, numbers.Real):
            return self.moved(other)
        other = value_of(other)
        return Value("add", (self.moved(-self.offset), other.moved(-other.offset)), offset=self.offset + other.offset)

    __radd__ = __add__

    def __neg__(self):
        return Value("negate", (self.moved(-self.offset),), offset=-self.offset)

    def __pos__(self):
        return self

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        return Value("multiply", (self.whole(), value_of(other).whole()))

    __rmul__ = __mul__

    def __truediv__(self, other):
        return Value("divide", (self.whole(), value_of(other).whole()))

    def __rtruediv__(self, other):
        return Value("divide", (value_of(other).whole(), self.whole()))

    def __pow__(self, other):
        if isinstance(other, numbers.Real) and other == 2 and self.offset == 0:
            return Value("square", (self,))
        if self.offset == 1 and isinstance(other, numbers.Integral) and 2 <= other <= 8:
            below = self.moved(-1) if other == 2 else self ** (other - 1) - 1  # (1 + x)^n = 1 + x + (1 + x)(…^(n-1) - 1)
            return self.moved(-1) + self * below + 1
        if self.offset == 1:  # (1 + x)^p = 1 + (e^(p ln(1 + x)) - 1)
            inner = Value("log1p", (self.moved(-1),))
            return Value("expm1", ((inner * other).whole(),), offset=1)
        return Value("power", (self.whole(), value_of(other).whole()))

    def __rpow__(self, other):
        return Value("power", (value_of(other).whole(), self.whole()))

    def __abs__(self):
        return Value("absolute", (self.whole(),))

    def __lt__(self, other):
        return Value("less", (self.whole(), value_of(other).whole()))

    def __gt__(self, other):
        return Value("less", (value_of(other).whole(), self.whole()))

    __le__, __ge__ = __lt__, __gt__

    def __bool__(self):
        raise InputError("an energy cannot branch on its invariants with `if`, `and`, `min` or `max`; write "
                         "elastin.where(J < 1, one, other), numpy.maximum or numpy.minimum")

    def __float__(self):
        raise InputError("an energy is traced, not computed: take numpy's functions (numpy.log), not those of math")

    def apply(self, kind):
        if kind == "log" and self.offset == 1:
            return Value("log1p", (self.moved(-1),))
        if kind == "exp" and self.offset == 0:
            return Value("expm1", (self,), offset=1)
        if kind == "sqrt" and self.offset == 1:
            return self ** 0.5
        return Value(kind, (self.whole(),))

    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        name, known = ufunc.__name__, _elastin._energy_operations()
        if method == "__call__" and not options:
            if ufunc in OPERATORS:
                return OPERATORS[ufunc](*map(value_of, inputs))
            if name in ("maximum", "minimum"):
                return Value(name, tuple(value_of(one).whole() for one in inputs))
            if ufunc is numpy.square:
                return self ** 2
            if known.get(name) == 1:
                return self.apply(name)
        raise InputError(f"an energy cannot take numpy.{name}; allowed: "
                         + ", ".join(one for one in known if hasattr(numpy, one)))

    def __array_function__(self, function, types, given, options):
        if function is numpy.where and len(given) == 3 and not options:
            return where(*given)
        raise InputError(f"an energy cannot take numpy.{function.__name__}")


def value_of(given):
    if isinstance(given, Value):
        return given
    if isinstance(given, numbers.Real):
        return Value("number", number=given)
    raise InputError(f"an energy is made of invariants, parameters and numbers, not of a {type(given).__name__}")


def where(condition, one, other):
    """In an energy of elastin.law: `one` where the condition holds (J < 1), else `other`. Elsewhere as numpy.where."""
    if not any(isinstance(given, Value) for given in (condition, one, other)):
        return numpy.where(condition, one, other)
    return Value("select", tuple(value_of(given).whole() for given in (condition, one, other)))


def invariants():
    """I1, I2, J, I4, I5 and what follows from them, by name."""
    J = Value("swelling", offset=1)
    I1, I2 = Value("first", offset=3), Value("second", offset=3)
    I4, I5 = Value("fibre", offset=1), Value("fibre_square", offset=1)

    def isochoric(invariant, power):
        """J^power I, r at rest: r + r (J^power - 1) + J^power (I - r)."""
        stretch, rest = J ** power, invariant.offset
        return (rest * stretch.moved(-1) + stretch * invariant.moved(-rest)) + rest

    return {"I1": I1, "I2": I2, "J": J, "I3": J**2, "I1_bar": isochoric(I1, -2 / 3), "I2_bar": isochoric(I2, -4 / 3),
            "I4": I4, "I5": I5, "I4_bar": isochoric(I4, -2 / 3), "I5_bar": isochoric(I5, -4 / 3)}


def operations_of(value):
    """The list that C++ takes: each value once, before those that take it."""
    numbered, operations = {}, []

    def add(one):
        kind, of, number, parameter = one.operation
        if id(one.operation) not in numbered:
            taken = [add(other) for other in of]
            operations.append((kind, taken, number, parameter))
            numbered[id(one.operation)] = len(operations) - 1
        return numbered[id(one.operation)]

    add(value.whole())
    return operations


def law(name, energy, *, summary="", source="", membrane=False):
    """A cell law of one's own for compare, run and Simulation, from its energy density W [J/m^3]:

        elastin.law("mine", lambda I1, J, mu, lam: mu / 2 * (I1 - 3) - mu * numpy.log(J) + lam / 2 * (J - 1)**2)

    The names of the function's arguments determine their meaning: of the right Cauchy-Green tensor C the invariants I1 = tr C,
    I2, I3 = J^2, J and those of J^(-2/3) C, I1_bar and I2_bar, all at the rest values 3, 3, 1; of fibres along a unit
    vector a at rest I4 = a.Ca, I5 = a.CCa, I4_bar and I5_bar, 1 at rest; of the material E, nu, mu,
    lam and kappa [Pa]. Every other argument is a parameter that a scene may set and has a default, a number or a
    Parameter. A law of solids is a material's, too, and then has its constants and the direction a from there:
    {"law": mine, "k": 3e4, "direction": [0, 0, 1]}, in scenes by its name; E and nu follow, unless W takes them, and
    identify() finds the constants. The function is called once, with values that record what it computes by + - * / **, numpy's functions and
    elastin.where; slopes and second slopes follow by the rules of differentiation, so they are exact, and run in C++.
    With membrane=True it is a law of membranes, which thin so that there is no stress across.
    Raises InputError where W has a stress at rest, or is unstable there, as soon as the law meets a material."""
    known, parameters, arguments = invariants(), [], {}
    for argument, described in inspect.signature(energy).parameters.items():
        if argument in known:
            arguments[argument] = known[argument]
            continue
        arguments[argument] = Value("parameter", parameter=argument)
        if argument in OF_MATERIAL:
            continue
        default = described.default
        if default is described.empty:
            allowed = [*known, *OF_MATERIAL]
            raise InputError(f"law '{name}': argument '{argument}' has no default"
                             + _elastin._suggestion(argument, allowed) + ", or a parameter with a default")
        parameters.append(default if isinstance(default, Parameter) else Parameter(argument, default))
    made = energy(**arguments)
    if not isinstance(made, Value):
        raise InputError(f"law '{name}': the energy is {made!r}, and depends on no invariant")
    described = [(one.name, one.default, one.low, one.high, one.text) for one in parameters]
    return _made(name, operations_of(made), described, summary, source, 2 if membrane else 3)


def _made(name, operations, parameters, summary, source, dimensions):
    """The law that a pickle describes."""
    described = [Parameter(one, default, low=low, high=high, text=text) for one, default, low, high, text in parameters]
    strategy = _elastin._energy_law(name, operations, described, summary, source, dimensions)
    strategy._made_by = (_made, (name, operations, parameters, summary, source, dimensions))
    return strategy
