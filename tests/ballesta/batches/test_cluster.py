"""Batches on a real cluster of dask: a scheduler and two workers on this machine."""

import json
import os
import pickle
import re
import shutil
import subprocess
import sys
from contextlib import nullcontext
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from shutil import which

import pytest

from ballesta.batches import cluster as cluster_module
from ballesta.batches.cluster import scheduler_of
from ballesta.batches.cluster_worker import (
    Reply,
    Site,
    Unread,
    from_text,
    nothing_unpickled,
    refusal,
    to_text,
    versions,
)
from ballesta.batches.plan import Request, planned
from ballesta.batches.pool import Finished, PoolError
from ballesta.batches.run import Settings, run_batch
from ballesta.commands.batch_command import Wanted, run_batch_command
from checks.design.errors import DesignError, NumericsError

from ...small_machine import MACHINE, PLATE
from . import jobs
from .dask_machines import DaskMachines, begun, ends, kill

SLOWLY, FATE = "cluster_job_functions:slowly", "cluster_job_functions:fate"
TABLES = ("results.csv", "results.parquet")
installed = pytest.mark.skipif(find_spec("distributed") is None, reason="needs the extra cluster")


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    found = DaskMachines(tmp_path_factory.mktemp("machines"))
    found.add_worker()
    found.add_worker()
    yield found
    found.kill()


@pytest.fixture
def imported(machines, monkeypatch):
    """Lets local workers import what those of the cluster do."""
    monkeypatch.setenv("PYTHONPATH", str(machines.folder), prepend=":")


def sweep(tmp_path, name):
    """Five variations of a crank and slider by formulas, and the folder of a batch."""
    file, out = tmp_path / "machine.toml", tmp_path / name
    file.write_text(MACHINE + PLATE)
    out.mkdir(exist_ok=True)
    request = Request((str(file),), (), ("parts.rod.thickness = 6..8 mm : 5",), fidelity="formula")
    return planned(request, out, reports=False), out


def fates(tmp_path, machines, texts, seconds=None, told=None, function=FATE):
    """Outcomes of jobs whose files hold the texts."""
    out = tmp_path / "out"
    settings = Settings(seconds=seconds, scheduler=machines.address)
    plan = jobs.plan_of(tmp_path, texts, out)
    return run_batch(plan, out, settings, told or jobs.Silent(), function=function)


def results(out):
    """All that a batch has written of its designs, without times."""
    found = {name: (out / name).read_bytes() for name in TABLES}
    for file in sorted(out.glob("*/result.json")):
        result = json.loads(file.read_text())
        del result["timings"], result["ways_out"]  # these tell what a solid takes
        for part in result["parts"]:
            for rung in part["rungs"]:
                del rung["seconds"]
        found[file.parent.name] = json.dumps(result)
    return found


class Killing(jobs.Silent):
    """Kills a dask worker in the middle of its second job."""

    def __init__(self, out, pid):
        super().__init__()
        self.out, self.pid, self.killed_in = out, pid, ""

    def running(self, steps):
        super().running(steps)
        mine = [name for name, worker, _ in begun(self.out) if worker == self.pid]
        if not self.killed_in and len(mine) == 2:
            kill(self.pid)
            self.killed_in = mine[-1]


@pytest.mark.slow
@installed
def test_a_cluster_that_loses_a_worker_in_mid_run_finds_what_a_local_run_finds(
    tmp_path, machines, imported
):
    plan, out = sweep(tmp_path, "local")
    run_batch(plan, out, Settings(2), jobs.Silent(), function=SLOWLY)
    local = results(out)
    plan, out = sweep(tmp_path, "cluster")
    (out / ".cluster-of-a-killed-batch").touch()
    told = Killing(out, machines.workers[-1].pid)
    run_batch(plan, out, Settings(scheduler=machines.address), told, function=SLOWLY)
    machines.add_worker()  # for the next test
    assert told.count == 2
    workers = {worker for name, worker, _ in begun(out) if name == told.killed_in}
    assert len(workers) == 2
    assert told.pid in workers
    assert len(local) == 2 + 5
    assert results(out) == local
    assert not list(out.glob(".cluster-*"))
    assert all(ends(own, within=5) for _, _, own in begun(out))  # nothing is left on the workers
    again = jobs.Silent()
    nowhere = Settings(scheduler="tcp://127.0.0.1:1")
    run_batch(plan, out, nowhere, again, function=SLOWLY)  # what is done needs no cluster
    assert again.done_before == 5


