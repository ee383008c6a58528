"""Checks of whole machines without what takes most of their time, where a test looks elsewhere."""

from contextlib import contextmanager
from dataclasses import replace

import pytest

import ballesta.pipeline


def without_fatigue(design):
    """The design with no cycle in its duty: forces, yield and buckling stay as they are."""
    return replace(design, duty=replace(design.duty, cycles={}))


@contextmanager
def buckling_of_no_linkage():
    """Within this no linkage is looked at as a frame that may buckle; parts are as ever."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ballesta.pipeline, "worst_mode", lambda *_: None)
        yield
