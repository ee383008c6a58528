"""What a part's solids are expected to take, before they are paid for."""

# Measured on a machine with 2 cores (bench/results.json): 137 628 unknowns with 20 unit loads take
# 8 s and 1.3 GiB; both grow somewhat faster than the unknowns do.
_UNKNOWNS, _SECONDS, _GIBIBYTES = 137_628, 8.0, 1.3
_TIME_EXPONENT, _MEMORY_EXPONENT = 1.3, 1.2
SECOND_MESH = 1.8  # times the unknowns of the first, as parts of the press need them
BESIDE = 2.0  # times solving: with meshing, superposing and judging


def solve_seconds(unknowns: int) -> float:
    """Estimated time to solve a part's unit loads, s."""
    return float(_SECONDS * (unknowns / _UNKNOWNS) ** _TIME_EXPONENT)


def solve_gibibytes(unknowns: int) -> float:
    """Estimated memory to solve a part's unit loads, GiB."""
    return float(_GIBIBYTES * (unknowns / _UNKNOWNS) ** _MEMORY_EXPONENT)


def check_seconds(first: int) -> float:
    """Estimated time of a part's check on two meshes, the first of them with so many unknowns."""
    second = int(SECOND_MESH * first)
    return BESIDE * (solve_seconds(first) + solve_seconds(second))
