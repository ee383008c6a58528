"""One thread in all linear algebra, two in a large factorisation, the environment kept."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

from fem import threads
from fem.threads import LARGE, ONE_THREAD, one_thread, policy, threads_for

ROOT = Path(__file__).parents[2]
POOLS = ("OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")


@pytest.fixture(autouse=True)
def nothing_stated(monkeypatch):
    """An environment in which nobody has said anything of threads."""
    for name in ONE_THREAD:
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def four_cores(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 3}, raising=False)


def sizes():
    """Threads of every pool of linear algebra that is loaded, numpy's among them."""
    assert np.__version__
    return {
        library.num_threads
        for library in ThreadpoolController().select(user_api="blas").lib_controllers
    }


def share(work):
    """Processor time of other threads over the main one's, in a process without our environment."""
    script = ROOT / "tests" / "threads_at_work.py"
    done = subprocess.run(
        [sys.executable, str(script), work],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


def test_libraries_loaded_before_take_one_thread():
    """Without the bound other threads take 0.7 of the main one's time and more."""
    assert share("bound") < 0.05


def test_a_factorisation_by_itself_runs_no_team():
    """CHOLMOD's team of four takes three times the main thread's time where it is not held."""
    assert share("factorise") < 0.05


def test_pools_have_their_sizes_again_afterwards(four_cores):
    before, environment = sizes(), dict(os.environ)
    with one_thread():
        assert sizes() == {1}
        with threads_for(LARGE):
            assert sizes() == {2}
        assert sizes() == {1}
        assert os.environ["OPENBLAS_NUM_THREADS"] == "1"  # for what is loaded meanwhile
    assert sizes() == before
    assert dict(os.environ) == environment


def test_small_factorisations_take_one_thread(four_cores):
    with threads_for(LARGE - 1):
        assert sizes() == {1}


def test_the_policy_is_said(four_cores, monkeypatch):
    assert policy() == f"1; 2 from {LARGE} unknowns"
    monkeypatch.setenv("BALLESTA_THREADS", "1")
    assert policy() == "1"


@pytest.mark.parametrize("name", POOLS)
def test_what_the_user_has_set_is_kept_and_said(name, four_cores, monkeypatch):
    monkeypatch.setenv(name, "3")
    before = sizes()
    with one_thread():
        assert policy() == f"as the environment says: {name}=3"
        assert sizes() == before
        with threads_for(LARGE):
            assert sizes() == before


def test_the_tools_own_word_stands_above_the_libraries(four_cores, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    monkeypatch.setenv("BALLESTA_THREADS", "2")
    with one_thread(), threads_for(LARGE):
        assert sizes() == {2}
        assert policy() == f"1; 2 from {LARGE} unknowns"


def test_one_core_is_one_thread(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {5}, raising=False)
    assert policy() == "1"


@pytest.mark.parametrize(
    ("limit", "said"), [("0", "1"), ("1", "1"), ("8", f"1; 2 from {LARGE} unknowns")]
)
def test_a_limit_of_openmp_bounds_large_factorisations_too(limit, said, four_cores, monkeypatch):
    monkeypatch.setenv("OMP_THREAD_LIMIT", limit)
    assert policy() == said


@pytest.mark.parametrize("wrong", ["0", "-1", "two", "1.5"])
def test_a_wrong_number_is_refused(wrong, monkeypatch):
    monkeypatch.setenv(threads.OWN, wrong)
    with pytest.raises(ValueError, match=f'BALLESTA_THREADS must be .* got "{wrong}"'):
        policy()


def test_pardiso_takes_two_threads_beside_a_library_with_openmp():
    """MKL crashed where parallel regions of GNU's OpenMP, which gmsh loads, were held to one."""
    pytest.importorskip("pypardiso")
    code = (
        "import gmsh, fem.threads, threads_at_work; fem.threads.LARGE = 0; "
        "from fem.solvers import factorize; factorize(threads_at_work.laplacian(20), 'PARDISO')"
    )
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    environment = os.environ | {"PYTHONPATH": paths, "BALLESTA_THREADS": "2"}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True, timeout=60)
