// Figures that move, in the form that mgeo/figures/motion.py tells ---------------------------------

/** Values of an array of numbers, which may be encoded. */
function numbers(array) {
  if (!array.bdata) return array;
  const bytes = Uint8Array.from(atob(array.bdata), (character) => character.charCodeAt(0));
  const kinds = { f4: Float32Array, i1: Int8Array, i2: Int16Array, i4: Int32Array };
  return new (kinds[array.dtype] || Uint8Array)(bytes.buffer);
}

/** Matrix (rows) of a rotation vector in degrees: Rodrigues' formula. */
function rotation(x, y, z) {
  const degrees = Math.hypot(x, y, z);
  if (degrees === 0) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const [a, b, c] = [x / degrees, y / degrees, z / degrees];
  const sine = Math.sin((degrees * Math.PI) / 180);
  const cosine = Math.cos((degrees * Math.PI) / 180);
  const rest = 1 - cosine;
  return [
    [cosine + rest * a * a, rest * a * b - sine * c, rest * a * c + sine * b],
    [rest * a * b + sine * c, cosine + rest * b * b, rest * b * c - sine * a],
    [rest * a * c - sine * b, rest * b * c + sine * a, cosine + rest * c * c],
  ];
}

function product(left, right) {
  return left.map((row) =>
    [0, 1, 2].map((j) => row[0] * right[0][j] + row[1] * right[1][j] + row[2] * right[2][j]),
  );
}

/** Orientation as a function of time. */
function orientation(turn) {
  const [times, x, y, z] = ["times", "x", "y", "z"].map((key) => numbers(turn[key]));
  const reached = [rotation(0, 0, 0)];
  for (let i = 0; i < x.length; i++) {
    reached.push(product(reached[i], rotation(x[i], y[i], z[i])));
  }
  return (time) => {
    let i = 0;
    for (let high = x.length; high - i > 1; ) {
      const middle = (i + high) >> 1;
      if (times[middle] <= time) i = middle;
      else high = middle;
    }
    const share = Math.min((time - times[i]) / (times[i + 1] - times[i]), 1);
    return product(reached[i], rotation(share * x[i], share * y[i], share * z[i]));
  };
}

/** What turns in a figure: at a time, the new coordinates and opacities of traces `which`. */
function movement(figure) {
  const motion = figure.layout.meta.motion;
  const lasting = (time) => (phase) => phase.from <= time && time < phase.to;
  const phases = motion.phases || [];
  const orientations = {};
  for (const [name, vectors] of Object.entries(motion.rotations)) orientations[name] = buildOrientation(vectors);
  const which = [...figure.data.keys()].filter((k) => figure.data[k].meta && figure.data[k].meta.rotation);
  const parts = which.map((k) => {
    const { meta, x, y, z, opacity = 1 } = figure.data[k];
    return { ...meta, opacity, points: [x, y, z].map((values) => Array.from(numbers(values))) };
  });
  const names = (time) => phases.filter(lasting(time)).map((phase) => phase.name);
  const at = (time) => {
    const now = names(time);
    const change = { x: [], y: [], z: [], opacity: [] };
    for (const { rotation: name, faint, opacity, points } of parts) {
      const rows = orientations[name](time);
      ["x", "y", "z"].forEach((key, r) => {
        const [a, b, c] = rows[r];
        // a gap in a line stays one
        const turned = (x, i) => (x === null ? x : a * x + b * points[1][i] + c * points[2][i]);
        change[key].push(points[0].map(turned));
      });
      change.opacity.push(now.includes(faint) ? 0.2 * opacity : opacity);
    }
    return change;
  };
  return { end: motion.end, phases, names, which, at };
}

/** Shaded phases as the background of the time line. */
function shading({ end, phases }) {
  const stops = phases.filter((phase) => phase.shaded && phase.from < end).map(({ from, to }) => {
    const [a, b] = [from, Math.min(to, end)].map((time) => `${(100 * time) / end}%`);
    return `transparent ${a}, var(--shade) ${a}, var(--shade) ${b}, transparent ${b}`;
  });
  return stops.length ? `linear-gradient(to right, ${stops.join(", ")})` : "none";
}

const SPEEDS = [1, 10, 50, 200];

