"""Memory: what a solve is said to need, what there is, and the refusal between the two."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fem.solvers import chosen_fill
from fem.unit_solutions import solve_unit_loads
from geometry import memory
from geometry.memory import (
    TooLargeError,
    available_bytes,
    check_memory,
    compactness_of,
    solve_bytes,
)
from geometry.mesh import TooManyElementsError
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink

from ..fem.blocks import block
from ..validation.solids.problems import STEEL

GIBIBYTE = 2.0**30


@pytest.fixture
def system(tmp_path, monkeypatch):
    """A machine with 8 GiB to spare and a process in the control group /a/b, without limits."""
    (tmp_path / "meminfo").write_text(
        f"MemTotal: 99999999 kB\nMemFree: 1 kB\nMemAvailable:   {8 * 1024**2} kB\n"
    )
    (tmp_path / "own").write_text("0::/a/b\n")
    (tmp_path / "groups").mkdir()
    for name, path in (("_MEMINFO", "meminfo"), ("_OWN_GROUP", "own"), ("_CGROUPS", "groups")):
        monkeypatch.setattr(memory, name, tmp_path / path)
    return tmp_path / "groups"


def group(folder, limit, used, cache):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "memory.max").write_text(f"{limit}\n")
    (folder / "memory.current").write_text(f"{used}\n")
    (folder / "memory.stat").write_text(f"anon 7\ninactive_file {cache}\nactive_file 5\n")


def test_without_limits_the_machine_says_what_there_is(system):
    assert available_bytes() == 8 * GIBIBYTE
    group(system / "a/b", "max", 10**9, 0)
    assert available_bytes() == 8 * GIBIBYTE


def test_the_tightest_group_above_a_process_counts_and_its_idle_cache_is_free(system):
    group(system / "a/b", 6 * 2**30, 2**30, 0)
    group(system / "a", 5 * 2**30, 3 * 2**30, 2**29)
    assert available_bytes() == 2.5 * GIBIBYTE
    group(system, 2**30, 3 * 2**30, 0)
    assert available_bytes() == 0.0


def test_a_group_of_the_first_kind_counts_too(system):
    (system / "memory").mkdir()
    for name, text in (
        ("memory.limit_in_bytes", 4 * 2**30),
        ("memory.usage_in_bytes", 2 * 2**30),
        ("memory.stat", f"cache 9\ntotal_inactive_file {2**30}"),
    ):
        (system / "memory" / name).write_text(str(text))
    assert available_bytes() == 3 * GIBIBYTE


def test_elsewhere_than_on_linux_psutil_tells(tmp_path, monkeypatch):
    for name in ("_MEMINFO", "_OWN_GROUP", "_CGROUPS"):
        monkeypatch.setattr(memory, name, tmp_path / "none")
    monkeypatch.setattr("psutil.virtual_memory", lambda: SimpleNamespace(available=3 * 2**30))
    assert available_bytes() == 3 * GIBIBYTE
    with pytest.raises(TooLargeError):
        check_memory(10**12, 10)


@pytest.mark.skipif(not Path("/proc/meminfo").exists(), reason="needs Linux")
def test_this_machine_tells_a_number():
    assert 2**20 < available_bytes() < 2**50


def test_ten_times_the_unknowns_fill_up_twenty_one_times():
    """n^(4/3) once assembly and loads are taken off."""
    linear = 2000 + 64 * 20
    fill = [solve_bytes(n, 20) - linear * n for n in (10**4, 10**5)]
    assert fill[1] / fill[0] == pytest.approx(10 ** (4 / 3), rel=1e-9)


def test_a_plate_needs_less_than_a_cube_of_as_many_unknowns():
    box = np.array([[0, 0, 0], [100, 100, 1.0]])
    assert compactness_of(box, 10**4) == pytest.approx(0.2154, abs=1e-4)
    assert compactness_of(box / 10, 10) == pytest.approx(0.2154, abs=1e-4)
    assert solve_bytes(10**5, 20, 0.2154) < 0.6 * solve_bytes(10**5, 20, 1.0)


def test_the_refusal_tells_what_is_needed_and_what_there_is(system):
    """1e6 (2000 + 216 * 100 + 64 * 20) bytes are 23.2 GiB."""
    said = (
        r"solving about 1e\+06 unknowns with 20 loads would need 23\.2 GiB of memory and 8 GiB are "
        r"free; lower mesh\.fineness or mesh\.most_unknowns"
    )
    with pytest.raises(TooLargeError, match=said):
        check_memory(1_000_000, 20)
    check_memory(300_000, 20)
    assert issubclass(TooLargeError, TooManyElementsError)


def test_a_solve_asks_before_it_assembles(monkeypatch):
    mesh = block((2, 2, 2), (10.0, 10.0, 10.0))
    asked = []

    def refuse(unknowns, columns, compactness, *, fill):
        asked.append((unknowns, columns, compactness, fill))
        raise TooLargeError("too large")

    monkeypatch.setattr("fem.unit_solutions.check_memory", refuse)
    monkeypatch.setattr("fem.unit_solutions.stiffness", None)  # would be a TypeError
    with pytest.raises(TooLargeError):
        solve_unit_loads(mesh, STEEL)
    assert asked == [(3 * 125, 10, pytest.approx(1.0), 1.0)]


def test_superlu_asks_for_seven_times_the_factor(monkeypatch):
    """216 n^(4/3) bytes for a cube by CHOLMOD; measured 5.4 to 7.1 times that."""
    for package in ("sksparse", "pypardiso"):
        monkeypatch.setitem(sys.modules, package, None)
    assert chosen_fill() == 7.0
    more = solve_bytes(10**6, 20, fill=7.0) - solve_bytes(10**6, 20)
    assert more == pytest.approx(6 * 216e8, rel=1e-12)


def test_a_body_too_large_for_the_memory_is_refused_before_it_is_meshed(system, monkeypatch):
    (system.parent / "meminfo").write_text("MemAvailable: 1024 kB\n")
    monkeypatch.setattr("geometry.meshing._generate", None)
    link = PlateLink(length=60, width=24, thickness=8, hole=10)
    with pytest.raises(TooLargeError, match=r"and 0\.000977 GiB are free"):
        mesh_shape(link, fineness=0.6)
