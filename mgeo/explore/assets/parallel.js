
// Parallel coordinates: an axis for each quantity, a line for each solution ----------------------

const SPACE = 74; // px between upright axes, at least
const ROW = 50; // px between axes that lie, on a phone

/** Where a value stands on a column's axis, from 0 to 1; NaN where it is not known. */
function placed(column, value) {
  if (value === null) return NaN;
  const [low, high] = column.extent;
  if (high === low) return 0.5;
  const f = column.log ? Math.log : (v) => v;
  return (f(value) - f(low)) / (f(high) - f(low));
}

/** The value at a place from 0 to 1. */
function valued(column, place) {
  const [low, high] = column.extent;
  const at = Math.min(Math.max(place, 0), 1);
  return column.log ? low * (high / low) ** at : low + at * (high - low);
}

/** A number for people, short. */
function brief(value) {
  return shown(Number(value.toPrecision(3)));
}

class Parallel {
  /** `state` has columns, n, passes(row), chosen, changed; `told` is called with what was done. */
  constructor(box, state, told) {
    Object.assign(this, { box, state, told, hovered: null });
    new ResizeObserver(() => this.layout()).observe(box);
  }

  /** Axes anew: after another choice of them, or on another width. */
  layout() {
    const { box, state } = this;
    this.columns = state.columns.filter((column) => column.axis && column.extent);
    const n = this.columns.length;
    const room = box.clientWidth;
    if (!room || !n) return box.replaceChildren();
    this.lying = room < 600;
    const [left, right] = this.lying ? [14, 14] : [46, 46];
    const width = this.lying ? room : Math.max(room - 2, left + right + SPACE * (n - 1));
    const height = this.lying ? ROW * n + 12 : 310;
    const step = this.lying ? ROW : n > 1 ? (width - left - right) / (n - 1) : 0;
    this.across = (i) => (this.lying ? 30 + ROW * i : n > 1 ? left + step * i : width / 2);
    const [from, to] = this.lying ? [left, width - right] : [height - 22, 66];
    this.along = (place) => from + place * (to - from);
    this.unit = (x) => (x - from) / (to - from);
    this.size = [width, height];
    const frame = document.createElement("div");
    frame.style.cssText = `position: relative; width: ${width}px; height: ${height}px`;
    frame.classList.toggle("across", this.lying);
    const picture = svg("svg", { width, height, role: "group", "aria-label": "parallel coordinates" });
    this.canvases = ["base", "top"].map(() => {
      const canvas = frame.appendChild(document.createElement("canvas"));
      const ratio = window.devicePixelRatio || 1;
      Object.assign(canvas, { width: width * ratio, height: height * ratio });
      canvas.style.cssText = `width: ${width}px; height: ${height}px`;
      canvas.getContext("2d").scale(ratio, ratio);
      return canvas;
    });
    this.axes = this.columns.map((column, i) => this.axis(frame, picture, column, i, step));
    frame.append(picture);
    picture.addEventListener("pointermove", (event) => this.hover(event));
    picture.addEventListener("pointerleave", () => this.hover(null));
    picture.addEventListener("click", (event) => this.pick(event));
    this.picture = picture;
    box.replaceChildren(frame);
    this.draw();
  }

  axis(frame, picture, column, i, step) {
    const at = this.across(i);
    const line = (name, a, b, p, q) =>
      svg(name, this.lying ? { x1: a, x2: b, y1: p, y2: q } : { x1: p, x2: q, y1: a, y2: b });
    const group = picture.appendChild(svg("g", {}));
    group.append(Object.assign(line("line", this.along(0), this.along(1), at, at)));
    group.lastChild.setAttribute("class", "axis");
    const limit = column.limit === undefined ? NaN : placed(column, column.limit);
    if (limit >= 0 && limit <= 1) {
      const mark = line("line", this.along(limit), this.along(limit), at - 9, at + 9);
      mark.setAttribute("class", "limit");
      mark.append(svg("title", {}));
      mark.lastChild.textContent = `${column.bound} ${brief(column.limit)}`;
      group.append(mark);
    }
    column.extent.forEach((value, end) => {
      const along = this.along(end);
      const place = this.lying
        ? { x: along, y: at + 14, "text-anchor": end ? "end" : "start" }
        : { x: at, y: end ? along - 5 : along + 14, "text-anchor": "middle" };
      const text = svg("text", { ...place, class: "end" });
      text.textContent = brief(value);
      group.append(text);
    });
    const brush = group.appendChild(svg("rect", { class: "brush", visibility: "hidden" }));
    const half = this.lying ? 14 : Math.min(16, step ? step / 3 : 16);
    const [a, b] = [this.along(0), this.along(1)].sort((p, q) => p - q);
    const hit = this.lying
      ? { x: a, y: at - half, width: b - a, height: 2 * half }
      : { x: at - half, y: a, width: 2 * half, height: b - a };
    const zone = group.appendChild(svg("rect", { ...hit, class: "hit" }));
    zone.dataset.axis = column.name;
    if (!this.lying) zone.style.touchAction = "none";
    zone.addEventListener("pointerdown", (event) => this.drag(event, zone, column));
    const name = frame.appendChild(document.createElement("div"));
    name.className = "name";
    name.textContent = name.title = column.name;
    const wide = step ? step - 6 : 160;
    name.style.cssText = this.lying
      ? `left: 14px; right: 14px; top: ${at - 24}px`
      : `left: ${Math.max(at - wide / 2, 0)}px; width: ${wide}px; top: 2px; height: 42px`;
    return { brush, at };
  }

