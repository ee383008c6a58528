"""Derivations of the checks' numbers, one for every kind of check.

One file per kind; `checks.ladder.explained` gives each check of a part its own. A derivation
says what a check has computed in the formulas of docs/theory, and is evaluated from them: what it
misses of the check's own number is a bug (tests/checks/derivations).
"""
