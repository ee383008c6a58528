"""Checks whose stills are not drawn: they take seconds."""

from contextlib import nullcontext

import reports.pictures
from reports.pictures import Pictures


def draw_nothing(monkeypatch, reason=""):
    """Let nothing be drawn, for a reason if one is given."""
    monkeypatch.setattr(reports.pictures, "prepare_drawing", lambda **_: None)
    nothing = nullcontext(lambda: Pictures(reason=reason))
    monkeypatch.setattr(reports.pictures, "drawing", lambda result: nothing)
