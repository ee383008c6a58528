"""A drawing program's SVG made small: what the picture does not need is left out.

Groups without a meaning are dissolved, ids that nothing refers to go, numbers keep a hundredth of a
point, paths use as few letters as they can, and lines of the same stroke that nothing but text
parts become one. A group that the caller named stays, with the attributes it is given.
"""

import re
from collections.abc import Iterable, Mapping
from hashlib import sha256
from xml.etree import ElementTree as ET

_SVG, _XLINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
_NUMBER = re.compile(r"-?\d*\.?\d+(?:e-?\d+)?")
_STEP = re.compile(r"([A-Za-z])|(-?\d*\.?\d+(?:e-?\d+)?)")
_STILL = re.compile(r"rotate\(-?0(?:\.0*)? [^)]*\)")
_INSIDE = 0.5  # points, by which a path may reach beyond its frame and need no clipping

Attributes = Mapping[str, Mapping[str, str]]
Frame = tuple[float, float, float, float]


def compact(text: str, named: Attributes, common: Mapping[str, str]) -> str:
    """SVG text, smaller, with ids that no other drawing has.

    named   id of a group as it was drawn -> attributes that it gets; "" is the whole drawing
    common  style that the whole drawing has, and so no text in it needs to repeat
    Raises ValueError for text that is not well-formed.
    """
    try:
        tree = ET.fromstring(text)
    except ET.ParseError as error:
        raise ValueError(f"the drawing is not well-formed: {error}") from error
    return _Compactor(text, tree, named, common).text()


class _Compactor:
    def __init__(
        self, text: str, tree: ET.Element, named: Attributes, common: Mapping[str, str]
    ) -> None:
        self.tree, self.named, self.common = tree, named, common
        used = sorted(set(re.findall(r"(?:url\(#|href=\"#)([^)\"]+)", text)))
        prefix = "c" + sha256(f"{text}{sorted(named.items())}".encode()).hexdigest()[:8]
        self.names = {old: f"{prefix}-{number}" for number, old in enumerate(used)}
        self.frames = {
            clip.get("id", ""): _frame(clip[0])
            for clip in tree.iter(f"{_SVG}clipPath")
            if len(clip) == 1 and clip[0].tag == f"{_SVG}rect"
        }

    def text(self) -> str:
        style = {"stroke-linejoin": "round", "stroke-linecap": "butt", **self.common}
        root = ET.Element("svg", {"viewBox": self.tree.get("viewBox", "")})
        root.attrib |= dict(self.named.get("", {}))
        root.set("style", ";".join(f"{key}:{value}" for key, value in style.items()))
        root.extend(_joined(made for child in self.tree for made in self._made(child)))
        clips = {name for node in root.iter() for name in _refers(node)}
        _prune(root, clips)
        out: str = ET.tostring(root, encoding="unicode")
        out = out.replace(" />", "/>")
        return out.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)

    def _made(self, node: ET.Element) -> list[ET.Element]:
        """Elements that replace an element: none, itself, or the content of a group."""
        tag = node.tag.replace(_SVG, "")
        if tag in ("metadata", "style", "title"):
            return []
        own = node.get("id") or "-"  # "" in `named` is the whole drawing
        inside = [made for child in node for made in self._made(child)]
        if own in self.named:
            attributes = dict(self.named[own])
        elif tag == "defs":
            return inside  # a clip or a marker may stand anywhere if it is not drawn itself
        else:
            attributes = self._attributes(node)
            if tag == "g" and not attributes:
                return inside
        if tag == "path" and not _is_drawn(attributes):
            return []
        if tag == "g" and not inside:
            return []
        made = ET.Element(tag, attributes)
        made.text = node.text if tag in ("text", "tspan") else None
        made.extend(inside)
        if tag == "path" and "id" in attributes:
            holder = ET.Element("defs")
            holder.append(made)
            return [holder]
        return [made]

    def _attributes(self, node: ET.Element) -> dict[str, str]:
        found: dict[str, str] = {}
        for key, value in node.attrib.items():
            if key == "id":
                if value in self.names:
                    found["id"] = self.names[value]
            elif key == _XLINK + "href":
                found["href"] = f"#{self.names[value.removeprefix('#')]}"
            elif key == "d":
                found["d"] = short_path(value)
            elif key == "transform":
                found["transform"] = "" if _STILL.fullmatch(value) else _rounded(value)
            elif key == "clip-path":
                clip = value.removeprefix("url(#").removesuffix(")")
                if not _within(node, self.frames.get(clip)):
                    found["clip-path"] = f"url(#{self.names[clip]})"
            elif key == "style":
                found["style"] = self._style(value)
            elif key in ("x", "y", "width", "height"):
                found[key] = _rounded(value)
            else:
                found[key.replace(_XLINK, "")] = value
        return {key: value for key, value in found.items() if value}

    def _style(self, text: str) -> str:
        pairs = [part.partition(":")[::2] for part in text.split(";") if part.strip()]
        kept = [
            (key.strip(), re.sub(r", +", ",", value.strip()))
            for key, value in pairs
            if self.common.get(key.strip()) != value.strip()
        ]
        return ";".join(f"{key}:{value}" for key, value in kept)


