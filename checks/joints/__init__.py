"""Pins, bushes, lugs and slots: pressures, tearing out, bending over a stack."""
