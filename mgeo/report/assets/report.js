const data = JSON.parse(document.getElementById("data").textContent);
let selected = null; // row of the selected solution
let button = 0; // index of the pressed button of the front

// Front --------------------------------------------------------------------------------------

/** Return the trace of a solution on the front, and the index of its point. */
function findPoint(traces, row) {
  for (const trace of traces) {
    const index = (trace.customdata || []).indexOf(row);
    if (index >= 0) return { trace, index };
  }
  return null;
}

/** Move the title above the figure, so that its lines can break and no button covers them. */
function moveTitle(layout) {
  const text = (layout.title || {}).text || "";
  delete layout.title;
  const lines = text.split(/<br *\/?>/).map((line) => {
    return new DOMParser().parseFromString(line, "text/html").body.textContent.trim();
  });
  byId("heading").textContent = lines[0] === document.title ? "" : lines[0]; // It repeats the title of the page.
  byId("subtitle").textContent = lines.slice(1).join(" ");
  const { t = 100 } = layout.margin || {};
  if (text) layout.margin = { ...layout.margin, t: Math.max(t - 45, 50) }; // The buttons need room.
}

function drawFront() {
  if (!data.front) {
    byId("front").textContent = "The front has more than three objectives. Select a solution in the list or the table.";
    return;
  }
  const front = applyButton(data.front, button);
  const point = findPoint(front.data, selected);
  const mark = [];
  if (point) {
    const { trace, index } = point;
    const ring = { symbol: "circle-open", size: 18, line: { width: 3 } };
    ring.color = color("accent");
    const marker = { type: trace.type, mode: "markers", marker: ring, hoverinfo: "skip" };
    for (const key of ["x", "y", "z"]) if (trace[key]) marker[key] = [trace[key][index]];
    for (const key of ["xaxis", "yaxis", "scene"]) if (trace[key]) marker[key] = trace[key];
    mark.push({ ...marker, showlegend: false });
  }
  const node = byId("front");
  const narrow = node.clientWidth < 500;
  const layout = front.layout;
  layout.height = narrow ? 420 : 560;
  layout.uirevision = "front"; // A click preserves the zoom.
  layout.clickmode = "event";
  moveTitle(layout);
  if (layout.scene) layout.margin = { l: 0, r: 0, t: 50, b: 0 };
  if (narrow) {
    if (!layout.scene) layout.margin = { ...layout.margin, l: 60, r: 10, t: layout.xaxis2 ? 95 : 50 }; // An upper axis needs room.
    const below = { orientation: "h", x: 0, xanchor: "left", y: -0.25, yref: "paper", yanchor: "top" };
    layout.legend = { ...layout.legend, ...below };
  }
  return draw(node, { data: [...front.data, ...mark], layout }).then(() => {
    node.removeAllListeners("plotly_click");
    node.on("plotly_click", (event) => {
      const row = event.points.map((point) => point.customdata).find(Number.isInteger);
      if (row !== undefined) choose(row);
    });
    node.removeAllListeners("plotly_buttonclicked");
    node.on("plotly_buttonclicked", (event) => {
      button = event.active;
      setTimeout(drawFront); // Plotly redraws the front without the mark.
    });
  });
}

// One solution -------------------------------------------------------------------------------

function fillDescription(row) {
  const body = byId("descriptions");
  body.replaceChildren();
  const values = data.descriptions.rows[row];
  const names = values ? data.descriptions.columns : [];
  names.forEach((name, j) => {
    const line = body.insertRow();
    addCell(line, "th", name).scope = "row";
    addCell(line, "td", formatValue(values[j]));
  });
}

function fillConstraints(row) {
  const body = byId("constraints");
  body.replaceChildren();
  const margins = data.constraints[row] || [];
  byId("margins").hidden = margins.length === 0;
  for (const [name, isSatisfied, text] of margins) {
    const line = body.insertRow();
    addCell(line, "th", name).scope = "row";
    const node = addCell(line, "td", "");
    for (const part of text.split(/(\S*e-\d+)/)) { // Lines must not break at the hyphen of a number.
      const span = node.appendChild(document.createElement("span"));
      span.textContent = part;
      if (/e-\d+$/.test(part)) span.className = "number";
    }
    if (!isSatisfied) node.className = "exceeded";
  }
}

function fillVariables(row) {
  const body = byId("variables");
  body.replaceChildren();
  const [low, high] = data.bounds;
  low.forEach((least, j) => {
    const line = body.insertRow();
    const value = data.table.rows[row][j];
    addCell(line, "th", data.table.columns[j]).scope = "row";
    const node = addCell(line, "td", `${formatValue(value)} within ${formatValue(least)} to ${formatValue(high[j])} `);
    const meter = node.appendChild(document.createElement("meter"));
    Object.assign(meter, { min: least, max: high[j], value });
  });
}

function drawFigures(row) {
  const values = data.figures.values[row];
  byId("no-figures").hidden = data.figure_rows.includes(row);
  const figures = values === undefined ? {} : fillPlaceholders(data.figures.common, values);
  return drawGrid(byId("figures"), figures);
}