def _frame(rect: ET.Element) -> Frame:
    x, y, width, height = (float(rect.get(key, 0)) for key in ("x", "y", "width", "height"))
    return x - _INSIDE, y - _INSIDE, x + width + _INSIDE, y + height + _INSIDE


def _within(node: ET.Element, frame: Frame | None) -> bool:
    """Return True if all places of an element are inside a frame, so that it needs no clipping."""
    if frame is None:
        return False
    left, low, right, top = frame
    places: list[float] = []
    if node.tag == f"{_SVG}path":
        places = [float(value) for value in _NUMBER.findall(node.get("d", ""))]
    for use in node.iter(f"{_SVG}use"):
        places += [float(use.get("x", 0)), float(use.get("y", 0))]
    return all(left <= x <= right for x in places[::2]) and all(
        low <= y <= top for y in places[1::2]
    )


def _is_drawn(attributes: Mapping[str, str]) -> bool:
    """Return True if a path shows anything: it has a way, and a stroke or a filling."""
    way = attributes.get("d", "")
    if "id" in attributes:
        return True
    return bool(re.search(r"[A-LN-Za-ln-z]| .* ", way)) and attributes.get("style") != "fill:none"


def _joined(nodes: Iterable[ET.Element]) -> list[ET.Element]:
    """Neighbours, with paths of the same stroke between which there is only text made one."""
    out: list[ET.Element] = []
    since: dict[str, ET.Element] = {}
    for node in nodes:
        if node.tag == "path" and "fill:none" in node.get("style", ""):
            key = f"{node.get('style')} {node.get('clip-path')}"
            if key in since:
                since[key].set("d", since[key].get("d", "") + node.get("d", ""))
                continue
            since = {key: node}
        elif node.tag != "text":
            since = {}
        out.append(node)
    return out


def _refers(node: ET.Element) -> list[str]:
    named = [node.get("href", "").removeprefix("#")]
    return [*named, node.get("clip-path", "").removeprefix("url(#").removesuffix(")")]


def _prune(node: ET.Element, used: set[str]) -> None:
    """Take out what is only there to be referred to, and is not."""
    for child in list(node):
        _prune(child, used)
        if child.tag == "clipPath" and child.get("id") not in used:
            node.remove(child)


def _rounded(text: str) -> str:
    return _NUMBER.sub(lambda found: _short(float(found[0])), text)


def short_path(text: str) -> str:
    """A path with a hundredth of a point; a line that goes on names no letter again.

    >>> short_path("M 10.001 20 L 30.5 40.25 L 30.5 40.25 L 31 50 z")
    'M10 20L30.5 40.25 31 50z'
    """
    out: list[str] = []
    letter, written = "", ""
    numbers: list[str] = []
    last: list[str] = []

    def put() -> None:
        nonlocal written, last
        if not letter or (not numbers and letter not in "zZ"):
            return
        if letter == "L" and numbers == last and written == "L":
            return  # no way from the place before
        goes_on = letter == written and letter not in "MzZ"
        out.append((" " if goes_on else letter) + " ".join(numbers))
        written, last = letter, numbers[-2:]

    for found in _STEP.finditer(text):
        if found[1]:
            put()
            letter, numbers = found[1], []
        else:
            numbers.append(_short(float(found[2])))
    put()
    return "".join(out)


def _short(value: float) -> str:
    return f"{round(value, 2) + 0.0:.2f}".rstrip("0").rstrip(".")
