"""Linear algebra of every library that has threads, and how much of it other threads did.

python tests/threads_at_work.py WORK   one of the functions below; numpy and scipy are loaded
"""

import sys
from contextlib import suppress
from time import sleep

import numpy as np
import psutil
import scipy.linalg
import scipy.sparse as sp


def laplacian(n):
    """Upper triangle of the stiffness of a grid of n^3 points, held all over by a weak spring."""
    line = sp.diags_array([-np.ones(n - 1), 2.01 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    one = sp.eye_array(n)
    whole = (
        sp.kron(sp.kron(line, one), one)
        + sp.kron(sp.kron(one, line), one)
        + sp.kron(sp.kron(one, one), line)
    )
    return sp.csr_array(sp.triu(whole))


def share_of_other_threads(work):
    """Processor time of all threads but this one, over this one's, while some work is done."""
    process = psutil.Process()

    def times():
        found = {t.id: t.user_time + t.system_time for t in process.threads()}
        own = found.pop(process.pid)
        return own, sum(found.values())

    own, others = times()
    work()
    now, others_now = times()
    return (others_now - others) / (now - own)


def multiply():
    """Products as fatigue takes them, by numpy's and by scipy's own library."""
    matrix = np.random.default_rng(0).normal(size=(1200, 1200))
    for _ in range(3):
        matrix @ matrix
    scipy.linalg.cho_factor(matrix @ matrix.T + 1e3 * np.eye(len(matrix)))


def factorise(n=26):
    """A factorisation whose fronts are large enough for teams and pools; returns the factor."""
    from fem.solvers import factorize

    return factorize(laplacian(n))


def bound():
    """Everything within the promise of one thread."""
    from fem.threads import one_thread

    with one_thread():
        multiply()
        factorise().solve(np.ones((26**3, 20)))


if __name__ == "__main__":
    with suppress(ImportError):
        import sksparse.cholmod  # noqa: F401
    sleep(0.5)  # a pool spins for a tenth of a second when it is loaded
    work = {"multiply": multiply, "factorise": factorise, "bound": bound}[sys.argv[1]]
    print(share_of_other_threads(work))
