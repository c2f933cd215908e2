import pytest

from mgeo.store.reading import read_json
from mgeo.validation.entries import FileError


@pytest.mark.parametrize("number", ["NaN", "-Infinity"])
def test_numbers_of_json_are_finite(number, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(f'{{"a": [1, {number}]}}')
    with pytest.raises(FileError, match=f"{number} is no finite number") as caught:
        read_json(path)
    assert str(caught.value).startswith(str(path))


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
