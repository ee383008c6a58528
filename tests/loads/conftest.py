"""Gathers how far results are from the independent solutions, and prints the worst of each machine.

A check counts by its share of its own tolerance; relative deviations only where the expected value
is above that tolerance (the others are zero up to rounding).
"""

from collections import defaultdict

import pytest

_SHARE, _RELATIVE = "share of its tolerance", "relative"
_GATHERED = pytest.StashKey[dict[str, list[tuple[float, float | None, str]]]]()


def pytest_configure(config):
    config.stash[_GATHERED] = defaultdict(list)


@pytest.fixture
def meets(request):
    """A function: assert a value within a check's tolerance, and remember how far it was off."""
    gathered = request.config.stash[_GATHERED]

    def meets(machine, check, value):
        expected = check["value"]
        allowed = max(check["tol_abs"], check["tol_rel"] * abs(expected))
        off = abs(float(value) - expected)
        relative = off / abs(expected) if abs(expected) > 10.0 * allowed else None
        gathered[machine].append((off / allowed, relative, check["quantity"]))
        assert off <= allowed, (
            f"{machine}: {check['quantity']} {value:.9g}, expected {expected:.9g}"
        )

    return meets


def pytest_terminal_summary(terminalreporter, config):
    gathered = config.stash[_GATHERED]
    if not gathered:
        return
    terminalreporter.section("worst deviation from the independent solutions")
    for machine, deviations in gathered.items():
        share, _, where = max(deviations)
        known = [(relative, name) for _, relative, name in deviations if relative is not None]
        relative, name = max(known)
        terminalreporter.write_line(
            f"{machine:28s} {len(deviations):4d} checks   {share:8.1e} of its tolerance ({where})"
            f"   {relative:8.1e} relative ({name})"
        )
