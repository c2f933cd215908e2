// Figures in the colors of the page: light, dark, and printed ----------------------------------
const dark = matchMedia("(prefers-color-scheme: dark)");
const NARROW = 500; // Width [px] below which the legend is placed under the plot.

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

const isPrinted = () => document.documentElement.classList.contains("printed");

/** Place the legend below the plot, and reduce margins and text. */
function adaptToNarrowScreen(layout) {
  const below = { orientation: "h", x: 0.5, xref: "container", xanchor: "center", y: 0, yref: "container", yanchor: "bottom" };
  layout.legend = { ...layout.legend, ...below };
  layout.font.size = 11;
  if (!layout.scene) layout.margin = { ...layout.margin, l: 50, r: 10 };
  for (const note of layout.annotations || []) note.font.size = 11;
  for (const key of Object.keys(layout).filter((name) => /^xaxis\d*$/.test(name))) {
    const [low, high] = layout[key].domain || [0, 1];
    const isLog = layout[key].type === "log";
    if (high - low < 0.5) Object.assign(layout[key], isLog ? { tickangle: -90 } : { nticks: 3, tickangle: 0 });
  }
  if (layout.coloraxis) layout.coloraxis = { ...layout.coloraxis, showscale: false };
  // Axes with equal scales need no more height than width.
  if ([layout.xaxis, layout.yaxis].some((axis) => axis.scaleanchor)) layout.height = Math.min(layout.height || 500, 500);
}

/** Return a copy of a plotly layout in the colors of the page. */
function themed(layout, narrow) {
  const axis = { gridcolor: color("rule"), zerolinecolor: color("rule"), linecolor: color("soft") };
  axis.automargin = true;
  const result = structuredClone(layout);
  result.paper_bgcolor = result.plot_bgcolor = "rgba(0,0,0,0)";
  result.font = { ...result.font, color: color("ink") };
  result.hoverlabel = { ...result.hoverlabel, bgcolor: color("panel"), font: { color: color("ink") } };
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
  delete result.updatemenus; // See buildButtons.
  const scale = (result.coloraxis || {}).colorscale; // White becomes the color of the page.
  if (scale) result.coloraxis.colorscale = scale.map(([at, c]) => [at, c === "#ffffff" ? color("paper") : c]);
  if (narrow) adaptToNarrowScreen(result);
  return result;
}

/** Return the relative luminance of WCAG 2.1 of a color. */
function luminance(rgb) {
  const linear = rgb.map((v) => (v <= 10 ? v / 3294 : ((v / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}

/** Return a color with sufficient contrast to the page, mixed with the text color if necessary. */
function readable(given) {
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  const [ink, paper] = ["ink", "paper"].map((name) => rgb(color(name)));
  const contrast = (one) => {
    const [a, b] = [luminance(one), luminance(paper)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  };
  const least = luminance(paper) < luminance(ink) ? 4.5 : 3;
  let mixed = rgb(given);
  for (let i = 0; i < 10 && contrast(mixed) < least; i++) {
    mixed = mixed.map((value, j) => Math.round(0.9 * value + 0.1 * ink[j]));
  }
  return `rgb(${mixed})`;
}

/** Return a copy of plotly traces with readable colors. */
function recolored(tree) {
  if (Array.isArray(tree)) return tree.map(recolored);
  if (tree === null || typeof tree !== "object" || ArrayBuffer.isView(tree)) return tree;
  const fit = (key, value) =>
    key === "color" && /^#[0-9a-f]{6}$/i.test(value) ? readable(value) : recolored(value);
  return Object.fromEntries(Object.entries(tree).map(([k, v]) => [k, fit(k, v)]));
}

/** Make a figure scalable to the width of a printed page; `size` is its size if not drawn yet. */
function scalable(plot, size = null) {
  const svgs = plot.querySelectorAll(".svg-container > .main-svg");
  if (!svgs.length) return;
  const [width, height] = size || ["width", "height"].map((key) => svgs[0].getAttribute(key));
  for (const svg of svgs) svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  plot.style.setProperty("--shape", `${width} / ${height}`);
}

/** Set a value at a dotted path, such as the paths in the buttons of plotly. */
function setAtPath(tree, path, value) {
  const keys = path.split(".");
  const last = keys.pop();
  for (const key of keys) tree = tree[key] = tree[key] || {};
  tree[last] = value;
}

/** Return a figure after a click on one of its buttons. */
function applyButton(figure, active) {
  const result = structuredClone({ data: figure.data, layout: figure.layout });
  const [menu] = result.layout.updatemenus || [];
  if (!menu) return result;
  const [traces, layout] = menu.buttons[active].args;
  for (const [path, values] of Object.entries(traces)) {
    result.data.forEach((trace, i) => setAtPath(trace, path, values[i % values.length]));
  }
  for (const [path, value] of Object.entries(layout)) setAtPath(result.layout, path, value);
  return result;
}

/** Fill a bar with HTML buttons in place of those of plotly, which the keyboard does not reach. */
function buildButtons(bar, figure, onClick) {
  const [menu] = figure.layout.updatemenus || [];
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Quantity on the vertical axis");
  const buttons = (menu ? menu.buttons : []).map(({ label }, i) => {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: label, ariaPressed: String(i === 0) });
    button.addEventListener("click", () => {
      buttons.forEach((other) => (other.ariaPressed = String(other === button)));
      onClick(i);
    });
    return button;
  });
  bar.replaceChildren(...buttons);
}

/** Describe a figure to screen readers by its title, its axes and its traces. */
function describe(node, { data, layout }) {
  const plain = (text) => new DOMParser().parseFromString(text.replace(/<br ?\/?>/g, ", "), "text/html").body.textContent;
  const title = (part) => ((part || {}).title || {}).text || "";
  const names = data.filter((trace) => trace.showlegend !== false && trace.visible !== false).map((trace) => trace.name);
  const axes = Object.keys(layout).filter((key) => /^[xy]axis\d*$/.test(key) && title(layout[key]));
  const parts = [title(layout) || node.dataset.name, ...axes.map((key) => `${key[0]} axis: ${title(layout[key])}`), names.filter(Boolean).join(", ")];
  node.setAttribute("role", "img");
  node.setAttribute("aria-label", `Figure. ${parts.filter(Boolean).map(plain).join("; ")}`);
}
