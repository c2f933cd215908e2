"use strict";
const byId = (id) => document.getElementById(id);
const config = { responsive: true, displaylogo: false, showSendToCloud: false };

// Figures ------------------------------------------------------------------------------------

/** Return a tree in which the placeholders are replaced by the values of one solution. */
function fillPlaceholders(tree, values) {
  if (Array.isArray(tree)) return tree.map((entry) => fillPlaceholders(entry, values));
  if (tree === null || typeof tree !== "object") return tree;
  if ("$placeholder" in tree) return structuredClone(values[tree.$placeholder]);
  return Object.fromEntries(Object.entries(tree).map(([k, v]) => [k, fillPlaceholders(v, values)]));
}

function draw(node, figure, bar = true) {
  const isPrinted = document.documentElement.classList.contains("printed");
  const layout = themed(figure.layout, node.clientWidth < NARROW);
  if (isPrinted) layout.width = bar ? 700 : 345; // In px of 1/96 inch, so that letters are as large as in the text.
  const options = bar ? config : { ...config, displayModeBar: false };
  const drawn = Plotly.react(node, recolored(figure.data), layout, options);
  node.classList.add("plotly-graph-div");
  scalable(node);
  return drawn.then(() => scalable(node));
}

/** Set a value at a dotted path, such as the paths in the buttons of plotly. */
function setAtPath(tree, path, value) {
  const keys = path.split(".");
  const last = keys.pop();
  for (const key of keys) tree = tree[key] = tree[key] || {};
  tree[last] = value;
}

/** Return a figure after a click on one of its buttons, so that the next solution keeps its state. */
function applyButton(figure, active) {
  const result = structuredClone({ data: figure.data, layout: figure.layout });
  const [menu] = result.layout.updatemenus || [];
  if (!menu) return result;
  const [traces, layout] = menu.buttons[active].args;
  for (const [path, values] of Object.entries(traces)) {
    result.data.forEach((trace, i) => setAtPath(trace, path, values[i % values.length]));
  }
  for (const [path, value] of Object.entries(layout)) setAtPath(result.layout, path, value);
  menu.active = active;
  return result;
}

// Tables -------------------------------------------------------------------------------------

/** Format a value; numbers have five significant digits. */
function formatValue(value) {
  if (typeof value !== "number") return String(value);
  const size = Math.abs(value);
  const plain = size === 0 || (size >= 1e-3 && size < 1e6);
  const [digits, power] = plain ? [value.toPrecision(5)] : value.toExponential(4).split("e");
  return String(Number(digits)) + (power ? "e" + Number(power) : "");
}

function addCell(row, kind, text) {
  const node = row.appendChild(document.createElement(kind));
  node.textContent = text;
  return node;
}
