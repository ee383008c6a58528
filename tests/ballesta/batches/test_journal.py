import errno
import os

import pytest

from ballesta.batches.run import Journal, JournalEntry


def entry(name, **outcome):
    return JournalEntry(
        f"key of {name}", {"a.toml": "00"}, "", {"name": name, **outcome}, {"seconds": 1.5}
    )


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "journal.jsonl"
    with Journal(path) as journal:
        journal.add([entry("one", value=0.1 + 0.2, text="ü\ud800"), entry("two", value=None)])
        journal.add([entry("three")])
    return path


def read(path):
    with Journal(path) as journal:
        return journal.damaged, list(journal.entries.values())


def test_what_was_added_is_read_back_to_the_last_bit(path):
    assert read(path) == (
        0,
        [entry("one", value=0.1 + 0.2, text="ü\ud800"), entry("two", value=None), entry("three")],
    )


def test_a_line_cut_short_by_a_kill_is_cut_away_and_what_follows_is_whole(path):
    whole = path.read_bytes()
    path.write_bytes(whole[:-20])
    with Journal(path) as journal:
        assert [e.outcome["name"] for e in journal.entries.values()] == ["one", "two"]
        journal.add([entry("three")])
    assert path.read_bytes() == whole


def test_every_flipped_bit_costs_one_record_and_is_told(path):
    whole = path.read_bytes()
    starts = [0, *[i + 1 for i, byte in enumerate(whole[:-1]) if byte == ord("\n")]]
    for place in range(0, len(whole), 7):
        if whole[place] == ord("\n"):
            continue
        flipped = bytearray(whole)
        flipped[place] ^= 1
        path.write_bytes(flipped)
        damaged, entries = read(path)
        hit = sum(start <= place for start in starts) - 1
        assert damaged == 1
        assert len(entries) == 2
        assert ["one", "two", "three"][hit] not in [e.outcome["name"] for e in entries]


def test_a_full_disk_leaves_the_journal_as_it_was(path):
    whole = path.read_bytes()

    def full(file, data):
        if len(data) <= 50:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return os.write(file, data[:50])

    with Journal(path, full) as journal:
        with pytest.raises(OSError, match="No space left"):
            journal.add([entry("four")])
        assert len(journal.entries) == 3
    assert path.read_bytes() == whole
