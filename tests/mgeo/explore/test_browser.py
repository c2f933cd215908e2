"""Page of the explorer in headless Chromium: filter, select, modify and save solutions."""

import json

import numpy as np
import pytest
from selenium.webdriver import ActionChains, Keys

from mgeo.store.run_folder import read_run

from ...browser import opened
from .test_server import served

pytestmark = pytest.mark.slow

READY = "document.querySelector('#numbers td') && document.querySelector('#front .point')"


@pytest.fixture
def page(folder):
    with served(folder) as url, opened(url, 1400) as page:
        page.until(READY)
        yield page


def count_solutions(page):
    return int(page.evaluate("document.querySelector('#count').textContent").split()[0])


def drag(page, node, *offsets):
    """Press the mouse at the lower end of a node, move it by each offset [px], and release it."""
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", node)
    bottom = page.driver.execute_script("return arguments[0].getBoundingClientRect().height", node)
    actions = ActionChains(page.driver).move_to_element_with_offset(node, 0, int(bottom / 2) - 5)
    actions.click_and_hold()
    for offset in offsets:
        actions.move_by_offset(0, offset)
    actions.release().perform()


def test_range_on_an_axis_filters_front_and_table(page, folder):
    n = len(read_run(folder).outcome.F)
    assert count_solutions(page) == n
    axis = page.driver.find_element("css selector", "#parallel .axis-brush .background")
    drag(page, axis, -40, -100)
    page.until(f"!document.querySelector('#count').textContent.startsWith('{n} ')")
    n_visible = count_solutions(page)
    assert 0 < n_visible < n
    assert page.evaluate("document.querySelectorAll('#table tbody tr').length") == n_visible
    traces = "document.querySelector('#front .js-plotly-plot').data"
    page.until(f"{traces}[1].customdata.length === {n_visible}")
    drag(page, axis)  # A click removes the range.
    page.until(f"document.querySelector('#count').textContent.startsWith('{n} ')")
    assert page.errors() == []


def test_click_selects_a_solution_and_slider_changes_its_metrics(page, folder):
    outcome = read_run(folder).outcome
    points = page.driver.find_elements("css selector", "#front .point")
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", points[0])
    ActionChains(page.driver).move_to_element(points[0]).pause(0.3).click().perform()
    selected = "document.querySelector('#selected').textContent"
    page.until(f"{selected}.includes('solution 0')")
    mass = "document.querySelectorAll('#numbers tbody tr')[0].textContent"
    page.until(f"{mass}.includes('{outcome.F[0, 0]:.5g}')")
    assert "violated" not in page.evaluate("document.querySelector('#constraints').innerHTML")
    slider = page.driver.find_elements("css selector", "[role=slider]")[1]
    slider.send_keys(Keys.END)  # The beam has its maximum length.
    weight = 7800.0 * np.pi / 4 * outcome.X[0, 0] ** 2
    page.until(f"{mass}.includes('{weight:.5g}')")
    page.until("document.querySelector('#constraints .violated') !== null")
    assert "1 m, at most 0.5 m" in page.evaluate("document.querySelector('.violated').textContent")


def test_design_is_saved_once(page, folder):
    button = page.driver.find_element("id", "save")
    for element in ("saved", "message"):
        button.click()
        page.until(f"document.querySelector('#{element}').textContent.includes('plan.json')")
    document = json.loads((folder / "plan.json").read_text())
    assert document["design"] in read_run(folder).outcome.X.tolist()


@pytest.mark.parametrize("width", [390, 1400])
def test_page_fits_the_window(folder, width):
    with served(folder) as url, opened(url, width) as page:
        page.until(READY)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
