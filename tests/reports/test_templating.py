"""Templates of every page."""

import json
from base64 import b64encode
from hashlib import sha256

from markupsafe import Markup

from reports.templating import json_markup, script_hash


def test_nothing_in_json_ends_its_script_element_or_a_line():
    data = {"</script>": ["<!-- <script>", "a\u2028b\u2029c", "&lt;é", 1.5, None]}
    text = json_markup(data)
    assert isinstance(text, Markup)
    assert not set("<>&\u2028\u2029") & set(text)
    assert json.loads(text) == data


def test_the_hash_of_a_script_is_that_of_its_bytes():
    assert script_hash("é") == f"sha256-{b64encode(sha256('é'.encode()).digest()).decode()}"
