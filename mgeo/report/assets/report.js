const data = JSON.parse(document.getElementById("data").textContent);
let chosen = null;
let button = 0; // of the front's, that is pressed

// Front --------------------------------------------------------------------------------------

/** The trace and position of a solution on the front. */
function located(traces, row) {
  for (const trace of traces) {
    const index = (trace.customdata || []).indexOf(row);
    if (index >= 0) return { trace, index };
  }
  return null;
}

/** Move the title above the figure, where lines break and the buttons cover nothing. */
function entitle(layout) {
  const text = (layout.title || {}).text || "";
  delete layout.title;
  const lines = text.split(/<br *\/?>/).map((line) => {
    return new DOMParser().parseFromString(line, "text/html").body.textContent.trim();
  });
  byId("heading").textContent = lines[0] === document.title ? "" : lines[0]; // said already
  byId("subtitle").textContent = lines.slice(1).join(" ");
  const { t = 100 } = layout.margin || {};
  if (text) layout.margin = { ...layout.margin, t: Math.max(t - 45, 50) }; // room for the buttons
}

function drawFront() {
  if (!data.front) {
    byId("front").textContent = "More than three objectives: choose from the list or the table.";
    return;
  }
  const front = pressed(data.front, button);
  const found = located(front.data, chosen);
  const mark = [];
  if (found) {
    const { trace, index } = found;
    const ring = { symbol: "circle-open", size: 18, line: { width: 3 } };
    ring.color = color("accent");
    const point = { type: trace.type, mode: "markers", marker: ring, hoverinfo: "skip" };
    for (const key of ["x", "y", "z"]) if (trace[key]) point[key] = [trace[key][index]];
    for (const key of ["xaxis", "yaxis", "scene"]) if (trace[key]) point[key] = trace[key];
    mark.push({ ...point, showlegend: false });
  }
  const node = byId("front");
  const narrow = node.clientWidth < 500;
  const layout = front.layout;
  layout.height = narrow ? 420 : 560;
  layout.uirevision = "front"; // a click does not undo a zoom
  layout.clickmode = "event";
  entitle(layout);
  if (layout.scene) layout.margin = { l: 0, r: 0, t: 50, b: 0 };
  if (narrow) {
    if (!layout.scene) layout.margin = { ...layout.margin, l: 60, r: 10, t: layout.xaxis2 ? 95 : 50 }; // room for an upper axis
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
      setTimeout(drawFront); // plotly itself knows nothing of the mark
    });
  });
}

// One solution -------------------------------------------------------------------------------

function fillDescribed(row) {
  const body = byId("described");
  body.replaceChildren();
  const values = data.described.rows[row];
  const names = values ? data.described.columns : [];
  names.forEach((name, j) => {
    const line = body.insertRow();
    cell(line, "th", name).scope = "row";
    cell(line, "td", shown(values[j]));
  });
}

function fillLimits(row) {
  const body = byId("limits");
  body.replaceChildren();
  const known = data.limits[row] || [];
  byId("limited").hidden = known.length === 0;
  for (const [name, kept, text] of known) {
    const line = body.insertRow();
    cell(line, "th", name).scope = "row";
    const node = cell(line, "td", "");
    for (const part of text.split(/(\S*e-\d+)/)) { // no line ends at the hyphen of a number
      const span = node.appendChild(document.createElement("span"));
      span.textContent = part;
      if (/e-\d+$/.test(part)) span.className = "number";
    }
    if (!kept) node.className = "exceeded";
  }
}

function fillVariables(row) {
  const body = byId("variables");
  body.replaceChildren();
  const [low, high] = data.bounds;
  low.forEach((least, j) => {
    const line = body.insertRow();
    const value = data.table.rows[row][j];
    cell(line, "th", data.table.columns[j]).scope = "row";
    const node = cell(line, "td", `${shown(value)} within ${shown(least)} to ${shown(high[j])} `);
    const meter = node.appendChild(document.createElement("meter"));
    Object.assign(meter, { min: least, max: high[j], value });
  });
}

function drawFigures(row) {
  const values = data.plans.values[row];
  const none = values === undefined;
  byId("unplanned").hidden = data.planned.includes(row);
  const figures = none ? {} : filled(data.plans.common, values);
  return drawGrid(byId("figures"), figures);
}

async function choose(row) {
  if (!(row in data.table.rows)) return;
  chosen = row;
  const label = data.labels[row];
  byId("chosen").textContent = `Solution ${row}` + (label ? ` (${label})` : "");
  byId("answer").textContent = data.answers[row] || "";
  byId("solution").value = String(row);
  history.replaceState(null, "", `#solution=${row}`);
  for (const card of document.querySelectorAll("[data-row]")) {
    card.classList.toggle("chosen", Number(card.dataset.row) === row);
  }
  fillDescribed(row);
  fillLimits(row);
  fillVariables(row);
  await Promise.all([drawFront(), drawFigures(row)]);
  document.body.dataset.shown = String(chosen);
}

const step = (by) => choose(Math.min(Math.max(chosen + by, 0), data.table.rows.length - 1));

// Table --------------------------------------------------------------------------------------

const MOST_ROWS = 1000;
let order = null;
let shownColumns = [];
let sorted = { column: null, sign: 1 };

function fillTable() {
  const body = byId("table").tBodies[0];
  body.replaceChildren();
  for (const row of order.slice(0, MOST_ROWS)) {
    const line = body.insertRow();
    line.dataset.row = row;
    line.classList.toggle("chosen", row === chosen);
    cell(line, "td", String(row));
    for (const { value } of shownColumns) cell(line, "td", Number.isNaN(value(row)) ? "" : shown(value(row)));
  }
  const rest = order.length > MOST_ROWS ? `, of which ${MOST_ROWS} are shown` : "";
  byId("shown").textContent = `${order.length} solutions${rest}; click on a heading to sort`;
}

/** Objectives, then what else the problem says in numbers, then variables: names, and values of a row. */
function columns() {
  const { columns: names, rows } = data.table;
  const first = names.length - data.objectives;
  const own = names.map((name, j) => ({ name, value: (row) => rows[row][j] }));
  const told = data.described;
  const numeric = (j) => Object.values(told.rows).every((values) => typeof values[j] === "number");
  const more = told.columns
    .map((name, j) => ({ name, j, value: (row) => (told.rows[row] ? told.rows[row][j] : NaN) }))
    .filter(({ name, j }) => !names.includes(name) && numeric(j));
  return [...own.slice(first), ...more, ...own.slice(0, first)];
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
  shownColumns = columns();
  for (const column of [{ name: "solution", value: (row) => row }, ...shownColumns]) {
    const heading = cell(head, "th", column.name);
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
  if (data.table) return choose(chosen);
}

function asked() {
  const match = /^#solution=(\d+)$/.exec(location.hash);
  return match && Number(match[1]) in data.table.rows ? Number(match[1]) : data.first;
}

if (data.table) {
  const select = byId("solution");
  data.planned.forEach((row) => {
    const label = data.labels[row];
    select.add(new Option(String(row) + (label ? ` (${label})` : ""), String(row)));
  });
  byId("thinned").hidden = Object.keys(data.plans.common).length === 0;
  select.addEventListener("change", () => choose(Number(select.value)));
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  byId("download").addEventListener("click", download);
  addEventListener("hashchange", () => choose(asked()));
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
  chosen = asked();
}
function printed(on) {
  document.documentElement.classList.toggle("printed", on);
  redraw();
}
addEventListener("beforeprint", () => printed(true));
addEventListener("afterprint", () => printed(false));
dark.addEventListener("change", redraw);
redraw();