  /** The value below a pointer, on a column's axis. */
  under(event, column) {
    const box = this.picture.getBoundingClientRect();
    return valued(column, this.unit(this.lying ? event.clientX - box.x : event.clientY - box.y));
  }

  /** A range from where the pointer went down to where it goes; a click drops what there is. */
  drag(event, zone, column) {
    event.preventDefault();
    zone.setPointerCapture(event.pointerId);
    const old = column.range;
    const near = (value) => Math.abs(placed(column, value) - placed(column, this.under(event, column))) < 0.04;
    let start = this.under(event, column);
    if (old && near(old[0])) start = old[1];
    else if (old && near(old[1])) start = old[0];
    const [x, y] = [event.clientX, event.clientY];
    let moved = false;
    const move = (next) => {
      moved = moved || Math.hypot(next.clientX - x, next.clientY - y) > 4;
      if (!moved) return;
      column.range = [start, this.under(next, column)].sort((a, b) => a - b);
      this.told.filtered();
    };
    const up = (next) => {
      zone.removeEventListener("pointermove", move);
      this.dragged = moved || Boolean(old);
      if (!moved && old) {
        column.range = null;
        this.told.filtered();
      }
      setTimeout(() => (this.dragged = false)); // the click that follows picks no line
    };
    zone.addEventListener("pointermove", move);
    zone.addEventListener("pointerup", up, { once: true });
    zone.addEventListener("pointercancel", up, { once: true });
  }

  /** The solution whose line is nearest to a pointer, of those within all ranges; else null. */
  nearest(event) {
    if (!this.columns || !this.columns.length) return null;
    const box = this.picture.getBoundingClientRect();
    const [x, y] = [event.clientX - box.x, event.clientY - box.y];
    const [along, across] = this.lying ? [x, y] : [y, x];
    let i = 0;
    while (i < this.columns.length - 2 && this.across(i + 1) < across) i++;
    const other = Math.min(i + 1, this.columns.length - 1);
    const share = other === i ? 0 : (across - this.across(i)) / (this.across(other) - this.across(i));
    let best = [null, 9];
    for (let row = 0; row < this.state.n; row++) {
      if (!this.state.passes(row)) continue;
      const [p, q] = [i, other].map((k) => this.along(placed(this.columns[k], this.columns[k].values[row])));
      const off = Math.abs(p + share * (q - p) - along);
      if (off < best[1]) best = [row, off];
    }
    return best[0];
  }

  hover(event) {
    const row = event && !event.buttons ? this.nearest(event) : null;
    if (row === this.hovered) return;
    this.hovered = row;
    this.picture.style.cursor = row === null ? "" : "pointer";
    this.mark();
  }

  pick(event) {
    const row = this.dragged ? null : this.nearest(event);
    if (row !== null) this.told.chosen(row);
  }

  draw() {
    if (!this.canvases || !this.columns.length) return;
    const context = this.canvases[0].getContext("2d");
    context.clearRect(0, 0, ...this.size);
    const { n } = this.state;
    const rows = [[], []];
    for (let row = 0; row < n; row++) rows[this.state.passes(row) ? 1 : 0].push(row);
    const alpha = Math.min(0.75, Math.max(0.15, 12 / Math.sqrt(rows[1].length + 1) / 6));
    for (const [kind, look, opacity] of [[0, color("shade"), 0.12], [1, color("accent"), alpha]]) {
      Object.assign(context, { strokeStyle: look, globalAlpha: opacity, lineWidth: 1.2 });
      for (const row of rows[kind]) this.line(context, (column) => column.values[row]);
    }
    this.columns.forEach((column, i) => {
      const { brush, at } = this.axes[i];
      brush.setAttribute("visibility", column.range ? "visible" : "hidden");
      if (!column.range) return;
      const [low, high] = column.extent; // a range in numbers may be open, or wider
      const ends = column.range.map((value) => this.along(placed(column, Math.min(Math.max(value, low), high))));
      const [a, b] = ends.sort((p, q) => p - q);
      const size = this.lying
        ? { x: a, width: b - a, y: at - 6, height: 12 }
        : { y: a, height: b - a, x: at - 6, width: 12 };
      for (const [key, value] of Object.entries(size)) brush.setAttribute(key, value);
    });
    this.mark();
  }

  /** The chosen solution, the one below the pointer, and the design that a hand has changed. */
  mark() {
    if (!this.canvases || !this.columns.length) return;
    const context = this.canvases[1].getContext("2d");
    context.clearRect(0, 0, ...this.size);
    context.setLineDash([]);
    const { chosen, changed } = this.state;
    if (this.hovered !== null) {
      Object.assign(context, { strokeStyle: color("accent"), lineWidth: 3 });
      this.line(context, (column) => column.values[this.hovered]);
    }
    if (chosen !== null) {
      Object.assign(context, { strokeStyle: color("ink"), lineWidth: 2.5 });
      this.line(context, (column) => column.values[chosen]);
    }
    if (changed && changed.values) {
      Object.assign(context, { strokeStyle: color("bad"), lineWidth: 2.5 });
      context.setLineDash([6, 4]);
      this.line(context, (column) => changed.values(column));
    }
  }

  line(context, value) {
    context.beginPath();
    let pen = false;
    this.columns.forEach((column, i) => {
      const found = value(column);
      const along = this.along(placed(column, found === undefined ? null : found));
      if (Number.isNaN(along)) return void (pen = false);
      const point = this.lying ? [along, this.across(i)] : [this.across(i), along];
      if (pen) context.lineTo(...point);
      else context.moveTo(...point);
      pen = true;
    });
    context.stroke();
  }
}
