"""Compiled templates are kept beside themselves, and are never older than their text."""

import sys

import jinja2.environment

from reports import templating


def compiled_of(monkeypatch, folder):
    """Names of the templates that are compiled when one is asked for."""
    monkeypatch.setattr(templating, "_TEMPLATES", folder)
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    found = []
    compile_it = jinja2.environment.Environment.compile

    def counted(self, source, *given, **options):
        found.append(source)
        return compile_it(self, source, *given, **options)

    monkeypatch.setattr(jinja2.environment.Environment, "compile", counted)
    return found


def text():
    return templating.environment().get_template("a.j2").render(x="<b>")


def test_a_template_is_compiled_once_and_again_when_its_text_changes(tmp_path, monkeypatch):
    compiled = compiled_of(monkeypatch, tmp_path)
    (tmp_path / "a.j2").write_text("one {{ x }}")
    assert [text(), text()] == ["one &lt;b&gt;"] * 2
    assert len(compiled) == 1
    (tmp_path / "a.j2").write_text("two {{ x }}")
    assert text() == "two &lt;b&gt;"
    assert len(compiled) == 2


def test_where_nothing_can_be_kept_a_template_is_compiled_each_time(tmp_path, monkeypatch):
    compiled = compiled_of(monkeypatch, tmp_path)
    (tmp_path / "a.j2").write_text("one {{ x }}")
    (tmp_path / "__pycache__").write_text("a file where the folder would be")
    assert [text(), text()] == ["one &lt;b&gt;"] * 2
    assert len(compiled) == 2
