"""Derivations of checks by models of many points: stress, fatigue, elastic buckling.

Each says in the formulas of docs/theory how the number at the deciding point and position comes
about, and is evaluated from them: what it misses of the check's own number is a bug
(tests/checks/derivations). Checks by formula need none (`checks.by_formula`).
"""
