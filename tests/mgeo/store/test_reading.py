import pytest

from mgeo.store.reading import read_json, read_text
from mgeo.validation.entries import FileError


@pytest.mark.parametrize("number", ["NaN", "-Infinity"])
def test_numbers_of_json_are_finite(number, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(f'{{"a": [1, {number}]}}')
    with pytest.raises(FileError, match=f"{number} is no finite number") as caught:
        read_json(path)
    assert str(caught.value).startswith(str(path))


def test_a_byte_order_mark_is_no_part_of_a_text(tmp_path):
    path = tmp_path / "a"
    path.write_text('{"é": 1}', encoding="utf-8-sig")
    assert (read_text(path), read_json(path)) == ('{"é": 1}', {"é": 1})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "nested too deeply"),
        ("", "Expecting value"),
    ],
)
def test_what_is_no_json_of_ours(text, message, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(FileError, match=message):
        read_json(path)


def test_other_numbers_of_json_are_read_exactly(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("[1, 0.1, -2.5e-300, 12345678901234567890]")
    assert read_json(path) == [1, 0.1, -2.5e-300, 12345678901234567890]
