"""The loads of a cycle from the store."""

import loads
from checks.store.store import Store

_PACKAGES = ("loads",)


def stored_loads(
    store: Store | None, linkage: loads.Linkage, cycle: loads.Cycle
) -> loads.CycleLoads:
    """Return the loads of a cycle; raises CycleError and LinkageError."""

    def run() -> loads.CycleLoads:
        return loads.run_cycle(linkage, cycle)

    return run() if store is None else store.remember("loads", _PACKAGES, (linkage, cycle), run)
