"""Errors that a person can act on: which file, which key, what is wrong there."""

import difflib
from collections.abc import Callable, Iterable
from pathlib import Path

from checks.result.words import brief

_LONGEST = 6000  # characters of one problem: an input may be longer than anybody reads
_MOST_TOLD = 40  # problems of one design


class DesignError(Exception):
    """A design file that cannot be checked as written."""

    def __init__(self, file: Path, key: str, problem: str) -> None:
        super().__init__(file, key, problem)  # all three: a batch sends errors between processes
        self.file, self.key, self.problem = file, key, problem

    def __str__(self) -> str:
        """One line, whatever names the file's author has chosen."""
        return brief(f"{self.file}: {self.key}: {self.problem}", _LONGEST)


class DesignErrors(DesignError):
    """Several problems in one design file, one line each; file, key and problem are the first's."""

    def __init__(self, errors: tuple[DesignError, ...]) -> None:
        super().__init__(errors[0].file, errors[0].key, errors[0].problem)
        self.args = (errors,)  # what pickling hands to __init__
        self.errors = errors

    def __str__(self) -> str:
        told = [str(error) for error in self.errors[:_MOST_TOLD]]
        more = len(self.errors) - len(told)
        return "\n".join([*told, f"and {more} more problems"] if more else told)


class NumericsError(Exception):
    """A solver gave up although the design is written correctly."""

    def __init__(self, what: str, where: str, advice: str) -> None:
        super().__init__(what, where, advice)
        self.what, self.where, self.advice = what, where, advice

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.advice}"


class Problems:
    """Collects the problems of one design, so that all of them are told at once.

    `file_of` tells which file a key is stated in, where the design takes from several.
    """

    def __init__(self, file: Path, file_of: Callable[[str], Path] | None = None) -> None:
        self.file, self._file_of = file, file_of
        self._found: dict[tuple[str, str], DesignError] = {}

    def __len__(self) -> int:
        return len(self._found)

    def add(self, key: str, problem: str) -> None:
        """Note a problem; the same one found twice counts once."""
        file = self.file if self._file_of is None else self._file_of(key)
        self._found.setdefault((key, problem), DesignError(file, key, problem))

    def take(self, error: DesignError) -> None:
        """Note an error that was raised with its own file."""
        self._found.setdefault((error.key, error.problem), error)

    def raise_if_any(self) -> None:
        """Raise what was found: a DesignError, or DesignErrors for more than one."""
        errors = tuple(self._found.values())
        if len(errors) == 1:
            raise errors[0]
        if errors:
            raise DesignErrors(errors)


# Wording for names that do not exist: the nearest right one, and what there is.

_LONGEST_NAMES = 200  # characters of a name that are told or compared

LINKAGE = "linkage"  # what stands for a part in the checks of the whole


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that looks most like `name`, or None when none does."""
    if len(name) > _LONGEST_NAMES:
        return None
    by_folded = {candidate.casefold(): candidate for candidate in known}
    found = difflib.get_close_matches(name.casefold(), by_folded, n=1, cutoff=0.6)
    return by_folded[found[0]] if found else None


def listed(names: Iterable[str]) -> str:
    """Return the names for a sentence, `none` when there are none."""
    from checks.result.words import brief  # the pytest plugin loads none of our packages

    return ", ".join(brief(name, _LONGEST_NAMES) for name in names) or "none"


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
    return f"no {kind} is named {brief(name, _LONGEST_NAMES)!r}{hint}{there_is}"
