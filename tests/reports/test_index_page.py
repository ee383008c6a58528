import json
import re
from base64 import b64encode
from hashlib import sha256

from checks.result.verdict import Check
from reports.index_page import STATIC_ROWS, IndexDesign, index_html

from . import results
from .test_page import Page

NASTY = "</script><b onload=alert(1)>&"


def check(value, governing=True, **changes):
    made = Check(**{**vars(results.check()), "value": value, **changes})
    plain = made.to_dict() | {"check": made.kind, "governing": governing}
    del plain["basis"]  # a batch's outcomes do not have it
    return plain


def design(name, *checks, status="pass", **changes):
    plain = {
        "name": name, "title": name, "file": f"{name}.toml", "status": status, "error": "",
        "stage": "", "note": "", "broken_gates": [], "mass": 1.5, "checks": checks,
        "link": f"{name}/result.json" if checks else "", "thumbnail": b"",
    }  # fmt: skip
    return IndexDesign(**{**plain, **changes})


DESIGNS = [
    design("one", check(100.0), check(7.0, governing=False, kind="buckling")),
    design("two", status="crashed", error="its process was killed", stage="meshing", mass=None),
    design(NASTY, check(300.0), status="FAIL", thumbnail=b"\x89PNG"),
]
VARIED = {"wall [mm]": [4.0, 5.0, 6.0], "material": ["S275", None, NASTY]}


def data_of(page):
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    return json.loads(text)


def test_the_page_is_well_formed_and_asks_nothing_of_any_network():
    text = index_html("batch", DESIGNS, VARIED)
    page = Page(text)
    assert not {tag for tag, _ in page.tags} & {"link", "iframe", "object", "embed", "form", "base"}
    assert not [a for tag, a in page.tags if tag == "script" and "src" in a]
    for _, attributes in page.tags:
        assert not [name for name in attributes if name.startswith("on")]
    outside = text.replace("http://www.w3.org/2000/svg", "")  # a name of XML, never fetched
    assert not re.search(r"https?://|@import|url\(", outside)


def test_the_policy_lets_only_the_page_s_own_script_run():
    text = index_html("batch", DESIGNS, VARIED)
    (policy,) = [a["content"] for _, a in Page(text).tags if a.get("http-equiv")]
    (script,) = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert "innerHTML" not in script


def test_hostile_names_stay_text():
    text = index_html(NASTY, DESIGNS, VARIED)
    assert "<b onload" not in text
    assert NASTY in Page(text).text
    assert data_of(text)["designs"][2]["name"] == NASTY


def test_without_its_script_the_page_shows_the_governing_checks_of_the_first_designs():
    many = [design(f"d{k}", check(100.0 + k)) for k in range(STATIC_ROWS + 50)]
    text = index_html("batch", many, {})
    rows = re.findall(r'<th scope="row" class="k name">', text)
    assert len(rows) == STATIC_ROWS
    assert f"the first {STATIC_ROWS} of {STATIC_ROWS + 50}" in Page(text).text
    assert len(data_of(text)["designs"]) == STATIC_ROWS + 50


def test_a_design_without_a_verdict_tells_its_cause_and_counts_as_no_pass():
    text = index_html("batch", DESIGNS, VARIED)
    assert '<span class="word FAIL">crashed</span>' in text
    assert "its process was killed" in Page(text).text
    counts = re.findall(r'<span class="badge (\w+)"><b>(\d+)</b>(\w+)', text)
    assert counts == [("FAIL", "1", "FAIL"), ("FAIL", "1", "crashed"), ("pass", "1", "PASS")]


def test_the_script_gets_numbers_to_the_last_bit():
    value = 0.1 + 0.2
    data = data_of(index_html("batch", [design("one", check(value))], {}))
    assert data["checks"]["value"] == [value]


def test_40_000_checks_open_and_sort_in_a_browser(tmp_path, opened):
    """2 000 designs of 20 checks: 100 rows are drawn, sorted by value (time: bench.index_page)."""
    many = [
        design(f"d{k:04d}", *(check(1.0 + (37 * (20 * k + n)) % 40_000, n == 0) for n in range(20)))
        for k in range(2000)
    ]
    path = tmp_path / "index.html"
    varied = {"wall [mm]": [float(k) for k in range(2000)]}
    path.write_text(index_html("batch", many, varied), encoding="utf-8")
    found = opened(path)
    page = found.page
    page.locator("#view").select_option("all")
    head = page.locator("th button", has_text=re.compile("^value$"))
    head.click()
    head.click()  # the largest first
    rows = page.locator("#table tbody tr")
    rows.first.get_by_text("40000 MPa").wait_for()
    assert rows.count() == 100
    assert page.locator("#place").inner_text() == "1 to 100 of 40000"
    assert page.locator("[data-design]").count() == 2000
    found.assert_quiet()


