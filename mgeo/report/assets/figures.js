"use strict";
const byId = (id) => document.getElementById(id);
const config = { responsive: true, displaylogo: false, showSendToCloud: false };

// Figures ------------------------------------------------------------------------------------

/** A tree with the values of one solution in place of its holes. */
function filled(tree, values) {
  if (Array.isArray(tree)) return tree.map((entry) => filled(entry, values));
  if (tree === null || typeof tree !== "object") return tree;
  if ("$differs" in tree) return structuredClone(values[tree.$differs]);
  return Object.fromEntries(Object.entries(tree).map(([k, v]) => [k, filled(v, values)]));
}

function draw(node, figure, bar = true) {
  const onPaper = document.documentElement.classList.contains("printed");
  const layout = themed(figure.layout, node.clientWidth < NARROW);
  if (onPaper) layout.width = bar ? 700 : 345; // px of 1/96 inch: letters as large as the text's
  const options = bar ? config : { ...config, displayModeBar: false };
  const drawn = Plotly.react(node, recolored(figure.data), layout, options);
  node.classList.add("plotly-graph-div");
  scalable(node);
  return drawn.then(() => scalable(node));
}

/** Put a value at a path with dots, as plotly's buttons name what they change. */
function put(tree, path, value) {
  const keys = path.split(".");
  const last = keys.pop();
  for (const key of keys) tree = tree[key] = tree[key] || {};
  tree[last] = value;
}

/** A figure after a click on one of its buttons: a solution chosen later keeps the choice. */
function pressed(figure, active) {
  const result = structuredClone({ data: figure.data, layout: figure.layout });
  const [menu] = result.layout.updatemenus || [];
  if (!menu) return result;
  const [traces, layout] = menu.buttons[active].args;
  for (const [path, values] of Object.entries(traces)) {
    result.data.forEach((trace, i) => put(trace, path, values[i % values.length]));
  }
  for (const [path, value] of Object.entries(layout)) put(result.layout, path, value);
  menu.active = active;
  return result;
}

// Tables -------------------------------------------------------------------------------------

function shown(value) {
  if (typeof value !== "number") return String(value);
  const size = Math.abs(value);
  const plain = size === 0 || (size >= 1e-3 && size < 1e6);
  const [digits, power] = plain ? [value.toPrecision(5)] : value.toExponential(4).split("e");
  return String(Number(digits)) + (power ? "e" + Number(power) : "");
}

function cell(row, kind, text) {
  const node = row.appendChild(document.createElement(kind));
  node.textContent = text;
  return node;
}
