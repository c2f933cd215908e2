// Pages that only show figures: in the colors of the page, again when these change
const plots = Array.from(document.querySelectorAll(".plotly-graph-div"));
for (const plot of plots) plot.given = structuredClone({ data: plot.data, layout: plot.layout });

function recolor() {
  return plots.map((plot) => {
    const { data, layout } = plot.given;
    return Plotly.react(plot, recolored(data), themed(layout, plot.clientWidth < NARROW));
  });
}

async function show() {
  await Promise.all(recolor());
  await Promise.all(plots.map(fit));
  plots.forEach(scalable);
  document.body.dataset.shown = "all";
}
addEventListener("beforeprint", () => {
  document.documentElement.classList.add("printed");
  recolor();
  plots.forEach(scalable);
});
addEventListener("afterprint", () => {
  document.documentElement.classList.remove("printed");
  show();
});
dark.addEventListener("change", show);
show();
