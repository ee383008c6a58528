"""A store's files: whole or not at all, damage found out, trouble told once."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from checks.store import store as store_module
from checks.store.store import Key, Store

ROOT = Path(__file__).parents[3]
VALUE = {"stress": np.linspace(0.0, 1.0, 300), "name": "bar"}
KEY = Key.of("mesh", ("geometry",), ("shape", 1.0))


class Said(list):
    """What a store has said."""

    def __call__(self, text):
        self.append(text)


@pytest.fixture
def said():
    return Said()


@pytest.fixture
def store(tmp_path, said):
    return Store(tmp_path / "store", say=said)


def the_file(store):
    [file] = store.folder.glob("*/*/*")
    return file


def assert_is_value(found):
    assert found is not None
    assert found[0]["name"] == "bar"
    assert found[0]["stress"].tobytes() == VALUE["stress"].tobytes()


def test_an_entry_is_found_by_equal_inputs_only(store, said):
    store.put(KEY, VALUE)
    assert_is_value(store.get(KEY))
    assert store.get(Key.of("mesh", ("geometry",), ("shape", 1.5))) is None
    assert store.get(Key.of("body", ("geometry",), ("shape", 1.0))) is None
    assert said == []


def test_nothing_is_a_result_too(store):
    calls = []
    for _ in range(2):
        assert store.remember("buckling", ("fem",), 1, lambda: calls.append(1)) is None
    assert calls == [1]


def test_a_flipped_byte_anywhere_is_found_out_said_and_computed_again(store, said):
    store.put(KEY, VALUE)
    file = the_file(store)
    whole = file.read_bytes()
    places = {*range(0, 70), *range(70, len(whole), 97), len(whole) - 1}
    for place in sorted(places):
        changed = bytearray(whole)
        changed[place] ^= 0x10
        file.write_bytes(changed)
        said.clear()
        again = Store(store.folder, say=said)
        found = again.remember("mesh", ("geometry",), ("shape", 1.0), lambda: VALUE)
        assert_is_value((found,))
        [text] = said
        assert "is damaged" in text
        assert "computed again" in text
        assert file.read_bytes() == whole


@pytest.mark.parametrize("length", [0, 5, 30, 60, 400, -1])
def test_a_truncated_file_is_found_out(store, said, length):
    store.put(KEY, VALUE)
    file = the_file(store)
    file.write_bytes(file.read_bytes()[:length])
    assert store.get(KEY) is None
    assert "is damaged" in said[0]


def test_an_entry_under_another_s_name_is_found_out(store, said):
    store.put(KEY, VALUE)
    other = Key.of("mesh", ("geometry",), ("shape", 2.0))
    target = store.folder / other.path
    target.parent.mkdir(parents=True)
    os.replace(the_file(store), target)
    assert store.get(other) is None
    assert "entry of something else" in said[0]


def test_entries_of_another_version_are_ignored_and_said_once(store, said):
    for inputs in "abc":
        own = Key.of("mesh", ("geometry",), inputs)
        store.put(Key("mesh", own.inputs, "0" * 64), "of another version")
        assert store.get(own) is None
    [text] = said
    assert "other versions of ballesta" in text


def test_a_file_of_another_format_is_ignored_and_replaced(store, said):
    store.put(KEY, VALUE)
    the_file(store).write_bytes(b"ballesta-store 2\n" + bytes(100))
    assert store.get(KEY) is None
    assert "not of this format" in said[0]
    store.put(KEY, VALUE)
    assert_is_value(store.get(KEY))


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_costs_a_word_only_by_its_mode(tmp_path, said):
    tmp_path.chmod(0o500)
    store = Store(tmp_path / "store", say=said)
    assert store.remember("mesh", ("geometry",), 1, lambda: 5) == 5
    assert "cannot be written" in said[0]
    tmp_path.chmod(0o700)


def test_a_folder_that_cannot_be_written_costs_a_word_only(tmp_path, said):
    (tmp_path / "store").write_text("a file stands where the folder should")
    store = Store(tmp_path / "store", say=said)
    for k in range(3):
        assert store.remember("mesh", ("geometry",), k, lambda k=k: 5 * k) == 5 * k
    assert sum("cannot be written" in text for text in said) == 1


def test_a_full_disk_costs_a_word_only_and_leaves_nothing_half(store, said, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(store_module.os, "fsync", full)
    for k in range(2):
        assert store.remember("mesh", ("geometry",), k, lambda: VALUE) is VALUE
    [text] = said
    assert "No space left" in text
    assert [file for file in store.folder.rglob("*") if file.is_file()] == []


def test_what_cannot_be_kept_is_said_and_given_all_the_same(store, said):
    assert store.remember("mesh", ("geometry",), 1, lambda: {1, 2}) == {1, 2}
    assert "cannot be kept" in said[0]


def test_the_entries_used_longest_ago_are_removed_beyond_the_limit(tmp_path, said):
    store = Store(tmp_path, limit=10_000, say=said)
    noise = np.random.default_rng(2)
    keys = [Key.of("mesh", ("geometry",), k) for k in range(6)]
    for age, key in enumerate(keys[:4]):
        store.put(key, noise.standard_normal(240))
        os.utime(tmp_path / key.path, (1000.0 + age,) * 2)
    assert store.get(keys[0]) is not None  # used just now
    store.put(keys[4], noise.standard_normal(240))
    there = [(tmp_path / key.path).exists() for key in keys[:5]]
    assert there == [True, False, True, True, True]
    assert said == []


def test_whole_results_are_removed_last(tmp_path):
    store = Store(tmp_path, limit=10_000)
    noise = np.random.default_rng(2)
    keys = [Key.of(kind, ("geometry",), 1) for kind in ("result", "mesh", "body")]
    for age, key in enumerate(keys):
        store.put(key, noise.standard_normal(480))
        if (tmp_path / key.path).exists():
            os.utime(tmp_path / key.path, (1000.0 + age,) * 2)
    assert [(tmp_path / key.path).exists() for key in keys] == [True, False, True]


def test_temporary_files_of_the_dead_are_removed_with_the_oldest(tmp_path):
    store = Store(tmp_path, limit=100)
    (tmp_path / "mesh" / "aa").mkdir(parents=True)
    dead, young = (tmp_path / "mesh" / "aa" / name for name in (".1.tmp", ".2.tmp"))
    dead.write_bytes(b"x")
    young.write_bytes(b"x")
    os.utime(dead, (1000.0, 1000.0))
    store.put(KEY, VALUE)
    assert not dead.exists()
    assert young.exists()


WRITER = """
import sys
import numpy as np
from pathlib import Path
from checks.store.store import Key, Store

