// Pages that only show figures: draw them in the colors of the page, and again if the colors change.
const ON_PAPER = 700; // Width in print [px of 1/96 inch], at which letters have the size of the text.

/** Return the height in print [px of 1/96 inch], with which two figures of usual height fit on a page. */
const printedHeight = (layout) => Math.round(0.75 * (layout.height || 540));

const plots = Array.from(document.querySelectorAll(".plotly-graph-div"));
for (const plot of plots) {
  plot.given = structuredClone({ data: plot.data, layout: plot.layout });
  plot.active = 0; // index of the pressed button
  describe(plot, plot.given);
  if (!plot.layout.updatemenus) continue;
  const bar = document.createElement("div");
  bar.className = "buttons screen-only";
  buildButtons(bar, plot.given, (i) => {
    plot.active = i;
    show();
  });
  plot.parentNode.before(bar);
}

function recolor() {
  return plots.map((plot) => {
    const { data, layout } = applyButton(plot.given, plot.active);
    const shown = themed(layout, !isPrinted() && plot.clientWidth < NARROW);
    if (isPrinted()) {
      Object.assign(shown, { width: ON_PAPER, height: printedHeight(layout), font: { ...shown.font, size: 11 } });
      for (const note of shown.annotations || []) note.font.size = 11;
    }
    return Plotly.react(plot, recolored(data), shown);
  });
}

async function show() {
  await Promise.all(recolor());
  plots.forEach((plot) => scalable(plot));
  document.body.dataset.shown = "all";
}
const folds = document.querySelectorAll("details");
for (const details of folds) details.addEventListener("toggle", show); // Closed figures have no width.
addEventListener("beforeprint", () => {
  for (const details of folds) details.open = true;
  document.documentElement.classList.add("printed");
  recolor();
  for (const plot of plots) scalable(plot, [ON_PAPER, printedHeight(plot.given.layout)]);
});
addEventListener("afterprint", () => {
  document.documentElement.classList.remove("printed");
  show();
});
dark.addEventListener("change", show);
show();
