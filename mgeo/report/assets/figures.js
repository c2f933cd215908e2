"use strict";
const config = { responsive: true, displaylogo: false, showSendToCloud: false };
const dark = matchMedia("(prefers-color-scheme: dark)");

// Figures ------------------------------------------------------------------------------------

/** A tree with the values of one solution in place of its holes. */
function filled(tree, values) {
  if (Array.isArray(tree)) return tree.map((entry) => filled(entry, values));
  if (tree === null || typeof tree !== "object") return tree;
  if ("$differs" in tree) return structuredClone(values[tree.$differs]);
  return Object.fromEntries(Object.entries(tree).map(([k, v]) => [k, filled(v, values)]));
}

/** The layout in the colors of the page. */
function themed(layout, narrow) {
  const style = getComputedStyle(document.documentElement);
  const color = (name) => style.getPropertyValue("--" + name).trim();
  const axis = { gridcolor: color("rule"), zerolinecolor: color("rule"), linecolor: color("soft") };
  axis.automargin = true;
  const result = structuredClone(layout);
  result.paper_bgcolor = result.plot_bgcolor = "rgba(0,0,0,0)";
  result.font = { ...result.font, color: color("ink") };
  const tip = { color: color("ink") };
  result.hoverlabel = { ...result.hoverlabel, bgcolor: color("panel"), font: tip };
  result.legend = { ...result.legend, bgcolor: "rgba(0,0,0,0)", bordercolor: color("rule") };
  result.modebar = { bgcolor: "rgba(0,0,0,0)", color: color("soft"), activecolor: color("accent") };
  result.xaxis = result.xaxis || {};
  result.yaxis = result.yaxis || {};
  for (const key of Object.keys(result)) {
    if (/^[xy]axis\d*$/.test(key)) Object.assign(result[key], axis);
    if (/^scene\d*$/.test(key)) {
      for (const name of ["xaxis", "yaxis", "zaxis"]) {
        result[key][name] = { ...result[key][name], ...axis, backgroundcolor: color("panel") };
      }
    }
  }
  for (const note of result.annotations || []) note.font = { ...note.font, color: color("soft") };
  if (narrow) result.font.size = 11;
  return result;
}

/** Relative luminance of WCAG 2.1. */
function luminance(rgb) {
  const linear = rgb.map((v) => (v <= 10 ? v / 3294 : ((v / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}

/** A color that stands out from the page: mixed with that of the text as far as it must be. */
function readable(color) {
  const style = getComputedStyle(document.documentElement);
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  const [ink, paper] = ["--ink", "--paper"].map((name) => rgb(style.getPropertyValue(name).trim()));
  const contrast = (one) => {
    const [a, b] = [luminance(one), luminance(paper)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  };
  let mixed = rgb(color);
  for (let i = 0; i < 10 && contrast(mixed) < (dark.matches ? 4.5 : 3); i++) {
    mixed = mixed.map((value, j) => Math.round(0.9 * value + 0.1 * ink[j]));
  }
  return `rgb(${mixed})`;
}

function recolored(tree) {
  if (Array.isArray(tree)) return tree.map(recolored);
  if (tree === null || typeof tree !== "object") return tree;
  const fit = (key, value) =>
    key === "color" && /^#[0-9a-f]{6}$/i.test(value) ? readable(value) : recolored(value);
  return Object.fromEntries(Object.entries(tree).map(([k, v]) => [k, fit(k, v)]));
}

function draw(node, figure, bar = true) {
  const layout = themed(figure.layout, node.clientWidth < 500);
  const options = bar ? config : { ...config, displayModeBar: false };
  return Plotly.react(node, recolored(figure.data), layout, options);
}
