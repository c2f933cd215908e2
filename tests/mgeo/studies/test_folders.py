import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.studies.comparison_files import format_folder_name

SIMILAR_LABELS = ["a b", "a-b", "a.b", "a  b", "A b", "a b ", "a/b", "a, b", "a_b", "ab", "a\nb"]


def test_similar_labels_have_different_folder_names():
    assert format_folder_name("attitude cubesat_6u") == "attitude-cubesat_6u"
    assert format_folder_name("dtlz2, n_obj = 3").startswith("dtlz2-n_obj-3~")
    assert format_folder_name("runs").startswith("runs~")  # The name runs is reserved.
    names = {format_folder_name(label).lower() for label in SIMILAR_LABELS}
    assert len(names) == len(SIMILAR_LABELS)


@pytest.mark.slow
@given(st.text(), st.text())
def test_folder_names_are_valid_and_unique(a, b):
    for label in (a, b):
        name = format_folder_name(label)
        assert not set(name) & set('/\\:*?"<>|\0 ')
        assert name.strip(".") == name != ""
        assert len(name.encode()) < 255
    assert (format_folder_name(a) == format_folder_name(b)) == (a == b)
