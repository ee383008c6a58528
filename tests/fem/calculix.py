"""CalculiX on a deck, for tests that compare ballesta with it."""

import shutil
import subprocess

import pytest

needs_calculix = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed"
)


def run_calculix(deck):
    """Solve a deck where it stands; its .frd and .dat files."""
    done = subprocess.run(
        ["ccx", deck.stem], cwd=deck.parent, capture_output=True, text=True, timeout=120
    )
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    assert "WARNING" not in done.stdout, done.stdout[-2000:]
    return deck.with_suffix(".frd"), deck.with_suffix(".dat")
