import json
import stat
from dataclasses import replace

import meshio
import numpy as np
import pytest

from reports.files import _over_lines, plain, replacing, write_json, write_vtu

from . import results


def read(folder):
    return json.loads((folder / "result.json").read_text(encoding="utf-8"))


def test_a_result_comes_back_from_json_as_it_went(tmp_path):
    """Floats are written to the last digit, so nothing is left: ==."""
    result = results.mixed()
    write_json(result, tmp_path / "result.json")
    back = read(tmp_path)
    assert back == plain(result.to_dict())
    assert back["status"] == "FAIL"
    assert back["decided_by"] == {"id": "bar_upper/fatigue", "part": "bar_upper", "kind": "fatigue"}
    assert back["cycles"]["press"]["position"] == results.cycle()["position"].tolist()
    assert list(back) == list(result.to_dict())


def test_infinite_bars_and_gaps_become_null(tmp_path):
    values = np.array([1.0, np.nan, np.inf])
    result = results.mixed()
    result.cycles["press"]["peaks"] = {"pin_B": values}
    write_json(result, tmp_path / "result.json")
    text = (tmp_path / "result.json").read_text()
    assert "NaN" not in text
    assert "Infinity" not in text
    back = read(tmp_path)
    assert back["cycles"]["press"]["peaks"]["pin_B"] == [1.0, None, None]
    assert back["parts"][1]["checks"][1]["numerical"] is None


def test_the_same_result_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        write_json(results.mixed(), tmp_path / name)
        write_vtu(results.part(), tmp_path / f"{name}.vtu")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert (tmp_path / "a.vtu").read_bytes() == (tmp_path / "b.vtu").read_bytes()


def test_a_list_of_numbers_stands_on_one_line(tmp_path):
    result = results.design(warnings=["[\n 1,\n 2\n]", "[ 1,  2 ]"])
    result.cycles["press"]["peaks"] = {"pin_B": [1.5, np.nan, -2e-9]}
    write_json(result, tmp_path / "result.json")
    assert '"pin_B": [1.5, null, -2e-09]' in (tmp_path / "result.json").read_text()
    assert read(tmp_path)["warnings"] == list(result.warnings)


def test_all_else_stands_on_lines_as_json_sets_them():
    data = {"a": {"b": [], "c": {}, "d": [{"é": None}, "x", 2]}, "e": [[], [[], "y"]], "f": -0.0}
    assert _over_lines(data) == json.dumps(data, indent=1, ensure_ascii=False)


def test_hostile_names_survive_json(tmp_path):
    write_json(results.hostile(), tmp_path / "result.json")
    assert read(tmp_path)["parts"][0]["name"] == results.HOSTILE
    write_json(results.design(name="half \ud800"), tmp_path / "result.json")
    assert read(tmp_path)["name"] == "half ?"


def test_what_json_cannot_hold_is_refused():
    with pytest.raises(TypeError, match="holds complex"):
        plain({"x": [1j]})


def test_a_failed_writing_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "report.html"
    path.write_text("old")

    def write():
        with replacing(path) as temporary:
            temporary.write_text("half of the n")
            raise RuntimeError("midway")

    with pytest.raises(RuntimeError, match="midway"):
        write()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_written_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").write_text("")
    write_json(results.design(), tmp_path / "result.json")
    modes = {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_a_surface_comes_back_from_vtu_with_its_fields(tmp_path):
    """Compressed binary holds every digit: ==."""
    surface = results.part().surface
    moved, stress = np.random.default_rng(0).normal(size=(2, len(surface.nodes), 6))
    directed = {"displacement [mm]": moved[:, :3], "stress [MPa]": stress}
    part = results.part(surface=replace(surface, directed=directed))
    write_vtu(part, tmp_path / "bar.vtu")
    mesh = meshio.read(tmp_path / "bar.vtu")
    assert np.array_equal(mesh.points, part.surface.nodes)
    assert np.array_equal(mesh.cells_dict["triangle"], part.surface.triangles)
    fields = {**part.surface.fields, **directed}
    assert mesh.point_data.keys() == fields.keys()
    for name, values in fields.items():
        assert np.array_equal(mesh.point_data[name], values)
    assert [path.name for path in tmp_path.iterdir()] == ["bar.vtu"]
