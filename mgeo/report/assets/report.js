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

/** Show the title above the figure, where its lines can break. */
function moveTitle(layout) {
  const text = (layout.title || {}).text || "";
  const lines = text.split(/<br *\/?>/).map((line) => {
    return new DOMParser().parseFromString(line, "text/html").body.textContent.trim();
  });
  byId("heading").textContent = lines[0] === document.title ? "" : lines[0]; // It repeats the title of the page.
  byId("subtitle").textContent = lines.slice(1).join(" ");
  layout.title = {};
  layout.margin = { ...layout.margin, t: isPrinted() ? 15 : 30 };
}

function drawFront() {
  if (!data.front) {
    byId("front").textContent = "The front has more than three objectives. Select a solution in the list or the table.";
    return;
  }
  const { data: traces, layout } = applyButton(data.front, button);
  const point = findPoint(traces, selected);
  if (point) {
    const { trace, index } = point;
    const ring = { symbol: "circle-open", size: 20, color: color("accent"), line: { width: 3 } };
    const mark = { type: trace.type, mode: "markers", marker: ring, hoverinfo: "skip", showlegend: false };
    for (const key of ["x", "y", "z"]) if (trace[key]) mark[key] = [trace[key][index]];
    traces.push(mark);
  }
  const node = byId("front");
  const height = isPrinted() ? 290 : node.clientWidth < NARROW ? 400 : 520;
  Object.assign(layout, { height, uirevision: button, clickmode: "event" });
  moveTitle(layout);
  node.dataset.name = byId("heading").textContent;
  if (layout.scene) layout.margin = { l: 0, r: 0, t: 0, b: 0 };
  return draw(node, { data: traces, layout }).then(() => {
    node.removeAllListeners("plotly_click");
    node.on("plotly_click", (event) => {
      const row = event.points.map((point) => point.customdata).find(Number.isInteger);
      if (row !== undefined) choose(row);
    });
  });
}

// One solution -------------------------------------------------------------------------------

function fillFacts(id, rows) {
  const body = byId(id);
  body.replaceChildren();
  for (const [name, text] of rows) {
    const line = body.insertRow();
    addCell(line, "th", name, "row");
    addCell(line, "td", text);
  }
  return body;
}

function fillDescription(row) {
  const values = data.descriptions.rows[row];
  const names = values ? data.descriptions.columns : [];
  fillFacts("descriptions", names.map((name, j) => [name, formatValue(values[j])]));
}

function fillConstraints(row) {
  const margins = data.constraints[row] || [];
  byId("margins").hidden = margins.length === 0;
  const body = fillFacts("constraints", margins.map(([name, , text]) => [name, text]));
  margins.forEach(([, isSatisfied], i) => body.rows[i].cells[1].classList.toggle("exceeded", !isSatisfied));
}

function fillVariables(row) {
  const [low, high] = data.bounds;
  const values = data.table.rows[row];
  const format = (j) => `${formatValue(values[j])} within ${formatValue(low[j])} to ${formatValue(high[j])}`;
  fillFacts("variables", low.map((_, j) => [data.table.columns[j], format(j)]));
}

function drawFigures(row) {
  const values = data.figures.values[row];
  byId("no-figures").hidden = data.figure_rows.includes(row);
  const figures = values === undefined ? {} : fillPlaceholders(data.figures.common, values);
  return drawGrid(byId("figures"), figures);
}

/** Return the number of a solution with its label, such as "12 (knee)". */
function nameSolution(row) {
  const label = data.labels[row];
  return String(row) + (label ? ` (${label})` : "");
}

async function choose(row) {
  if (!(row in data.table.rows)) return;
  selected = row;
  byId("selected").textContent = nameSolution(row);
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
  const described = data.figure_rows.length;
  const blank = described < order.length ? `; metrics other than the objectives are computed for ${described} of them` : "";
  byId("shown").textContent = `${order.length} rows${rest}${blank}; click on a heading to sort`;
}

/**
 * Return the columns of the table: objectives, other numeric descriptions by the problem, and
 * variables. A column has a name, and a function from a row to its value.
 */
function listColumns() {
  const names = data.titles;
  const { rows } = data.table;
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
  for (const column of [{ name: data.noun, value: (row) => row }, ...shownColumns]) {
    const heading = addCell(head, "th", "", "col");
    const sort = heading.appendChild(document.createElement("button"));
    Object.assign(sort, { type: "button", textContent: column.name });
    sort.addEventListener("click", () => sortBy(column, heading));
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
    select.add(new Option(nameSolution(row), String(row)));
  });
  byId("thinned").hidden = Object.keys(data.figures.common).length === 0;
  select.addEventListener("change", () => choose(Number(select.value)));
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  if (data.front) {
    buildButtons(byId("buttons"), data.front, (i) => {
      button = i;
      drawFront();
    });
  }
  byId("download").addEventListener("click", download);
  addEventListener("hashchange", () => choose(readHash()));
  addEventListener("keydown", (event) => {
    if (event.target.closest("input, select, .wide") || event.altKey || event.ctrlKey) return; // They use the keys.
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
const closed = [...document.querySelectorAll("details")];
function setPrinted(on) {
  document.documentElement.classList.toggle("printed", on);
  for (const details of closed) details.open = on;
  redraw();
}
addEventListener("beforeprint", () => setPrinted(true));
addEventListener("afterprint", () => setPrinted(false));
dark.addEventListener("change", redraw);
redraw();
