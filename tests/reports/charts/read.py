"""Texts, cursor, columns and lines of a chart."""

import json
import xml.etree.ElementTree as ET

import numpy as np


def texts(svg):
    return [
        "".join(node.itertext()) for node in ET.fromstring(svg).iter() if node.tag.endswith("text")
    ]


def cursor(chart):
    return json.loads(ET.fromstring(chart.svg).get("data-cursor"))


def column(chart, name):
    return [row[chart.columns.index(name)] for row in chart.rows]


def has_line(lines, points):
    wanted = np.array(points, dtype=float)
    return any(one.shape == wanted.shape and np.allclose(one, wanted) for one in lines)
