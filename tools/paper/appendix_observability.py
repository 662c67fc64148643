#!/usr/bin/env python3
"""The paper's section IV-B and appendix, by symbolic differentiation: appendix_observability.py

The Lie derivatives of the bearing along the paper's f1 and f2 (its eq. 21), the printed formulas
(A.2) to (A.5) beside the right ones, the determinant of the five gradients, and the ranks where it
is zero. Angles whose sines and cosines are rational make every number below exact: two formulas are
called equal when they agree exactly at 5 random points, and a rank is that of rational numbers.
Prints Markdown, and a line `missed: ...` and status 1 for what is not as model.md says.
"""

import random
import sys

import sympy
from sympy import Matrix, Rational, cos, diff, expand_trig, sin

D, THETA, PHI, RHO, PSI = sympy.symbols('D theta phi rho psi', real=True)
STATE = (D, THETA, PHI, RHO, PSI)
F1 = (cos(THETA), -sin(THETA) / D, 0, 0, 0)
F2 = (0, 1, 0, 0, 0)
BETA = (sympy.atan2(-RHO * sin(THETA + PHI), -D - RHO * cos(THETA + PHI)) - THETA - PHI - PSI)
GAMMA = D**2 + RHO**2 + 2 * RHO * D * cos(THETA + PHI)
POINTS = 5
SINES = sympy.symbols('s_theta c_theta s_phi c_phi')

# name: right formula, formula as printed (the appendix prints theta for theta + phi in gamma).
PRINTED_GAMMA = D**2 + RHO**2 + 2 * RHO * D * cos(THETA)
A4 = (D * cos(THETA) * (D**2 + RHO**2) - 2 * RHO**2 * D * sin(THETA + PHI) * sin(PHI)
      + 2 * RHO * D**2 * cos(PHI))
A5 = -D * RHO * sin(THETA + PHI) * (D**2 - RHO**2)
FORMULAS = {
    '(A.2)': ((D * sin(THETA) - RHO * sin(PHI)) / GAMMA,
              (D * sin(THETA) - RHO * sin(PHI)) / PRINTED_GAMMA),
    '(A.3)': (-(D * RHO * cos(THETA + PHI) + D**2) / GAMMA,
              (D * RHO * cos(THETA) + D**2) / PRINTED_GAMMA),
    '(A.4)': (A4 / GAMMA**2,
              (D * cos(THETA) * (D**2 + RHO**2) - 2 * RHO**2 * D * sin(THETA) * sin(PHI)
               + 2 * RHO * D**2 * cos(PHI)) / PRINTED_GAMMA**2),
    '(A.5)': (A5 / GAMMA**2, D * RHO * sin(THETA) * (D**2 - RHO**2) / PRINTED_GAMMA**2),
}
DETERMINANT = D**2 * RHO * (D**2 - RHO**2) * (D + RHO * cos(THETA + PHI)) / GAMMA**5


def lieDerivative(function, field):
    return sum(diff(function, x) * f for x, f in zip(STATE, field))


def algebraic(expression):
    """The same in sines and cosines of theta and phi as symbols of their own."""
    expression = expand_trig(expression)
    return expression.subs(dict(zip((sin(THETA), cos(THETA), sin(PHI), cos(PHI)), SINES)))


def rationalAngle(half_tangent):
    """(sine, cosine) of twice the arc tangent."""
    square = half_tangent**2
    return 2 * half_tangent / (1 + square), (1 - square) / (1 + square)


def pointOf(distance, rho, half_theta, half_phi):
    values = rationalAngle(half_theta) + rationalAngle(half_phi)
    return {D: distance, RHO: rho, **dict(zip(SINES, values))}


def randomPoints():
    numbers = random.Random(1)

    def number():
        return Rational(numbers.randint(1, 50), numbers.randint(1, 50))
    return [pointOf(number(), number(), number(), -number()) for _ in range(POINTS)]


def areEqual(first, second):
    difference = algebraic(first - second)
    return all(difference.subs(point) == 0 for point in randomPoints())


def gradientsOf(functions):
    return Matrix([[algebraic(diff(function, x)) for x in STATE] for function in functions])


def lieDerivatives():
    """The five of the appendix in its order, and those of the third order besides."""
    along_1 = lieDerivative(BETA, F1)
    along_2 = lieDerivative(BETA, F2)
    five = [BETA, along_1, along_2, lieDerivative(along_1, F2), lieDerivative(along_2, F2)]
    more = [lieDerivative(along_2, F1), lieDerivative(along_1, F1)]
    more += [lieDerivative(function, field) for function in five[3:] for field in (F1, F2)]
    return five, more


def specialPoints():
    """Where the determinant is zero: (words, point). cos(theta + phi) = -3/5 in all of them."""
    half_theta, half_sum = Rational(1, 3), Rational(2)   # cos of twice atan 2 is -3/5
    half_phi = (half_sum - half_theta) / (1 + half_sum * half_theta)
    return [('anywhere else', pointOf(Rational(2), Rational(1, 10), half_theta, half_phi)),
            ('D = rho', pointOf(Rational(1), Rational(1), half_theta, half_phi)),
            ('D = -rho cos(theta + phi)', pointOf(Rational(3), Rational(5), half_theta, half_phi)),
            ('rho = 0', pointOf(Rational(2), Rational(0), half_theta, half_phi))]


EXPECTED_RANKS = {'anywhere else': (5, 5), 'D = rho': (4, 5),
                  'D = -rho cos(theta + phi)': (4, 5), 'rho = 0': (4, 4)}


def main():
    five, more = lieDerivatives()
    missed = []
    print('| formula | as printed | as corrected here |\n|---|---|---|')
    for (name, (right, printed)), derivative in zip(FORMULAS.items(), five[1:]):
        is_right, is_printed = areEqual(derivative, right), areEqual(derivative, printed)
        print('| %s | %s | %s |' % (name, 'right' if is_printed else 'wrong',
                                    'right' if is_right else 'wrong'))
        if not is_right or is_printed:
            missed.append(name)
    gradients = gradientsOf(five)
    all_gradients = gradientsOf(five + more)
    formula = algebraic(DETERMINANT)
    agrees = all(gradients.subs(point).det(method='berkowitz')**2 == formula.subs(point)**2
                 for point in randomPoints())
    print('\nDeterminant of the five gradients: +-D^2 rho (D^2 - rho^2) (D + rho cos(theta + phi)) / '
          'gamma^5: %s' % ('right' if agrees else 'wrong'))
    if not agrees:
        missed.append('the determinant')
    print('\n| where | rank of the five | with brackets of the third order |\n|---|---|---|')
    for words, point in specialPoints():
        ranks = gradients.subs(point).rank(), all_gradients.subs(point).rank()
        print('| %s | %d | %d |' % ((words,) + ranks))
        if ranks != EXPECTED_RANKS[words]:
            missed.append('the ranks at ' + words)
    for name in missed:
        print('missed: ' + name)
    return 1 if missed else 0


if __name__ == '__main__':
    sys.exit(main())
