
// The front: two quantities against one another ----------------------------------------------------

/** Draw solutions within all ranges, the others faintly, the chosen one and the changed design. */
function drawScatter(state, told) {
  const node = byId("front");
  const [x, y] = ["across", "up"].map((id) => state.columns[Number(byId(id).value)]);
  const rows = [[], []];
  for (let row = 0; row < state.n; row++) rows[state.passes(row) ? 1 : 0].push(row);
  const trace = (name, places, marker) => ({
    type: "scatter", mode: "markers", name, marker, customdata: places,
    x: places.map((row) => x.values[row]), y: places.map((row) => y.values[row]),
    text: places.map((row) => `solution ${state.numbers[row]}`),
    hovertemplate: "%{text}<br>%{x:.5g}, %{y:.5g}<extra></extra>",
  });
  const one = (name, at, marker) => ({
    type: "scatter", mode: "markers", name, marker, x: [at[0]], y: [at[1]], hoverinfo: "skip",
  });
  const data = [
    trace("left out", rows[0], { color: color("shade"), size: 6, opacity: 0.3 }),
    trace("kept", rows[1], { color: color("accent"), size: 8, opacity: 0.85 }),
  ];
  const { chosen, changed } = state;
  if (chosen !== null) {
    const ring = { symbol: "circle-open", size: 17, color: color("ink"), line: { width: 3 } };
    data.push(one("chosen", [x.values[chosen], y.values[chosen]], ring));
  }
  if (changed && changed.values) {
    const mark = { symbol: "diamond", size: 13, color: color("bad") };
    data.push(one("changed", [changed.values(x), changed.values(y)], mark));
  }
  const axis = (column) => ({
    title: { text: column.name.replaceAll("<", "<\u200b") },
    type: column.log ? "log" : "linear", showline: true, zeroline: false, ticks: "outside",
    exponentformat: "power",
    ...(column.log && column.extent[1] < 1e3 * column.extent[0] ? { dtick: "D2" } : {}),
  });
  const layout = {
    xaxis: axis(x), yaxis: axis(y), height: node.clientWidth < NARROW ? 380 : 470,
    margin: { l: 70, r: 15, t: 15, b: 55 }, showlegend: false, clickmode: "event", hovermode: "closest",
    uirevision: `${x.name} ${y.name}`, font: { size: 13 },
  };
  return draw(node, { data, layout }, false).then(() => {
    node.removeAllListeners("plotly_click");
    node.on("plotly_click", (event) => {
      const row = event.points.map((point) => point.customdata).find(Number.isInteger);
      if (row !== undefined) told.chosen(row);
    });
  });
}
