"""A small picture of a design for the index, taken from the stills in its report."""

import io
import re
from base64 import b64decode
from pathlib import Path

_WIDTH = 180  # pixels
_STILL = re.compile(r'<img alt="([^"]*)"[^>]*? src="data:image/png;base64,([^"]*)"')


def write_thumbnail(folder: Path, part: str) -> None:
    """Write thumbnail.png from the first still of a part in report.html; nothing without stills."""
    from markupsafe import escape

    from ballesta.batches.files import write_whole
    from checks.result.words import brief

    stills = _STILL.findall((folder / "report.html").read_text(encoding="utf-8"))
    named = f" of {escape(brief(part, 60))}, "
    found = next((data for words, data in stills if named in words), None)
    if found is None:
        return
    from PIL import Image

    with Image.open(io.BytesIO(b64decode(found))) as image:
        small = image.convert("RGB")
        small.thumbnail((_WIDTH, _WIDTH))
        out = io.BytesIO()
        small.quantize(64).save(out, "PNG", optimize=True)
    write_whole(folder / "thumbnail.png", out.getvalue())
