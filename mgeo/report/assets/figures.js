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
  const layout = themed(figure.layout, !isPrinted() && node.clientWidth < NARROW);
  // Sizes of printed figures are in px of 1/96 inch, so that letters are as large as in the text.
  if (isPrinted()) {
    Object.assign(layout, { width: bar ? 700 : 345, font: { ...layout.font, size: 11 } });
    if (!bar) layout.height = 230;
  }
  const options = bar ? config : { ...config, displayModeBar: false };
  const drawn = Plotly.react(node, recolored(figure.data), layout, options);
  node.classList.add("plotly-graph-div");
  describe(node, figure);
  scalable(node);
  return drawn.then(() => scalable(node));
}

// Tables -------------------------------------------------------------------------------------

/** Format a value; numbers have four significant digits. */
function formatValue(value) {
  if (typeof value !== "number") return String(value);
  const size = Math.abs(value);
  const plain = size === 0 || (size >= 1e-3 && size < 1e6);
  if (size >= 1e4 && plain) return value.toFixed(0);
  const [digits, power] = plain ? [value.toPrecision(4)] : value.toExponential(3).split("e");
  return String(Number(digits)) + (power ? "e" + Number(power) : "");
}

function addCell(row, kind, text, scope) {
  const node = row.appendChild(document.createElement(kind));
  node.textContent = text;
  if (scope) node.scope = scope;
  return node;
}
