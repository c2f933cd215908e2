
// The page: what is asked of the server, and what follows ---------------------------------------

const IDLE = 350; // ms after a change until what takes longer is asked for
const LONG = 1000; // and what takes long
const CHUNK = 20; // solutions whose limits are asked for at a time

async function ask(name, body = {}) {
  let answer;
  try {
    const headers = { "Content-Type": "application/json" };
    answer = await fetch(`api/${name}`, { method: "POST", headers, body: JSON.stringify(body) });
  } catch {
    throw new Error("mgeo explore has ended: start it again, and open the address that it prints");
  }
  const found = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(found.error), { status: answer.status });
  return found;
}

function tell(error) {
  byId("error").hidden = !error;
  byId("error").textContent = error ? error.message : "";
}

const state = { columns: [], n: 0, numbers: [], designs: [], limits: [], chosen: null, changed: null };
state.passes = (row) => state.passing[row];
let parallel = null;
let fillEditor = null;

// Which solutions ----------------------------------------------------------------------------

/** The least and greatest value of a column, null of one that says nothing. */
function measured(column) {
  const known = column.values.filter((value) => value !== null && value !== undefined);
  column.extent = known.length ? [Math.min(...known), Math.max(...known)] : null;
  if (column.extent && column.log && column.extent[0] <= 0) column.log = false;
  if (column.axis === undefined) {
    const differs = column.extent && column.extent[1] > column.extent[0];
    column.axis = Boolean(differs && column.kind !== "variable");
  }
  return column;
}

function filter() {
  const ranges = state.columns.filter((column) => column.range);
  state.passing = Array.from({ length: state.n }, (_, row) =>
    ranges.every(({ values, range: [low, high] }) => {
      const value = values[row];
      return value !== null && value !== undefined && value >= low && value <= high;
    }),
  );
  const kept = state.passing.filter(Boolean).length;
  byId("count").textContent = `${kept} of ${state.n} solutions are within ${ranges.length === 1 ? "the range" : "all ranges"}`;
  if (!ranges.length) byId("count").textContent = `${state.n} solutions${state.nearest ? ", none of which keeps all limits" : ""}`;
  byId("clear").disabled = !ranges.length;
  document.body.dataset.kept = kept;
}

function filtered() {
  filter();
  fillRanges();
  parallel.draw();
  drawScatter(state, told);
}

/** Axes as a table: which are drawn, and the ranges as numbers, for keyboards and to the digit. */
function makeRanges() {
  const body = byId("ranges");
  body.replaceChildren();
  for (const column of state.columns) {
    if (!column.extent) continue;
    const row = body.insertRow();
    const label = cell(row, "td", "").appendChild(document.createElement("label"));
    const box = label.appendChild(document.createElement("input"));
    Object.assign(box, { type: "checkbox", checked: column.axis });
    label.append(` ${column.name}`);
    box.addEventListener("change", () => {
      column.axis = box.checked;
      parallel.layout();
    });
    column.inputs = [0, 1].map((end) => {
      const input = cell(row, "td", "").appendChild(document.createElement("input"));
      Object.assign(input, { type: "number", step: "any", placeholder: brief(column.extent[end]) });
      input.setAttribute("aria-label", `${column.name}, ${end ? "at most" : "at least"}`);
      input.addEventListener("change", () => {
        const given = column.inputs.map(({ value }) => (value === "" ? null : Number(value)));
        const open = given.every((value) => value === null);
        column.range = open ? null : [given[0] ?? -Infinity, given[1] ?? Infinity];
        filtered();
      });
      return input;
    });
    cell(row, "td", column.extent.map(brief).join(" to "));
  }
}

function fillRanges() {
  for (const { inputs, range } of state.columns) {
    (inputs || []).forEach((input, end) => {
      if (document.activeElement === input) return;
      input.value = range && Number.isFinite(range[end]) ? Number(range[end].toPrecision(4)) : "";
    });
  }
}

/** Limits become columns, as far as they are known. */
function addLimits(places, found) {
  found.forEach((limits, i) => {
    state.limits[places[i]] = limits;
    for (const { name, value, bound, limit } of limits) {
      let column = state.columns.find((other) => other.limited === name);
      if (!column) {
        const unknown = Array(state.n).fill(null);
        column = { name, limited: name, kind: "limit", log: false, values: unknown, bound, limit };
        const variables = state.columns.findIndex((other) => other.kind === "variable");
        state.columns.splice(variables < 0 ? state.columns.length : variables, 0, column);
      }
      column.values[places[i]] = value;
    }
  });
}

