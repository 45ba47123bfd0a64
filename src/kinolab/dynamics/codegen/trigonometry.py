"""Sine and cosine of an angle as LLVM IR, the same in lanes as alone.

Calls of the C library take most of the time of many equations of motion, go through lanes one
after the other, and differ in the last bit between libraries. What is emitted here is inlined and
computes all lanes at once; only beyond LARGEST it asks the library.

Source: Cody, Waite, Software manual for the elementary functions, 1980, for the reduction to
[-pi/4, pi/4]; the polynomials there are those of fdlibm (Sun Microsystems, 1993).
"""

from __future__ import annotations

from collections.abc import Sequence

from kinolab.dynamics.codegen.llvm import Register, Routine, in_lanes

NAME = "sine_and_cosine"  # of the function that computes both

# pi/2 in three parts; the first two have so few bits that 2^20 times them is exact.
HALF_PI = (1.57079632673412561417e0, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
PER_HALF_PI = 6.36619772367581382433e-1
LARGEST = 2.0**20  # [rad]
# sin r = r + r^3 (s0 + s1 r^2 + ...), cos r = 1 - r^2/2 + r^4 (c0 + c1 r^2 + ...)
SINE = (
    -1.66666666666666324348e-1,
    8.33333333332248946124e-3,
    -1.98412698298579493134e-4,
    2.75573137070700676789e-6,
    -2.50507602534068634195e-8,
    1.58969099521155010221e-10,
)
COSINE = (
    4.16666666666666019037e-2,
    -1.38888888888741095749e-3,
    2.48015872894767294178e-5,
    -2.75573143513906633035e-7,
    2.08757232129817482790e-9,
    -1.13596475577881948265e-11,
)


def sine_and_cosine(routine: Routine, angle: Register) -> tuple[Register, Register]:
    """Emit sine and cosine of an angle in [rad], to 2 units in the last place."""
    pair = _pair(routine.number)
    name = NAME + in_lanes(routine.lanes)
    both = routine.line(f"call {pair} @{name}({routine.number} {angle})")
    sine, cosine = (routine.line(f"extractvalue {pair} {both}, {k}") for k in range(2))
    return sine, cosine


def emit_sine_and_cosine(lanes: int) -> str:
    """Return the function that ``sine_and_cosine`` calls; compilers inline it."""
    number = Routine("", [], lanes=lanes).number
    routine = Routine(
        NAME + in_lanes(lanes), [(number, "angle")], result=_pair(number), private=True,
        lanes=lanes, inlined=True,
    )  # fmt: skip
    quadrant, r = _reduced(routine, "%angle")
    square = routine.mul(r, r)
    sine = routine.mul(routine.mul(square, r), _polynomial(routine, SINE, square))
    short = routine.add(r, sine), _cosine(routine, square)
    even = routine.line(f"icmp eq {_bits(routine)} {_masked(routine, quadrant, 1)}, "
                        f"{_integer(routine, 0)}")  # fmt: skip
    after = routine.line(f"add {_bits(routine)} {quadrant}, {_integer(routine, 1)}")
    near = [
        _signed(routine, routine.select(even, *short), quadrant),
        _signed(routine, routine.select(even, *short[::-1]), after),
    ]
    pair, both = _pair(number), "poison"
    for k, value in enumerate(_asked_of_library_where_far(routine, near)):
        both = routine.line(f"insertvalue {pair} {both}, {number} {value}, {k}")
    routine.give(both)
    return routine.text()


def _reduced(routine: Routine, angle: Register) -> tuple[Register, Register]:
    """Return an angle's quadrant, whose two lowest bits count, and what is left of it in [rad]."""
    # 1.5 * 2.0**52: what a number is added to has the nearest integer in its lowest bits
    rounder = routine.constant(1.5 * 2.0**52)
    rounded = routine.add(routine.mul(angle, routine.constant(PER_HALF_PI)), rounder)
    quadrant = routine.line(f"bitcast {routine.number} {rounded} to {_bits(routine)}")
    turns = routine.line(f"fsub {routine.number} {rounded}, {rounder}")
    for part in HALF_PI:
        angle = routine.sub(angle, routine.mul(turns, routine.constant(part)))
    return quadrant, angle


def _cosine(routine: Routine, square: Register) -> Register:
    """Emit 1 - z/2 + ..., with what rounding took from 1 - z/2 given back."""
    one, half = routine.constant(1.0), routine.mul(square, routine.constant(0.5))
    most = routine.line(f"fsub {routine.number} {one}, {half}")
    lost = routine.line(f"fsub {routine.number} {one}, {most}")
    lost = routine.line(f"fsub {routine.number} {lost}, {half}")
    rest = routine.mul(routine.mul(square, square), _polynomial(routine, COSINE, square))
    return routine.add(most, routine.add(lost, rest))


def _polynomial(routine: Routine, factors: Sequence[float], z: Register) -> Register:
    """Emit a polynomial of degree 5, in pairs, which do not wait for each other (Estrin)."""
    pairs = [
        routine.add(routine.mul(routine.constant(high), z), routine.constant(low))
        for low, high in zip(factors[::2], factors[1::2], strict=True)
    ]
    square = routine.mul(z, z)
    upper = routine.add(routine.mul(pairs[2], square), pairs[1])
    return routine.add(routine.mul(upper, square), pairs[0])


def _signed(routine: Routine, value: Register, quadrant: Register) -> Register:
    """Return a number with its sign changed where the quadrant's second bit is set."""
    bits = _bits(routine)
    sign = routine.line(f"shl {bits} {_masked(routine, quadrant, 2)}, {_integer(routine, 62)}")
    own = routine.line(f"bitcast {routine.number} {value} to {bits}")
    turned = routine.line(f"xor {bits} {own}, {sign}")
    return routine.line(f"bitcast {bits} {turned} to {routine.number}")


def _asked_of_library_where_far(routine: Routine, near: Sequence[Register]) -> list[Register]:
    """Return sine and cosine, the library's where the angle is not at most LARGEST."""
    size = routine.intrinsic("fabs", "%angle")
    far = routine.compare("ugt", size, routine.constant(LARGEST))  # NaN included
    any_far = far
    if routine.lanes > 1:
        packed = routine.line(f"bitcast {routine.truth} {far} to i{routine.lanes}")
        any_far = routine.line(f"icmp ne i{routine.lanes} {packed}, 0")
    any_far = routine.line(f"call i1 @llvm.expect.i1(i1 {any_far}, i1 false)")
    cells = [routine.cell(routine.number, value) for value in near]
    with routine.when(any_far):
        for cell, name, value in zip(cells, ("sin", "cos"), near, strict=True):
            known = routine.intrinsic(name, "%angle")
            routine.put(routine.number, cell, routine.select(far, known, value))
    return [routine.get(routine.number, cell) for cell in cells]


def _pair(number: str) -> str:
    """Return the type of two numbers of a type."""
    return f"{{{number}, {number}}}"


def _bits(routine: Routine) -> str:
    """Return the type of integers as long as a number."""
    return "i64" if routine.lanes == 1 else f"<{routine.lanes} x i64>"


def _integer(routine: Routine, value: int) -> str:
    if routine.lanes == 1:
        return str(value)
    return "<" + ", ".join([f"i64 {value}"] * routine.lanes) + ">"


def _masked(routine: Routine, value: Register, mask: int) -> Register:
    return routine.line(f"and {_bits(routine)} {value}, {_integer(routine, mask)}")
