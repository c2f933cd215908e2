
// One solution, and what a hand makes of it -----------------------------------------------------

/** Sliders and numbers for the variables; `told` is called with the design after each change. */
function makeEditor(variables, told) {
  const form = byId("editor");
  const rows = variables.map((variable, j) => {
    const label = form.appendChild(document.createElement("label"));
    label.textContent = variable.name;
    const { low, high, kind, options } = variable;
    const inputs = [];
    if (kind === "choice" || kind === "binary") {
      const select = form.appendChild(document.createElement("select"));
      (options || ["0", "1"]).forEach((text, value) => select.add(new Option(text, value)));
      form.appendChild(document.createElement("span"));
      inputs.push(select);
    } else {
      const step = kind === "integer" ? 1 : "any";
      const slide = form.appendChild(document.createElement(low === null ? "span" : "input"));
      if (low !== null) inputs.push(Object.assign(slide, { type: "range", min: low, max: high, step }));
      const number = form.appendChild(document.createElement("input"));
      inputs.push(Object.assign(number, { type: "number", step }));
      if (low !== null) Object.assign(number, { min: low, max: high });
    }
    inputs.forEach((input, k) => {
      if (k === 0) label.htmlFor = input.id = `variable${j}`;
      else input.setAttribute("aria-label", variable.name);
      input.addEventListener("input", () => {
        let value = input.value === "" ? NaN : Number(input.value);
        if (input.type === "range") value = Math.min(Math.max(Number(value.toPrecision(5)), low), high);
        for (const other of inputs) if (other !== input) other.value = value;
        told(j, value);
      });
    });
    return { label, inputs };
  });
  form.addEventListener("submit", (event) => event.preventDefault());
  return (design, from) => rows.forEach(({ label, inputs }, j) => {
    for (const input of inputs) {
      if (document.activeElement !== input || input.type === "range") input.value = Number(design[j].toPrecision(5));
    }
    label.classList.toggle("changed", design[j] !== from[j]);
  });
}

/** By how much a number has changed, in words. */
function change(before, after) {
  if (before === null || after === null || before === undefined) return "";
  if (before === after) return "=";
  if (before === 0) return "";
  const percent = 100 * (after / before - 1);
  return `${percent > 0 ? "+" : "−"}${Math.abs(percent).toPrecision(2).replace(/e\+?(\d+)$/, "e$1")} %`;
}

/** A table of the chosen solution's numbers, beside those of the changed design. */
function fillNumbers(state) {
  const { chosen, changed } = state;
  const table = byId("numbers");
  const made = changed && changed.values;
  const head = table.tHead;
  head.replaceChildren();
  const titles = ["", `solution ${state.numbers[chosen]}`, ...(made ? ["changed", "change"] : [])];
  const line = head.insertRow();
  for (const title of titles) cell(line, "th", title);
  const body = table.tBodies[0];
  body.replaceChildren();
  const text = (value) => (value === null || value === undefined ? "–" : shown(Number(value.toPrecision(4))));
  for (const column of state.columns) {
    if (column.kind !== "objective" && column.kind !== "told") continue;
    const row = body.insertRow();
    cell(row, "th", column.name).scope = "row";
    const before = column.values[chosen];
    cell(row, "td", text(before));
    if (!made) continue;
    const after = changed.values(column);
    cell(row, "td", text(after));
    cell(row, "td", change(before, after));
  }
}

/** Limits of what is shown, and what they were of the chosen solution. */
function fillLimits(now, before) {
  const body = byId("limits");
  body.replaceChildren();
  byId("limited").hidden = !now || now.length === 0;
  const known = new Map((before || []).map((limit) => [limit.name, limit.text]));
  for (const { name, kept, text } of now || []) {
    const row = body.insertRow();
    cell(row, "th", name).scope = "row";
    const node = cell(row, "td", text);
    node.classList.toggle("exceeded", !kept);
    if (!known.has(name) || known.get(name) === text) continue;
    const was = node.appendChild(document.createElement("div"));
    was.className = "was";
    was.textContent = `was ${known.get(name)}`;
  }
}

/** Sections of a review: titles, lines and tables. */
function fillReview(box, sections) {
  box.replaceChildren();
  const add = (kind, text, look = "") => {
    const node = box.appendChild(document.createElement(kind));
    Object.assign(node, { textContent: text, className: look });
    return node;
  };
  for (const { title, lines, table, note } of sections) {
    add("h3", title);
    for (const line of lines) add("p", line);
    if (table) {
      const place = add("div", "", "wide").appendChild(document.createElement("table"));
      const isNumber = table[0].map((_, j) => table.slice(1).every((row) => row[j] === "" || !Number.isNaN(Number(row[j]))));
      table.forEach((row, i) => {
        const line = (i ? place.tBodies[0] || place.createTBody() : place.createTHead()).insertRow();
        row.forEach((text, j) => {
          const said = i ? { True: "yes", False: "NO" }[text] || text : text;
          const node = cell(line, i ? "td" : "th", said);
          node.className = `${isNumber[j] ? "number" : "text"}${said === "NO" ? " exceeded" : ""}`;
        });
      });
    }
    if (note) add("p", note, "note");
  }
}