async function readLimits() {
  for (let from = 0; from < state.n; from += CHUNK) {
    const places = Array.from({ length: Math.min(CHUNK, state.n - from) }, (_, i) => from + i);
    byId("progress").textContent = from ? `limits of ${from} of them are known` : "";
    const found = await ask("limits", { rows: places });
    addLimits(places, found);
    if (!found[0].length) break; // it has none
  }
  byId("progress").textContent = "";
  for (const column of state.columns) {
    if (column.kind === "limit" && !column.extent) measured(Object.assign(column, { axis: undefined }));
  }
  offer();
  makeRanges();
  parallel.layout();
  show();
  document.body.dataset.limits = "known";
}

/** Quantities for the axes of the front. */
function offer() {
  const first = state.columns.filter(({ kind }) => kind === "objective");
  ["across", "up"].forEach((id, k) => {
    const select = byId(id);
    const before = select.selectedOptions.length ? select.selectedOptions[0].text : (first[k] || first[0]).name;
    select.replaceChildren();
    state.columns.forEach(({ name, extent }, i) => extent && select.add(new Option(name, i, false, name === before)));
  });
}

// One solution -------------------------------------------------------------------------------

const design = () => (state.changed ? state.changed.design : state.designs[state.chosen]);
let turn = 0; // of what is shown: what was asked for another design is not shown any more
let timers = [];

function show() {
  const number = state.numbers[state.chosen];
  const label = state.labels[number];
  byId("chosen").textContent = `Solution ${number}${label ? ` (${label})` : ""}${state.changed ? ", changed" : ""}`;
  byId("solution").value = String(state.chosen);
  byId("reset").disabled = !state.changed;
  fillEditor(design(), state.designs[state.chosen]);
  fillNumbers(state);
  const own = state.limits[state.chosen];
  fillLimits(state.changed && state.changed.limits ? state.changed.limits : own, own);
  parallel.mark();
  return drawScatter(state, told);
}

/** What takes longer, once nothing has changed for a while. */
function later() {
  const mine = ++turn;
  timers.forEach(clearTimeout);
  const current = (fill) => (found) => mine === turn && fill(found);
  const asked = (name, fill) => ask(name, { design: design() }).then(current(fill), current(tell));
  byId("answer").textContent = "";
  timers = [
    setTimeout(() => asked("figures", async ({ figures }) => {
      await drawGrid(byId("figures"), figures);
      document.body.dataset.shown = JSON.stringify(design());
    }), state.changed ? IDLE : 0),
    setTimeout(() => {
      const open = byId("described").open;
      if (!open && state.changed) return;
      asked("answer", ({ answer, described }) => {
        byId("answer").textContent = answer;
        const body = byId("described").querySelector("table");
        body.replaceChildren();
        for (const [name, value] of described) {
          const row = body.insertRow();
          cell(row, "th", name).scope = "row";
          cell(row, "td", shown(value));
        }
      });
    }, LONG),
    setTimeout(() => {
      if (!byId("review").open) return;
      const box = byId("review").lastElementChild;
      box.textContent = "…";
      asked("review", ({ sections }) => fillReview(box, sections));
    }, LONG),
  ];
}

function choose(place) {
  tell(null);
  Object.assign(state, { chosen: place, changed: null });
  history.replaceState(null, "", `#solution=${state.numbers[place]}`);
  document.body.dataset.chosen = state.numbers[place];
  show();
  later();
}

/** The next solution within all ranges, forth or back. */
function step(by) {
  for (let place = state.chosen + by; place in state.designs; place += by) {
    if (state.passes(place)) return choose(place);
  }
}

let busy = false;