@installed
@pytest.mark.slow
def test_a_crash_and_a_hang_on_a_cluster_cost_themselves_alone(tmp_path, machines):
    texts = {"a": "one", "b": "die", "c": "hang", "d": "four"}
    found = fates(tmp_path, machines, texts, seconds=1.0)
    statuses = [outcome["status"] for outcome in found]
    assert statuses == ["wrong input", "crashed", "out of time", "wrong input"]
    assert "SIGKILL, 2 times" in found[1]["error"]


@installed
@pytest.mark.slow
def test_a_batch_waits_for_workers_and_a_job_that_takes_one_along_costs_itself_alone(
    tmp_path, tmp_path_factory, monkeypatch
):
    monkeypatch.setattr(cluster_module, "_COUNT_EVERY", 0.1)
    machines = DaskMachines(tmp_path_factory.mktemp("machines"), allowed_failures=0)

    class Helping(jobs.Silent):
        def say(self, text):
            super().say(text)
            machines.add_worker()

    told = Helping()
    try:
        texts = {"a": "die with the worker", "b": "two"}
        found = fates(tmp_path, machines, texts, told=told)
    finally:
        machines.kill()
    assert told.count == 0
    assert "no dask worker is at dask://127.0.0.1:" in told.texts[0]
    assert [outcome["status"] for outcome in found] == ["crashed", "wrong input"]
    assert "every dask worker that had it died" in found[0]["error"]
    assert [name for name, *_ in begun(tmp_path / "out")].count("a") == 2


@installed
def test_an_interrupt_ends_what_is_being_run_on_the_workers(tmp_path, machines):
    class Impatient(jobs.Silent):
        def finished(self, outcome, timings):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fates(tmp_path, machines, {"a": "one wait 1", "b": "hang"}, told=Impatient())
    assert {name for name, *_ in begun(tmp_path / "out")} == {"a", "b"}
    assert all(ends(own, within=5) for _, _, own in begun(tmp_path / "out"))


@installed
@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("code_digest", "other", "has another version of ballesta's code"),
        ("libraries", {"numpy": "1.0"}, "has another version of numpy"),
    ],
)
def test_numbers_of_another_version_do_not_slip_in(
    tmp_path, machines, monkeypatch, name, value, words
):
    monkeypatch.setattr(f"checks.store.fingerprints.{name}", lambda: value)
    with pytest.raises(DesignError, match=words):
        fates(tmp_path, machines, {"a": "one"})
    assert not begun(tmp_path / "out")


@installed
def test_a_design_that_reads_otherwise_on_a_worker_is_refused(tmp_path, machines):
    """As it is where each machine has a disk of its own; here it is edited while it is checked."""
    with pytest.raises(DesignError, match=r"a\.txt differs between worker tcp://127\.0\.0\.1:"):
        fates(tmp_path, machines, {"a": "edit"})


@installed
def test_a_cluster_elsewhere_is_refused(tmp_path, machines, monkeypatch):
    monkeypatch.setattr(os, "getcwd", lambda: "/of/another/machine")
    with pytest.raises(DesignError, match="does not see the folder /of/another/machine"):
        fates(tmp_path, machines, {"a": "one"})


