import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.studies.comparison_files import format_folder_names

SIMILAR_LABELS = ["a b", "a-b", "a.b", "a  b", "A b", "a b ", "a/b", "a, b", "a_b", "ab", "a\nb"]


def test_folder_names_have_a_hash_only_where_names_are_equal():
    labels = ["Cantilever beam", "dtlz2, n_obj = 3", "σ = 0.5"]
    assert list(format_folder_names(labels).values()) == [
        "cantilever-beam",
        "dtlz2-n_obj-3",
        "0-5",
    ]
    names = format_folder_names([*labels, "τ = 0.5", "runs"])
    assert names["Cantilever beam"] == "cantilever-beam"
    assert names["σ = 0.5"].startswith("0-5-")
    assert names["runs"].startswith("runs-")  # The name runs is reserved.


def test_similar_labels_have_different_folder_names():
    names = set(format_folder_names(SIMILAR_LABELS).values())
    assert len(names) == len(SIMILAR_LABELS)


@pytest.mark.slow
@given(st.sets(st.text(), min_size=1))
def test_folder_names_are_valid_and_unique(labels):
    names = format_folder_names(labels)
    assert len(set(names.values())) == len(labels)
    assert all(re.fullmatch("[a-z0-9_-]{1,70}", name) for name in names.values())
