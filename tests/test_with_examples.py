"""Doctests are collected where an example stands, and only there."""

from . import with_examples


def collected(path, monkeypatch):
    """What is left of a file's collectors: a module of tests, and one of doctests."""
    monkeypatch.setattr(with_examples, "DoctestModule", str)
    hook = with_examples.pytest_collect_file(path)
    next(hook)
    try:
        hook.send([1, "doctests"])
    except StopIteration as end:
        return end.value


def test_a_module_without_an_example_has_no_doctests(tmp_path, monkeypatch):
    path = tmp_path / "module.py"
    path.write_text('"""Nothing to run, é."""\n', encoding="utf-8")
    assert collected(path, monkeypatch) == [1]
    path.write_text('"""\n>>> 1\n1\n"""\n', encoding="utf-8")
    assert collected(path, monkeypatch) == [1, "doctests"]


def test_every_run_of_the_tests_has_the_plugin(request):
    assert request.config.pluginmanager.is_registered(with_examples)
