"""Beams of rectangular hollow section, by formula."""

from checks.models.beams import family, stress
from checks.models.shape_model import ShapeModel
from geometry.parts import RhsBeam

MODEL = ShapeModel(RhsBeam, stress, family=family, press_fits=True, arcs=True)
