"""Wording for names that do not exist: the nearest right one, and what there is."""

import difflib
from collections.abc import Iterable

_LONGEST = 200  # characters of a name that are told or compared

LINKAGE = "linkage"  # what stands for a part in the checks of the whole


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that looks most like `name`, or None when none does."""
    if len(name) > _LONGEST:
        return None
    by_folded = {candidate.casefold(): candidate for candidate in known}
    found = difflib.get_close_matches(name.casefold(), by_folded, n=1, cutoff=0.6)
    return by_folded[found[0]] if found else None


def listed(names: Iterable[str]) -> str:
    """Return the names for a sentence, `none` when there are none."""
    from checks.result.words import brief  # the pytest plugin loads none of our packages

    return ", ".join(brief(name, _LONGEST) for name in names) or "none"


def no_such(kind: str, name: str, known: Iterable[str]) -> str:
    """Say that `name` does not exist, what it may have meant, and what exists.

    >>> no_such("material", "S335", ["S275", "S355"])
    "no material is named 'S335', did you mean S355? There are S275, S355"
    """
    from checks.result.words import brief

    known = list(known)
    guess = nearest(name, known)
    there_is = f"here are {listed(known)}" if known else "here is none"
    hint = f", did you mean {guess}? T" if guess else "; t"
    return f"no {kind} is named {brief(name, _LONGEST)!r}{hint}{there_is}"
