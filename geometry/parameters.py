"""Parameters of a parametric part: plain dataclass fields that know their dimension and meaning.

A part's parameters are the fields of a frozen dataclass, in mm inside the code. Their metadata is
what the design file's door, its JSON schema and the documentation of the parts are made from, so a
parameter is described once, beside the geometry that uses it.
"""

from dataclasses import MISSING, field
from typing import Any

GIVEN_BY_LINKAGE = "linkage"
GIVEN_BY_DESIGN = "design"


def length(meaning: str, *, default: Any = MISSING, given_by: str = GIVEN_BY_DESIGN) -> Any:
    """A length in mm; `default` makes it optional, `given_by` says who fills it in.

    `given_by="linkage"` is a length that follows from the mechanism (the distance between two pins):
    the design file must not state it a second time.
    """
    return field(
        default=default,
        kw_only=True,
        metadata={"dimension": "length", "meaning": meaning, "given_by": given_by},
    )