/** Numbers of the design as it stands, again while it is changed: only the last one counts. */
async function glance() {
  if (busy) return;
  busy = true;
  while (state.changed && state.changed.asked !== state.changed.design.join()) {
    const { changed } = state;
    changed.asked = changed.design.join();
    try {
      const found = await ask("glance", { design: changed.design });
      if (state.changed !== changed) continue;
      tell(null);
      changed.limits = found.limits;
      const told = new Map(found.limits.map(({ name, value }) => [name, value]));
      const place = new Map(state.columns.map((column) => [column.name, column.index]));
      changed.values = (column) => {
        if (column.kind === "limit") return told.get(column.limited);
        if (column.kind === "variable") return changed.design[column.index];
        return found.numbers[place.get(column.name)];
      };
      document.body.dataset.glanced = changed.asked;
    } catch (error) {
      if (state.changed === changed) Object.assign(changed, { values: null, limits: null });
      tell(error);
    }
    show();
  }
  busy = false;
}

function alter(j, value) {
  if (Number.isNaN(value)) return;
  const changed = state.changed || { values: null, limits: null };
  changed.design = design().map((old, k) => (k === j ? value : old));
  state.changed = changed;
  glance();
  later();
}

async function save(overwrite) {
  const told = byId("saved");
  const name = byId("name").value;
  byId("replace").hidden = true;
  told.className = "";
  try {
    const { file } = await ask("save", { design: design(), name, overwrite });
    told.textContent = `written: ${file}`;
  } catch (error) {
    told.className = "error";
    told.textContent = error.message;
    byId("replace").hidden = error.status !== 409;
  }
}

const told = { chosen: choose, filtered };

// Start --------------------------------------------------------------------------------------

function listen() {
  byId("clear").addEventListener("click", () => {
    for (const column of state.columns) column.range = null;
    filtered();
  });
  new ResizeObserver(() => byId("front").data && Plotly.Plots.resize(byId("front"))).observe(byId("front").parentNode);
  for (const id of ["across", "up"]) byId(id).addEventListener("change", () => drawScatter(state, told));
  byId("solution").addEventListener("change", (event) => choose(Number(event.target.value)));
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  byId("reset").addEventListener("click", () => choose(state.chosen));
  byId("save").addEventListener("submit", (event) => {
    event.preventDefault();
    save(false);
  });
  byId("replace").addEventListener("click", () => save(true));
  for (const id of ["described", "review"]) byId(id).addEventListener("toggle", later);
  byId("pictures").addEventListener("toggle", async () => {
    const box = byId("pictures").lastElementChild;
    if (!byId("pictures").open || box.childElementCount) return;
    box.textContent = "…";
    try {
      const figures = await ask("pictures");
      box.textContent = "";
      for (const figure of Object.values(figures)) {
        await draw(box.appendChild(document.createElement("div")), figure);
      }
    } catch (error) {
      tell(error);
    }
  });
  addEventListener("keydown", (event) => {
    if (event.target.closest("input, select, textarea") || event.altKey || event.ctrlKey) return;
    if (event.key === "ArrowLeft") step(-1);
    if (event.key === "ArrowRight") step(1);
  });
  dark.addEventListener("change", () => {
    parallel.draw();
    choose(state.chosen);
  });
}

async function start() {
  const front = await ask("front");
  const { columns, rows, designs, numbers, labels, variables } = front;
  Object.assign(state, { n: rows.length, designs, numbers, labels, nearest: front.nearest });
  const said = columns.map((column, index) => ({ ...column, index, values: rows.map((row) => row[index]) }));
  const names = new Set(said.map(({ name }) => name));
  const moved = variables.map(({ name, kind }, index) => ({
    name: names.has(name) ? `${name} (variable)` : name,
    kind: "variable", index, log: false, whole: kind, values: designs.map((x) => x[index]),
  }));
  state.columns = [...said, ...moved].map(measured);
  filter();
  fillEditor = makeEditor(variables, alter);
  parallel = new Parallel(byId("parallel"), state, told);
  numbers.forEach((number, place) => {
    const label = labels[number];
    byId("solution").add(new Option(`${number}${label ? ` (${label})` : ""}`, place));
  });
  byId("name").value = front.save.name;
  byId("name").readOnly = front.save.fixed;
  offer();
  makeRanges();
  listen();
  const asked = /^#solution=(\d+)$/.exec(location.hash);
  const place = numbers.indexOf(asked ? Number(asked[1]) : front.first);
  choose(Math.max(place, 0));
  await readLimits();
}

start().catch(tell);
