"""Beams of I section, by formula."""

from checks.models.beams import family, stress
from checks.models.shape_model import ShapeModel
from geometry.parts import IBeam

MODEL = ShapeModel(IBeam, stress, family=family, press_fits=True, arcs=True)