/** Controls below a moving figure; nothing moves until play is pressed. */
function player(node, figure) {
  const moves = movement(figure);
  const box = document.createElement("div");
  box.className = "player";
  box.innerHTML =
    '<button type=button></button><input type=range min=0 step=any aria-label="time">' +
    "<select aria-label=speed></select><output></output>";
  const [button, slider, speed, told] = box.children;
  slider.max = moves.end;
  slider.style.backgroundImage = shading(moves);
  for (const factor of SPEEDS) speed.add(new Option(`${factor}×`, factor, false, factor === 50));
  let time = 0;
  let before = null; // clock of the last picture while it plays
  let drawing = false;

  async function show() {
    slider.value = time;
    told.textContent = [`${time.toFixed(0)} s`, ...moves.names(time)].join(" · ");
    if (drawing) return;
    drawing = true;
    await Plotly.restyle(node, moves.at(time), moves.which);
    drawing = false;
  }
  function stop() {
    before = null;
    button.textContent = "Play";
  }
  function tick(clock) {
    if (before === null || !box.isConnected) return stop();
    time = Math.min(time + ((clock - before) / 1000) * Number(speed.value), moves.end);
    before = clock;
    show();
    if (time < moves.end) requestAnimationFrame(tick);
    else stop();
  }
  button.addEventListener("click", () => {
    if (before !== null) return stop();
    if (time >= moves.end) time = 0;
    before = performance.now();
    button.textContent = "Pause";
    requestAnimationFrame(tick);
  });
  slider.addEventListener("input", () => {
    time = Number(slider.value);
    show();
  });
  stop();
  show();
  return box;
}

// On paper nothing moves: what turns, as it stands when each phase begins and at the end ----------
const MOST_STILLS = 9;

/** Times that are worth a still: of up to so many phases the starts, and the end. */
function stillTimes({ end, phases }) {
  const starts = phases.filter((phase) => !phase.shaded && phase.from < end).map((phase) => phase.from);
  const times = [...new Set([0, ...starts])].sort((a, b) => a - b).slice(0, MOST_STILLS - 1);
  return [...times, end];
}

/** Across, up and toward the eye of a camera as plotly places it. */
function projection({ x, y, z }) {
  const far = Math.hypot(x, y, z);
  const flat = Math.hypot(x, y) || 1;
  const across = [-y / flat, x / flat, 0];
  const [a, b, c] = [x / far, y / far, z / far];
  const up = [b * across[2] - c * across[1], c * across[0] - a * across[2], a * across[1] - b * across[0]];
  const dot = (v, p) => v[0] * p[0] + v[1] * p[1] + v[2] * p[2];
  return (point) => [dot(across, point), -dot(up, point), dot([a, b, c], point)];
}

/** A node of SVG with attributes. */
function svg(name, attributes) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  return node;
}