def test_the_front_has_no_design_that_is_heavier_and_nearer_to_its_limit_than_another(
    tmp_path, opened
):
    """Reserve 355/(1.5 value): c is heavier than b with less reserve; a fails, b is lightest."""
    masses = {"a": 1.0, "b": 2.0, "c": 3.0, "d": 4.0, "no mass": None}
    values = {"a": 300.0, "b": 150.0, "c": 200.0, "d": 100.0, "no mass": 50.0}
    made = {name: check(values[name], numerical=0.0, model=0.0) for name in masses}
    path = tmp_path / "index.html"
    path.write_text(
        index_html(
            "batch",
            [design(n, made[n], status=made[n]["status"], mass=m) for n, m in masses.items()],
            {"wall [mm]": [4.0, 5.0, 5.0, 6.0, 7.0]},
        ),
        encoding="utf-8",
    )
    found = opened(path)
    page = found.page
    dots = {
        name: (float(dot.get_attribute("cx")), float(dot.get_attribute("cy")))
        for name, dot in zip("abcd", page.locator("[data-design]").all(), strict=True)
    }
    steps = [
        float(n) for n in re.findall(r"[-\d.]+", page.locator("path.front").get_attribute("d"))
    ]
    corners = [*dots["a"], *dots["b"], *dots["d"]]
    assert [round(n, 6) for n in steps] == [round(n, 6) for n in corners]
    assert page.locator("text.lightest").text_content() == "lightest pass: b, 2.000 kg"
    assert "4 of 5 designs" in page.locator("#told").text_content()
    page.locator("#x").select_option("wall [mm]")
    assert page.locator("path.front, text.lightest, #front:visible").count() == 0
    found.assert_quiet()


def test_axe_finds_nothing_on_a_batch(tmp_path, opened, axe):
    (tmp_path / "index.html").write_text(index_html("batch", DESIGNS, VARIED), encoding="utf-8")
    found = opened(tmp_path / "index.html", bypass_csp=True)
    for name in ("one", "two"):
        found.page.get_by_label(f"Compare {name}").check()
    assert axe(found.page) == []


def test_two_to_four_designs_stand_side_by_side_bold_where_they_differ(tmp_path, opened):
    many = [design(name, check(100.0 + k)) for k, name in enumerate("abcde")]
    path = tmp_path / "index.html"
    path.write_text(index_html("batch", many, {"wall [mm]": [25 / 3] * 5}), encoding="utf-8")
    found = opened(path)
    page = found.page
    page.get_by_label("Compare a").check()
    assert page.locator("#beside").is_hidden()
    for name in "bcde":
        page.get_by_label(f"Compare {name}").check()
    assert not page.get_by_label("Compare a").is_checked()  # a fifth takes the place of the first
    rows = {
        row[0]: row[1:]
        for row in page.locator("#beside tr").evaluate_all(
            "all => all.map((row) => [...row.cells].map((cell) => cell.textContent))"
        )
    }
    assert rows["design"] == list("bcde")
    assert rows["wall [mm]"] == ["8.33333"] * 4
    assert rows["bar_upper: static: safety"][0] == "3.51 (1.5) pass"
    bold = page.locator("#beside .differs th").all_text_contents()
    assert bold == ["design", "bar_upper: static: safety"]
    found.assert_quiet()


def test_a_sample_of_one_design_shows_the_share_of_each_input():
    wall = [1.0 + index / 80 for index in range(80)]
    width = [float((7 * index) % 80) for index in range(80)]
    several = [
        design(f"d{index}", check(100.0 * value), file="one.toml")
        for index, value in enumerate(wall)
    ]
    page = index_html("sample", several, {"wall [mm]": wall, "width [mm]": width})
    assert "share of the utilisation" in page
    rows = re.findall(r'class="k">(w\w+) \[mm\]</th>.*?</td><td class="n">(\d+)%</td>', page)
    (_, of_wall), (_, of_width) = rows
    assert int(of_wall) > 95
    assert int(of_width) < 10
    other = [*several[:-1], design("other", check(180.0), file="other.toml")]
    assert "share of the utilisation" not in index_html("two", other, {"wall [mm]": wall})