@installed
def test_a_cluster_without_ballesta_is_refused(tmp_path, machines, monkeypatch):
    """As a module that is missing there is told."""
    (tmp_path / "installed_here.py").write_text("def run_there(*_, site): pass")
    monkeypatch.syspath_prepend(tmp_path)
    module = import_module("installed_here")
    monkeypatch.setattr(cluster_module, "run_there", module.run_there)
    with pytest.raises(DesignError, match=r"does not run.*scheduler and workers need ballesta"):
        fates(tmp_path, machines, {"a": "one"})


@installed
def test_processes_that_do_not_start_on_a_worker_end_the_batch_with_the_reason(tmp_path, machines):
    with pytest.raises(NumericsError, match="no_such_module"):
        fates(tmp_path, machines, {"a": "one"}, function="no_such_module:run")


def test_a_worker_that_sees_another_folder_of_the_same_name_refuses(tmp_path):
    mark = tmp_path / "mark"
    site = Site("the key", str(mark), str(tmp_path), versions(), FATE, None, None)
    assert "does not see the batch's folder" in refusal(site)
    mark.write_text("another key")
    assert "does not see the batch's folder" in refusal(site)
    mark.write_text("the key")
    assert refusal(site) == ""


@installed
def test_a_lost_scheduler_stops_the_batch_which_is_then_finished_on_this_machine(
    tmp_path, tmp_path_factory, imported
):
    others = DaskMachines(tmp_path_factory.mktemp("others"))

    class Killing(jobs.Silent):
        def finished(self, outcome, timings):
            super().finished(outcome, timings)
            others.scheduler.kill()

    texts = {"a": "one", "b": "two wait 2", "c": "three"}
    try:
        others.add_worker()
        with pytest.raises(DesignError, match=r"was lost; what is finished is kept, the same com"):
            fates(tmp_path, others, texts, told=Killing())
        assert all(ends(own, within=5) for _, _, own in begun(tmp_path / "out"))
    finally:
        others.kill()
    told = jobs.Silent()
    plan = jobs.plan_of(tmp_path, texts, tmp_path / "out")
    found = run_batch(plan, tmp_path / "out", Settings(1), told, function=FATE)
    assert told.done_before >= 1
    assert [outcome["error"] for outcome in found] == list(texts.values())


def command(tmp_path, capsys, **options):
    """Exit code and errors of a batch of one design."""
    (tmp_path / "machine.toml").write_text(MACHINE + PLATE)
    out = Path(os.path.relpath(tmp_path / "out"))
    wanted = Wanted(out, fidelity="formula", reports=False, **options)
    file = Path(os.path.relpath(tmp_path / "machine.toml"))
    return run_batch_command([file], wanted), capsys.readouterr().err


@installed
def test_the_command_runs_a_design_on_a_cluster(tmp_path, machines, capsys):
    """By paths that start where it was called, which is elsewhere than where the workers were."""
    code, told = command(tmp_path, capsys, executor=machines.address.replace("tcp", "dask"))
    assert code == 1, told
    assert "1 designs to check, 2 at a time" in told
    assert (tmp_path / "out" / "machine" / "result.json").is_file()
    assert (tmp_path / "out" / "index.html").is_file()


