"""The rungs of the ladder below the solid: models that are cheaper and know less."""
