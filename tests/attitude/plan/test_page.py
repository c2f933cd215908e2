"""Page of a plan in a browser: closed details on screen, everything in print."""

import pytest
from mgeo_attitude.plan.figures import build_plan_figures
from mgeo_attitude.plan.tables import build_review, build_sections

from mgeo.report.review_page import render_review_page

from ...browser import opened


@pytest.fixture(scope="module")
def path(plan, tmp_path_factory):
    path = tmp_path_factory.mktemp("pages") / "plan.html"
    html = render_review_page(build_review(plan), build_plan_figures(plan))
    path.write_text(html, encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1400])
def test_page_on_screen_and_in_print(plan, path, width):
    sections = build_sections(plan)
    with opened(path, width) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        headings = page.evaluate("[...document.querySelectorAll('h2, h3')].map(h => h.textContent)")
        assert [title for title in headings if title in {s.title for s in sections}] == [
            section.title for section in sections
        ]
        heads = page.evaluate("[...document.querySelectorAll('th')].every(th => th.scope)")
        assert heads
        n_details = sum(section.is_detail for section in sections)
        assert page.evaluate("document.querySelectorAll('details:not([open])').length") == n_details
        page.print()
        assert page.evaluate("document.querySelectorAll('details[open]').length") == n_details
        page.until("[...document.querySelectorAll('.main-svg')].every(svg => svg.clientWidth > 0)")
        assert page.errors() == []
