"""Room of HXT's arrays, followed through what it tells, against what it has reserved in fact.

The sizes are those that an HXT built from gmsh's sources told of itself, of a plate with two holes
meshed finer and finer.
"""

import pytest

from geometry.memory import array_sizes, within_memory

RESERVED = 12_318
TOLD = [
    (12_318, [4324]),
    (24_815, [4324, 4568, 4665, 4669]),
    (24_815, [4324, 5884, 8113, 9310, 9593, 9689, 9698]),
    (106_653, [4324, 8193, 19931, 37400, 47832, 50955, 51676, 51809, 51833, 51838]),
    (427_338, [4324, 10991, 36596, 99970, 181471, 222915, 233964, 236852, 237733, 238028, 238233]),
]


@pytest.mark.parametrize(("size", "counts"), TOLD)
def test_the_size_of_the_array_is_one_of_those_that_are_possible(size, counts):
    assert any(low <= size <= high for low, high in array_sizes(RESERVED, counts))


def messages(reserved, counts):
    yield f"Info: Initialization reserved {reserved} Tet."
    for count in counts:
        yield f"Info: Refinement adds 1 points from {count} tetrahedra"


@pytest.mark.parametrize(("size", "counts"), TOLD)
def test_hxt_stays_within_its_memory_where_a_batch_of_free_tetrahedra_fits(size, counts):
    """8182 are a batch."""
    assert within_memory(list(messages(RESERVED, counts))) == (counts[-1] + 8182 <= size)


def test_one_of_several_volumes_is_enough_and_silence_is_no_proof():
    good, bad = list(messages(RESERVED, TOLD[1][1])), list(messages(RESERVED, TOLD[0][1]))
    assert within_memory(good + good)
    assert not within_memory(good + bad)
    assert not within_memory([])