async function choose(row) {
  if (!(row in data.table.rows)) return;
  selected = row;
  const label = data.labels[row];
  byId("selected").textContent = `Solution ${row}` + (label ? ` (${label})` : "");
  byId("summary").textContent = data.summaries[row] || "";
  byId("solution").value = String(row);
  history.replaceState(null, "", `#solution=${row}`);
  for (const card of document.querySelectorAll("[data-row]")) {
    card.classList.toggle("selected", Number(card.dataset.row) === row);
  }
  fillDescription(row);
  fillConstraints(row);
  fillVariables(row);
  await Promise.all([drawFront(), drawFigures(row)]);
  document.body.dataset.shown = String(selected);
}

const step = (by) => choose(Math.min(Math.max(selected + by, 0), data.table.rows.length - 1));

// Table --------------------------------------------------------------------------------------

const MAX_ROWS = 1000;
let order = null; // rows in the order of the table
let shownColumns = [];
let sorted = { column: null, sign: 1 };

function fillTable() {
  const body = byId("table").tBodies[0];
  body.replaceChildren();
  for (const row of order.slice(0, MAX_ROWS)) {
    const line = body.insertRow();
    line.dataset.row = row;
    line.classList.toggle("selected", row === selected);
    addCell(line, "td", String(row));
    for (const { value } of shownColumns) addCell(line, "td", Number.isNaN(value(row)) ? "" : formatValue(value(row)));
  }
  const rest = order.length > MAX_ROWS ? `, of which ${MAX_ROWS} are shown` : "";
  byId("shown").textContent = `${order.length} solutions${rest}; click on a heading to sort`;
}

/**
 * Return the columns of the table: objectives, other numeric descriptions by the problem, and
 * variables. A column has a name, and a function from a row to its value.
 */
function listColumns() {
  const { columns: names, rows } = data.table;
  const first = names.length - data.objectives;
  const columns = names.map((name, j) => ({ name, value: (row) => rows[row][j] }));
  const descriptions = data.descriptions;
  const isNumeric = (j) => Object.values(descriptions.rows).every((values) => typeof values[j] === "number");
  const others = descriptions.columns
    .map((name, j) => ({ name, j, value: (row) => (descriptions.rows[row] ? descriptions.rows[row][j] : NaN) }))
    .filter(({ name, j }) => !names.includes(name) && isNumeric(j));
  return [...columns.slice(first), ...others, ...columns.slice(0, first)];
}

function sortBy(column, heading) {
  sorted = { column, sign: sorted.column === column ? -sorted.sign : 1 };
  const last = (value) => (Number.isNaN(value) ? sorted.sign * Infinity : value);
  const key = (row) => last(column.value(row));
  order.sort((a, b) => (key(a) === key(b) ? a - b : sorted.sign * (key(a) - key(b))));
  for (const other of heading.parentNode.cells) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", sorted.sign > 0 ? "ascending" : "descending");
  fillTable();
}

function makeTable() {
  order = data.table.rows.map((_, row) => row);
  const head = byId("table").tHead.insertRow();
  shownColumns = listColumns();
  for (const column of [{ name: "solution", value: (row) => row }, ...shownColumns]) {
    const heading = addCell(head, "th", column.name);
    heading.tabIndex = 0;
    heading.addEventListener("click", () => sortBy(column, heading));
    heading.addEventListener("keydown", (event) => event.key === "Enter" && sortBy(column, heading));
  }
  fillTable();
}

function download() {
  const quoted = (text) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const lines = [data.table.columns.map(quoted), ...order.map((row) => data.table.rows[row])];
  const text = lines.map((line) => line.join(",") + "\n").join("");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = "front.csv";
  link.click();
  URL.revokeObjectURL(link.href);
}

// Start --------------------------------------------------------------------------------------

function redraw() {
  if (data.history) draw(byId("history"), data.history);
  if (data.table) return choose(selected);
}

/** Return the row in the address of the page, or the default row. */
function readHash() {
  const match = /^#solution=(\d+)$/.exec(location.hash);
  return match && Number(match[1]) in data.table.rows ? Number(match[1]) : data.first;
}

if (data.table) {
  const select = byId("solution");
  data.figure_rows.forEach((row) => {
    const label = data.labels[row];
    select.add(new Option(String(row) + (label ? ` (${label})` : ""), String(row)));
  });
  byId("thinned").hidden = Object.keys(data.figures.common).length === 0;
  select.addEventListener("change", () => choose(Number(select.value)));
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  byId("download").addEventListener("click", download);
  addEventListener("hashchange", () => choose(readHash()));
  addEventListener("keydown", (event) => {
    if (event.target.closest("input, select, textarea") || event.altKey || event.ctrlKey) return;
    if (event.key === "ArrowLeft") step(-1);
    if (event.key === "ArrowRight") step(1);
  });
  document.addEventListener("click", (event) => {
    const target = event.target.closest && event.target.closest("[data-row]");
    if (target) choose(Number(target.dataset.row));
  });
  makeTable();
  selected = readHash();
}
function setPrinted(on) {
  document.documentElement.classList.toggle("printed", on);
  redraw();
}
addEventListener("beforeprint", () => setPrinted(true));
addEventListener("afterprint", () => setPrinted(false));
dark.addEventListener("change", redraw);
redraw();