@installed
def test_a_scheduler_out_of_reach_is_told_with_its_address(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(cluster_module, "_CONNECT", 0.5)
    code, told = command(tmp_path, capsys, executor="dask://127.0.0.1:1")
    assert code == 2
    assert "--executor: no dask scheduler answers at dask://127.0.0.1:1" in told
    assert "start `dask scheduler` there" in told
    assert "Traceback" not in told


def test_a_missing_extra_is_told_with_its_cure(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code, told = command(tmp_path, capsys, executor="dask://10.0.0.5:8786")
    assert code == 2
    assert "pip install 'ballesta[cluster]'" in told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "address",
    ["dask", "10.0.0.5:8786", "dask://10.0.0.5", "dask://10.0.0.5:0", "dask://10.0.0.5:65536",
     "dask://:8786", "dask://10.0.0.5:8786/x", "tcp://10.0.0.5:8786", "Local"],
)  # fmt: skip
def test_a_malformed_address_is_told_with_what_is_expected(tmp_path, capsys, address):
    code, told = command(tmp_path, capsys, executor=address)
    assert code == 2
    assert "must be local or dask://HOST:PORT such as dask://10.0.0.5:8786" in told
    assert not (tmp_path / "out").exists()


@installed
def test_addresses_are_those_of_dask():
    assert scheduler_of("local") is None
    assert scheduler_of("dask://node-7.site:8786") == "tcp://node-7.site:8786"
    assert scheduler_of("dask://[::1]:8786") == "tcp://[::1]:8786"


@installed
def test_the_number_of_jobs_is_for_the_cluster_to_say(tmp_path, capsys):
    code, told = command(tmp_path, capsys, executor="dask://10.0.0.5:8786", jobs=4)
    assert code == 2
    assert "--jobs: is for --executor local" in told


FORGED = '''
import pickle

class Command:
    """A command that runs where it is unpickled, and what is then there instead of it."""
    def __init__(self, site, left="7"):
        told = f"echo $PPID >> {site.folder}/ran"
        self.text = f"(__import__('os').system({told!r}), {left})[1]"
    def __reduce__(self):
        return eval, (self.text,)

def reply(index, job, site):
    return Command(site)

def warn(index, job, site):
    from distributed import get_worker
    evil = pickle.dumps(Command(site))
    get_worker().log_event("warn", {"category": evil, "message": evil})
    return Command(site)

def text(index, job, site):
    ended = '{"index": 7, "outcome": {}, "seconds": 0.0, "peak": 0, "attempts": 1}'
    return '{"worker": "w", "finished": ' + ended + '}'

def number(index, job, site):
    return 7

def fail(site, exception, traceback):
    """Fail as a worker does that has its own idea of an exception."""
    from distributed import protocol, worker
    plain = worker.error_message
    def forged(error, status="error"):
        worker.error_message = plain
        sent = [protocol.to_serialize(pickle.dumps(each)) for each in (exception, traceback)]
        return plain(error, status) | {"exception": sent[0], "traceback": sent[1]}
    worker.error_message = forged
    raise ValueError

def exception(index, job, site):
    fail(site, Command(site, "ValueError()"), None)

def traceback(index, job, site):
    fail(site, ValueError(), Command(site, "None"))

def no_exception(index, job, site):
    fail(site, 7, 7)
'''
COMMANDS = ("reply", "warn", "exception", "traceback")


def forged(tmp_path, machines, monkeypatch, how):
    """What the batch says of a worker's forged reply, and the processes that ran its command."""
    (machines.folder / "forged_there.py").write_text(FORGED)
    monkeypatch.syspath_prepend(machines.folder)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cluster_module, "run_there", getattr(import_module("forged_there"), how))
    with pytest.raises(DesignError) as caught:
        fates(tmp_path, machines, {"a": "one"})
    ran = tmp_path / "ran"
    return caught.value.problem, set(map(int, ran.read_text().split())) if ran.exists() else set()


@installed
@pytest.mark.parametrize("how", [*COMMANDS, "text", "number", "no_exception"])
def test_a_forged_reply_runs_nothing_where_the_batch_was_started(
    tmp_path, machines, monkeypatch, how
):
    """And does not keep it waiting: a traceback that was none did."""
    told, ran = forged(tmp_path, machines, monkeypatch, how)
    assert re.search(r"does not run on the cluster|repl(y|ied)", told)
    assert os.getpid() not in ran


@installed
@pytest.mark.parametrize("how", COMMANDS)
def test_a_forged_reply_would_run_where_dask_may_unpickle(tmp_path, machines, monkeypatch, how):
    """The forgeries are real ones: by dask's own reading, each runs its command here."""
    monkeypatch.setattr(cluster_module, "nothing_unpickled", nullcontext)
    assert os.getpid() in forged(tmp_path, machines, monkeypatch, how)[1]


