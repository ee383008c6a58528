"""Beams of I section, by formula."""

from checks.models.beams import stress
from checks.models.shape_model import ShapeModel
from geometry.parts import IBeam

MODEL = ShapeModel(IBeam, stress, press_fits=True, arcs=True)