/** Corners, in order, of the convex hull of points in a plane: Andrew's monotone chain. */
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (given) => {
    const chain = [];
    for (const p of given) {
      while (chain.length > 1) {
        const [a, b] = chain.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) > (b[1] - a[1]) * (p[0] - a[0])) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

/** A trace as SVG, in parts with how near the eye each is: of a mesh its outline. */
function shapes(trace, points, seen) {
  const gap = (x) => x === null || Number.isNaN(x);
  const flat = points[0].map((x, i) => (gap(x) ? null : seen([x, points[1][i], points[2][i]])));
  const at = (p) => `${p[0].toFixed(3)},${p[1].toFixed(3)}`;
  const near = (some) => some.reduce((sum, p) => sum + p[2], 0) / some.length;
  const { opacity = 1, mode = "lines", marker = {}, line = {} } = trace;
  const look = (part) => (typeof part.color === "string" ? part.color : "#767676");
  if (trace.type === "mesh3d") {
    const some = flat.filter(Boolean);
    const fill = trace.color || "#9aa3ad";
    return [[near(some), svg("polygon", { points: hull(some).map(at).join(" "), fill, opacity: 0.6 * opacity })]];
  }
  const drawn = [];
  let run = [];
  for (const point of mode.includes("lines") ? [...flat, null] : []) {
    if (point) run.push(point);
    else if (run.length) {
      const stroke = { fill: "none", stroke: look(line), opacity, "stroke-width": 0.006 * (line.width || 2) };
      drawn.push([near(run), svg("polyline", { points: run.map(at).join(" "), ...stroke })]);
      run = [];
    }
  }
  const each = (value, i) => (Array.isArray(value) ? value[i] : value);
  flat.forEach((point, i) => {
    if (!point) return;
    const size = each(marker.size === undefined ? 6 : marker.size, i);
    if (mode.includes("markers") && size) {
      drawn.push([point[2], svg("circle", { cx: point[0], cy: point[1], r: 0.006 * size, fill: look(marker), opacity })]);
    }
    if (mode.includes("text") && each(trace.text, i)) {
      const label = svg("text", { x: point[0] + 0.03, y: point[1] - 0.03, "font-size": 0.17, fill: "#222222" });
      label.textContent = each(trace.text, i);
      drawn.push([9, label]);
    }
  });
  return drawn;
}

/** A picture of each of the times, for paper. */
function stills(figure) {
  const moves = movement(figure);
  const eye = ((figure.layout.scene || {}).camera || {}).eye || { x: 1.25, y: 1.25, z: 1.25 };
  const seen = projection(eye);
  const box = document.createElement("div");
  box.className = "stills printed-only";
  const here = figure.data.map((trace) => ["x", "y", "z"].map((key) => Array.from(numbers(trace[key] || []))));
  const known = figure.data.map((trace) => trace.type === "mesh3d" || trace.type === "scatter3d");
  let size = 1;
  for (const [k, points] of here.entries()) {
    if (known[k]) points[0].forEach((x, i) => x !== null && !Number.isNaN(x) && (size = Math.max(size, Math.hypot(x, points[1][i], points[2][i]))));
  }
  for (const time of stillTimes(moves)) {
    const now = moves.at(time);
    const all = figure.data.flatMap((trace, k) => {
      if (!known[k] || trace.visible === false) return [];
      const turned = moves.which.indexOf(k);
      const points = turned < 0 ? here[k] : ["x", "y", "z"].map((key) => now[key][turned]);
      return shapes(turned < 0 ? trace : { ...trace, opacity: now.opacity[turned] }, points, seen);
    });
    all.sort((a, b) => a[0] - b[0]);
    const room = 1.1 * size;
    const picture = svg("svg", { viewBox: `${-room} ${-room} ${2 * room} ${2 * room}`, role: "img" });
    picture.append(...all.map(([, node]) => node));
    const told = document.createElement("figcaption");
    told.textContent = [`${time.toFixed(0)} s`, ...moves.names(time)].join(" · ");
    box.appendChild(document.createElement("figure")).append(picture, told);
  }
  return box;
}

// Figures of one solution ---------------------------------------------------------------------

// three-dimensional pictures are drawn once they come into view, so that the page opens at once
const seen = new IntersectionObserver(
  (entries) => entries.filter((entry) => entry.isIntersecting).forEach(({ target }) => play(target)),
  { rootMargin: "200px" },
);

async function play(box) {
  seen.unobserve(box);
  const figure = box.moving;
  await draw(box.firstChild, figure, false);
  if (box.moving !== figure) return; // another solution was chosen meanwhile
  box.replaceChildren(box.firstChild, player(box.firstChild, figure), stills(figure));
}

/** Draw figures, by name, into a grid. */
function drawGrid(box, figures) {
  const names = Object.keys(figures);
  while (box.children.length > names.length) box.lastChild.remove();
  while (box.children.length < names.length) {
    box.appendChild(document.createElement("div")).appendChild(document.createElement("div"));
  }
  return Promise.all(names.map((name, i) => {
    const place = box.children[i];
    const figure = figures[name];
    place.classList.toggle("moving", "motion" in (figure.layout.meta || {}));
    place.moving = (figure.layout.meta || {}).motion ? figure : null;
    place.replaceChildren(place.firstChild); // without another figure's controls
    seen.unobserve(place);
    if (!place.moving) return draw(place.firstChild, figure, false);
    place.appendChild(stills(figure));
    place.firstChild.style.minHeight = `${figure.layout.height || 400}px`;
    seen.observe(place);
  }));
}
