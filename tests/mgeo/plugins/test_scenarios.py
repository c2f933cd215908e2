import pytest

from mgeo.plugins.problems import read_scenario


def test_scenario_is_none_preset_or_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('load = 3.5\n[orbit]\nkind = "low"\n')
    assert read_scenario("cantilever", None) == {}
    assert read_scenario("cantilever", "heavy") == {"preset": "heavy"}
    assert read_scenario("cantilever", str(path)) == {"load": 3.5, "orbit": {"kind": "low"}}


def test_byte_order_mark_is_accepted(tmp_path):
    scenario, after = tmp_path / "a.toml", tmp_path / "b.json"
    scenario.write_text("load = 750", encoding="utf-8-sig")
    after.write_text('{"a": 1}', encoding="utf-8-sig")
    found = read_scenario("unknown", str(scenario), after=after)
    assert found == {"load": 750, "after": {"a": 1}}


@pytest.mark.parametrize("content", [b"load = = 3", b"load = '\xff'"])
def test_invalid_toml_file_is_reported_with_its_name(tmp_path, content):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"bad\.toml: (not valid TOML|.utf-8. codec)"):
        read_scenario("cantilever", str(path))
