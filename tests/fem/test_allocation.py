"""Memory that a process keeps for its next arrays."""

import subprocess
import sys

import pytest

FAULTS = """
import resource
import numpy as np
from fem.threads import keep_freed_memory
if {kept}:
    assert keep_freed_memory()
np.ones(4_500_000)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(5):
    np.ones(4_500_000)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="mallopt is glibc's")
def test_freed_memory_is_not_mapped_anew():
    faults = [
        int(
            subprocess.run(
                [sys.executable, "-c", FAULTS.format(kept=kept)],
                capture_output=True,
                text=True,
                check=True,
            ).stdout
        )
        for kept in (False, True)
    ]
    assert faults[1] < 0.2 * faults[0]