def test_a_reply_is_plain_text_of_a_fixed_form():
    finished = Finished(3, {"status": "pass"}, 0.5, 10, 1, said=["meshing"])
    reply = Reply("tcp://w:1", "", finished, {"a": None, "b": "digest"})
    assert from_text(to_text(reply)) == reply
    for wrong in ('{"worker": 1}', '{"worker": "w", "more": 1}', "[]", "{", '{"worker": NaN}'):
        with pytest.raises(ValueError, match=r"\S"):
            from_text(wrong)


def test_dask_may_unpickle_nothing_that_names_code():
    """Whatever a pickle names becomes `Unread`; dask's own texts and errors are read."""
    with nothing_unpickled():
        from distributed.protocol import pickle as protocol

        loads = protocol.loads
        assert isinstance(loads(pickle.dumps(os.system)), type)
        assert loads(pickle.dumps({"a": (1, "b", None, {2})})) == {"a": (1, "b", None, {2})}
        assert isinstance(loads(pickle.dumps(ModuleNotFoundError("x"))), ModuleNotFoundError)
        assert isinstance(loads(pickle.dumps(PoolError("x"))), PoolError)
        assert isinstance(loads(pickle.dumps(Path("x"))), Unread)
        assert loads(pickle.dumps(eval)) is Unread
    assert protocol.pickle is pickle


@installed
def test_certificates_are_taken_from_a_folder(tmp_path, capsys):
    assert scheduler_of("tls://10.0.0.5:8786") == "tls://10.0.0.5:8786"
    code, told = command(tmp_path, capsys, executor="tls://10.0.0.5:8786", tls=tmp_path)
    assert (code, "--tls: needs ca.pem, cert.pem and key.pem" in told) == (2, True)
    code, told = command(tmp_path, capsys, executor="dask://10.0.0.5:8786", tls=tmp_path)
    assert (code, "--tls: is for --executor tls://HOST:PORT" in told) == (2, True)
    for name in ("ca", "cert", "key"):
        (tmp_path / f"{name}.pem").write_text("")
    security = cluster_module.security_of(tmp_path)
    assert security.require_encryption
    assert security.tls_ca_file == str(tmp_path / "ca.pem")


def certified(folder):
    """A folder with ca.pem, cert.pem and key.pem, made by the commands of docs/cluster.md."""
    folder.mkdir()
    text = (Path(__file__).parents[3] / "docs" / "cluster.md").read_text(encoding="utf-8")
    commands = re.findall("^(?:mkdir|openssl) .*", text, re.MULTILINE)
    assert len(commands) == 4
    for words in commands:
        subprocess.run(words.split(), check=True, capture_output=True, cwd=folder)
    return folder / "certificates"


@installed
@pytest.mark.slow
@pytest.mark.skipif(which("openssl") is None, reason="needs the command openssl")
def test_a_cluster_with_tls_takes_only_who_has_a_certificate_of_its_authority(tmp_path, capsys):
    """By options as docs/cluster.md has them."""
    tls, stranger = certified(tmp_path / "ours"), certified(tmp_path / "theirs")
    (tmp_path / "machines").mkdir()
    machines = DaskMachines(tmp_path / "machines", tls=tls)
    try:
        machines.add_worker()
        assert machines.address.startswith("tls://")
        code, told = command(tmp_path, capsys, executor=machines.address, tls=tls)
        assert code == 1, told
        assert (tmp_path / "out" / "machine" / "result.json").is_file()
        shutil.rmtree(tmp_path / "out")
        plainly = machines.address.replace("tls", "dask")
        for executor, folder in ((machines.address, stranger), (plainly, None)):
            code, told = command(tmp_path, capsys, executor=executor, tls=folder)
            assert code == 2
            assert "--executor: no dask scheduler answers at" in told
            assert "Traceback" not in told
            assert not list((tmp_path / "out").glob("*/result.json"))
    finally:
        machines.kill()
