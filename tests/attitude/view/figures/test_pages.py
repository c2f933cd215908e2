"""Pages in a browser, wide, on a phone, on paper: what covers nothing, titles that break."""

import dataclasses

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.commands.show import write_figures
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.scenario import ManeuverLimits

from mgeo.figures.page import page

from ....browser import opened

pytestmark = pytest.mark.slow

# labels under a legend, and what is wider than the window
_COVERED = """[...document.querySelectorAll(".js-plotly-plot")].flatMap((plot) => {
  const box = (node) => node.getBoundingClientRect();
  const parts = ".xtick, .x2tick, .ytick, .g-xtitle, .g-x2title, .g-ytitle, .point";
  return [...plot.querySelectorAll(".legend > .bg")].flatMap((legend) =>
    [...plot.querySelectorAll(parts)].filter((part) => !part.closest(".legend")).filter((part) => {
      const [a, b] = [box(legend), box(part)];
      const across = a.left < b.right && b.left < a.right;
      return b.width && across && a.top < b.bottom && b.top < a.bottom;
    }).map((part) => part.outerHTML.slice(0, 120)));
})"""
# on paper a figure that is larger than its place lies on what follows
_BEYOND = """[...document.querySelectorAll(".plotly-graph-div")].filter((plot) =>
  plot.offsetHeight > plot.parentElement.offsetHeight + 1).map((plot) => plot.id)"""
_WIDE = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.fixture(scope="module")
def pages(tmp_path_factory, problem, X):
    """A front, and a plan whose phases have long names."""
    folder = tmp_path_factory.mktemp("pages")
    front = folder / "front.html"
    front.write_text(page(problem.view(X).figures()["front"], "front"), encoding="utf-8")
    ramps = ManeuverLimits(max_acceleration_deg_s2=0.02)
    scenario = dataclasses.replace(Scenario.paper(), duration=1500.0, maneuvers=ramps)
    design = [0.5, -1.0, 0.25, 200.0, -0.1, 0.75, 1.0, 150.0, 0.3, -0.5, 0.9, 80.0]
    plan = folder / "plan.html"
    write_figures(ManeuverPlan.from_design(AttitudeManeuverProblem(scenario), design), plan)
    return {"front": front, "plan": plan}


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("name", ["front", "plan"])
@pytest.mark.parametrize("width", [1280, 400])
def test_legends_cover_no_labels(pages, name, width):
    with opened(pages[name], width) as tab:
        assert tab.evaluate("document.querySelectorAll('.legend > .bg').length > 0")
        found = tab.evaluate(_COVERED), tab.evaluate(_WIDE)
        tab.print()
        assert found == ([], 0)
        assert tab.evaluate(_BEYOND) == []
        assert tab.errors() == []
