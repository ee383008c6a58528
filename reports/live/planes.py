"""Whole numbers as planes of bytes in one compressed text: how a payload is put together."""

import zlib
from base64 import b64decode, b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

_GZIP = 16 + zlib.MAX_WBITS
_MOST = 4  # planes: numbers of 32 bits


@dataclass
class Writer:
    """Collects arrays; `layout` then says what stands in the text, in its order.

    layout  per section its name, the length of its arrays, and the number of planes of each
    """

    layout: list[dict[str, object]] = field(default_factory=list)
    _chunks: list[bytes] = field(default_factory=list)

    def add(self, name: str, arrays: Sequence[npt.NDArray[np.int64]]) -> None:
        """Add a section of arrays of one length; raises ValueError beyond 32 bits.

        Signs go to the lowest bit: 0, -1, 1, -2 become 0, 1, 2, 3.
        """
        counts = []
        for values in arrays:
            folded = np.where(values < 0, -2 * values - 1, 2 * values)
            largest = int(folded.max(initial=0))
            if largest >= 1 << 8 * _MOST:
                raise ValueError(f"live payload: {name} needs more than 32 bits ({largest})")
            planes = (largest.bit_length() + 7) // 8
            whole = folded.astype("<u4").view(np.uint8).reshape(-1, 4)
            self._chunks += [whole[:, plane].tobytes() for plane in range(planes)]
            counts.append(planes)
        length = len(arrays[0]) if len(arrays) else 0
        self.layout.append({"name": name, "length": length, "planes": counts})

    def text(self) -> str:
        """All of it: base64 of gzip, the same for the same numbers."""
        # level 9 takes ten times as long for 2 % less
        packer = zlib.compressobj(5, zlib.DEFLATED, _GZIP, 9, zlib.Z_FILTERED)
        return b64encode(packer.compress(b"".join(self._chunks)) + packer.flush()).decode()


def read_planes(
    text: str, layout: Sequence[dict[str, object]]
) -> dict[str, list[npt.NDArray[np.int64]]]:
    """Sections of a payload by name: what was added to its `Writer`; ValueError if damaged."""
    data = np.frombuffer(zlib.decompress(b64decode(text), _GZIP), dtype=np.uint8)
    found: dict[str, list[npt.NDArray[np.int64]]] = {}
    place = 0
    for section in layout:
        length, planes = section["length"], section["planes"]
        assert isinstance(length, int)
        assert isinstance(planes, list)
        arrays = []
        for count in planes:
            folded = np.zeros(length, dtype=np.int64)
            for plane in range(count):
                folded |= data[place : place + length].astype(np.int64) << 8 * plane
                place += length
            arrays.append(np.where(folded & 1, -(folded + 1) // 2, folded // 2))
        found[str(section["name"])] = arrays
    if place != len(data):
        raise ValueError(f"live payload: {len(data)} bytes, its header tells of {place}")
    return found
