"""Results as trees and pieces, and back."""

import io
import json
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np
import pytest

from checks.result.verdict import Gate, Status
from checks.store.fingerprints import digest
from checks.store.store import RecordError, from_record, packed, to_record, unpacked
from geometry.mesh import Interface, MassProperties

RNG = np.random.default_rng(1)


def there_and_back(thing):
    """What a file would give back."""
    tree, pieces = to_record(thing)
    tree = json.loads(json.dumps(tree, allow_nan=False))
    stream = io.BytesIO()
    forms = []
    for piece in pieces:
        form, content = packed(piece)
        forms.append(json.loads(json.dumps(form)))
        stream.write(content)
    stream.seek(0)
    return from_record(tree, [unpacked(stream, form) for form in forms])


@pytest.mark.parametrize(
    "thing",
    [
        None,
        True,
        -7,
        0.1 + 0.2,
        -0.0,
        inf,
        "Ünïcode \ud800",
        b"\x00\xff" * 5000,
        (1, (2.5, None), ["x"]),
        {"a": 1, "$": 2},
        {(1, "b"): {2: 3.0}},
        frozenset({1, 2}),
        Path("some/where"),
        Status.UNDECIDED,
        Gate("balance", 1e-9, 1e-6, "meaning", binding=False),
        Interface("bore", "bore", np.zeros(3), radius=4.0),
        MassProperties(1.0, np.ones(3), np.float64(2.0)),
    ],
    ids=repr,
)
def test_what_is_kept_comes_back_equal_and_of_the_same_type(thing):
    back = there_and_back(thing)
    assert type(back) is type(thing)
    try:
        assert digest(back) == digest(thing)
    except TypeError:  # bytes
        assert back == thing


@pytest.mark.parametrize(
    "array",
    [
        RNG.standard_normal((40, 30)),
        RNG.standard_normal((40, 30)).T,
        RNG.standard_normal((5, 6, 7)).transpose(1, 2, 0),
        RNG.standard_normal((40, 30))[::2, 1::3],
        np.zeros((1000, 4)),
        np.arange(5000),
        np.zeros((0, 3)),
        np.array(3.5),
        np.array([True, False]),
        np.array(["a", "bcd"]),
        np.array([1 + 2j]),
    ],
    ids=lambda array: f"{array.dtype} {array.shape} {array.strides}",
)
def test_arrays_come_back_bit_for_bit_and_in_their_order_in_memory(array):
    back = there_and_back(array)
    assert back.dtype == array.dtype
    assert back.shape == array.shape
    assert back.tobytes() == array.tobytes()
    assert back.flags.writeable
    if array.flags.forc:
        assert back.flags.c_contiguous == array.flags.c_contiguous


def test_a_number_of_numpy_stays_one():
    back = there_and_back({"n": np.int64(3), "x": np.float64(0.1)})
    assert type(back["n"]) is np.int64
    assert type(back["x"]) is np.float64


def test_an_array_that_stands_in_two_places_is_kept_once():
    array = np.ones(5)
    _, pieces = to_record([array, array])
    assert len(pieces) == 1


@dataclass
class Foreign:
    """None of the tool's own."""

    value: int = 1


@pytest.mark.parametrize("thing", [object(), lambda: 1, {1, 2}, np.array([None]), Foreign()])
def test_what_is_no_plain_data_of_ours_is_refused(thing):
    with pytest.raises(RecordError, match="cannot be kept"):
        to_record(thing)


@pytest.mark.parametrize("name", ["os:system", "builtins:dict", "reports.files:Path"])
def test_a_record_makes_nothing_but_dataclasses_of_ours(name):
    with pytest.raises(RecordError):
        from_record({"$": ["data", name, []]}, [])


def test_a_record_with_other_fields_is_refused():
    tree = {"$": ["data", "checks.result.verdict:Gate", [["name", "balance"]]]}
    with pytest.raises(RecordError, match="other fields"):
        from_record(tree, [])
