import pytest

from mgeo.store.reading import read_json
from mgeo.validation.entries import FileError


@pytest.mark.parametrize(
    ("text", "message"),
    [('{"a": [1, NaN]}', "NaN is not a finite number"), ("", "Expecting value")],
)
def test_a_file_that_is_no_json_is_refused(text, message, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(FileError, match=message) as caught:
        read_json(path)
    assert str(caught.value).startswith(str(path))
