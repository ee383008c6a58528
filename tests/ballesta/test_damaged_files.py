"""Damaged CSV and STEP files: exit codes of the contract, no traceback, no NaN, no warning.

The damage is drawn by hypothesis, always the same; what it finds it makes as small as it can.
"""

import json
import warnings
from collections import Counter

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from ballesta.design.read import read_design
from ballesta.pipeline import check_file
from checks.design.errors import DesignError, NumericsError
from checks.ladder.part_ladder import Effort
from reports.files import plain

from ..geometry.step_files import LINK, write_step
from . import test_measured_loads as csv
from .design import test_step_parts as step

pytestmark = pytest.mark.slow
NASTY = (b"nan", b"inf", b"-1e308", b"1e400", b"0", b"-", b"", b",,", b";", b"\n", b"\x00", b"\xff",
         b"'", b'"', b"$", b"#1", b"#999999", b"*", b"()", b"9" * 400, b"1,5",
         b"\xef\xbb\xbf")  # fmt: skip
EDIT = st.tuples(
    st.sampled_from(["flip", "cut", "drop", "twice", "swap", "put", "put number"]),
    st.floats(0.0, 1.0, exclude_max=True),
    st.floats(0.0, 1.0, exclude_max=True),
    st.integers(0, 7),
    st.sampled_from(NASTY),
)
FORMULA = Effort("formula")


def damaged(data, edits):
    """The bytes after some edits, each at shares of their length."""
    for kind, first, second, bit, nasty in edits:
        if not data:
            break
        at, other = sorted((int(first * len(data)), int(second * len(data))))
        lines = data.split(b"\n")
        one, two = int(first * len(lines)), int(second * len(lines))
        if kind == "flip":
            data = data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :]
        elif kind == "cut":
            data = data[:other]
        elif kind == "drop":
            data = data[:at] + data[min(other, at + 200) :]
        elif kind == "twice":
            data = b"\n".join([*lines[:one], lines[two], *lines[one:]])
        elif kind == "swap":
            lines[one], lines[two] = lines[two], lines[one]
            data = b"\n".join(lines)
        elif kind == "put":
            data = data[:at] + nasty + data[at:]
        else:  # instead of what stands between two commas
            words = data.split(b",")
            words[int(first * len(words))] = nasty
            data = b",".join(words)
    return data


def ended(file):
    """The exit code of a check by formula, whose result is written as JSON has it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            result = check_file(file, effort=FORMULA)
        except DesignError as error:
            return 2 if len(str(error)) < 100_000 else -1
        except NumericsError:
            return 3
        json.dumps(plain(result.to_dict()), allow_nan=False)
        return result.exit_code


def drawn(examples):
    """Decorator: a list of edits, the same ones each time."""
    return lambda test: settings(
        max_examples=examples, derandomize=True, deadline=None, database=None,
        phases=(Phase.generate, Phase.shrink), suppress_health_check=list(HealthCheck),
    )(given(edits=st.lists(EDIT, min_size=1, max_size=3))(test))  # fmt: skip


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """A machine whose rod's loads stand in a CSV file, and that file's bytes."""
    folder = tmp_path_factory.mktemp("measured")
    solved = read_design(csv.written(folder, csv.MACHINE + csv.SOLVED))
    columns = csv.columns_of(csv.solve_cycles(solved, {})["turn"])
    few = {name: values[::15] for name, values in columns.items()}
    file = csv.written(folder, csv.MACHINE + csv.MEASURED + csv.TUBE.replace("CYCLE", "run"))
    return file, csv.csv_text(few).encode()


@pytest.fixture(scope="module")
def drawing(tmp_path_factory):
    """A machine whose crank stands in a STEP file, and that file's bytes."""
    folder = tmp_path_factory.mktemp("drawing")
    file = folder / "machine.toml"
    file.write_text(step.MACHINE + step.CRANK)
    return file, write_step(folder / "link.step", LINK.build).read_bytes()


codes: dict[str, Counter[int]] = {"motion.csv": Counter(), "link.step": Counter()}


def checked(file, name, data):
    (file.parent / name).write_bytes(data)
    code = ended(file)
    assert code in (0, 1, 2, 3)
    codes[name][code] += 1


@drawn(300)
def test_damaged_columns_end_as_the_contract_says(measured, edits):
    file, data = measured
    checked(file, "motion.csv", damaged(data, edits))


@drawn(20)
def test_damaged_drawings_end_as_the_contract_says(drawing, edits):
    file, data = drawing
    checked(file, "link.step", damaged(data, edits))


@pytest.mark.parametrize(
    ("name", "fixture"), [("motion.csv", "measured"), ("link.step", "drawing")]
)
def test_the_whole_files_are_checked(name, fixture, request):
    """So that it is the damage that is refused, and some of it is not."""
    file, data = request.getfixturevalue(fixture)
    (file.parent / name).write_bytes(data)
    assert ended(file) in (0, 1)
    assert not codes[name] or {2} < set(codes[name])