store = Store(Path(sys.argv[1]))
key = Key.of("mesh", ("geometry",), "the same")
print("ready", flush=True)
for k in range(int(sys.argv[2])):
    store.put(key, np.full(int(sys.argv[3]), 7.0))
    found = store.get(key)
    assert found is None or (found[0] == 7.0).all()
"""


def writer(folder, times, size):
    return subprocess.Popen(
        [sys.executable, "-c", WRITER, str(folder), str(times), str(size)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )


def test_two_processes_may_write_the_same_entry(tmp_path):
    both = [writer(tmp_path, 40, 20_000) for _ in range(2)]
    for each in both:
        _, errors = each.communicate(timeout=60)
        assert (each.returncode, errors) == (0, "")
    found = Store(tmp_path).get(Key.of("mesh", ("geometry",), "the same"))
    assert found is not None
    assert (found[0] == np.full(20_000, 7.0)).all()


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
@pytest.mark.parametrize("wait", [0.0, 0.02, 0.05])
def test_a_kill_while_writing_leaves_no_half_entry(tmp_path, said, wait):
    process = writer(tmp_path, 1000, 1_000_000)
    assert process.stdout.readline() == "ready\n"
    time.sleep(wait)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGKILL
    found = Store(tmp_path, say=said).get(Key.of("mesh", ("geometry",), "the same"))
    assert found is None or (found[0] == 7.0).all()
    assert said == []


STUCK = """
import sys, time
from pathlib import Path
import checks.store.store as module

def stuck(_):
    print("writing", flush=True)
    time.sleep(600)

module.os.fsync = stuck
module.Store(Path(sys.argv[1])).put(module.Key.of("mesh", ("geometry",), "the same"), [1, 2])
"""


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_an_entry_has_its_name_only_when_it_is_whole(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", STUCK, str(tmp_path)],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert process.stdout.readline() == "writing\n"
    names = [file.suffix for file in tmp_path.glob("*/*/*")]
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    assert names == [".tmp"]
    store, key = Store(tmp_path), Key.of("mesh", ("geometry",), "the same")
    assert store.get(key) is None
    store.put(key, [1, 2])
    assert store.get(key) == ([1, 2],)
