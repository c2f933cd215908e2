// Animated figures, in the format of mgeo/figures/motion.py -----------------------------------------

/** Decode an array of numbers, if plotly has encoded it. */
function decodeArray(array) {
  if (!array.bdata) return array;
  const bytes = Uint8Array.from(atob(array.bdata), (character) => character.charCodeAt(0));
  const kinds = { f4: Float32Array, i1: Int8Array, i2: Int16Array, i4: Int32Array };
  return new (kinds[array.dtype] || Uint8Array)(bytes.buffer);
}

/** Return the rotation matrix of a rotation vector [deg] as a list of rows, by Rodrigues' formula. */
function rotationMatrix(x, y, z) {
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

/** Return the product of two 3 x 3 matrices. */
function multiply(left, right) {
  return left.map((row) =>
    [0, 1, 2].map((j) => row[0] * right[0][j] + row[1] * right[1][j] + row[2] * right[2][j]),
  );
}

/** Return a function from a time to the rotation matrix of a moving part. */
function buildOrientation(rotation) {
  const [times, x, y, z] = ["times", "x", "y", "z"].map((key) => decodeArray(rotation[key]));
  const orientations = [rotationMatrix(0, 0, 0)];
  for (let i = 0; i < x.length; i++) {
    orientations.push(multiply(orientations[i], rotationMatrix(x[i], y[i], z[i])));
  }
  return (time) => {
    let i = 0;
    for (let high = x.length; high - i > 1; ) {
      const middle = (i + high) >> 1;
      if (times[middle] <= time) i = middle;
      else high = middle;
    }
    const share = Math.min((time - times[i]) / (times[i + 1] - times[i]), 1);
    return multiply(orientations[i], rotationMatrix(share * x[i], share * y[i], share * z[i]));
  };
}

/**
 * Return the motion of a figure: its end, its phases, the indices of the moving traces, and
 * functions from a time to the names of the phases, and to the coordinates and opacities of the
 * moving traces.
 */
function buildMotion(figure) {
  const motion = figure.layout.meta.motion;
  const isActive = (time) => (phase) => phase.from <= time && time < phase.to;
  const phases = motion.phases || [];
  const orientations = {};
  for (const [name, vectors] of Object.entries(motion.rotations)) orientations[name] = buildOrientation(vectors);
  const which = [...figure.data.keys()].filter((k) => figure.data[k].meta && figure.data[k].meta.rotation);
  const parts = which.map((k) => {
    const { meta, x, y, z, opacity = 1 } = figure.data[k];
    return { ...meta, opacity, points: [x, y, z].map((values) => Array.from(decodeArray(values))) };
  });
  const names = (time) => phases.filter(isActive(time)).map((phase) => phase.name);
  const at = (time) => {
    const now = names(time);
    const change = { x: [], y: [], z: [], opacity: [] };
    for (const { rotation: name, faint, opacity, points } of parts) {
      const rows = orientations[name](time);
      ["x", "y", "z"].forEach((key, r) => {
        const [a, b, c] = rows[r];
        // A null coordinate is a gap in a line.
        const rotate = (x, i) => (x === null ? x : a * x + b * points[1][i] + c * points[2][i]);
        change[key].push(points[0].map(rotate));
      });
      change.opacity.push(now.includes(faint) ? 0.2 * opacity : opacity);
    }
    return change;
  };
  return { end: motion.end, phases, names, which, at };
}

/** Return the shaded phases as a CSS background of the time slider. */
function buildShading({ end, phases }) {
  const stops = phases.filter((phase) => phase.shaded && phase.from < end).map(({ from, to }) => {
    const [a, b] = [from, Math.min(to, end)].map((time) => `${(100 * time) / end}%`);
    return `transparent ${a}, var(--shade) ${a}, var(--shade) ${b}, transparent ${b}`;
  });
  return stops.length ? `linear-gradient(to right, ${stops.join(", ")})` : "none";
}

const SPEEDS = [1, 10, 50, 200];

/** Return the controls below an animated figure, which is still until "Play" is pressed. */
function buildPlayer(node, figure) {
  const motion = buildMotion(figure);
  const box = document.createElement("div");
  box.className = "player";
  box.innerHTML =
    '<button type=button></button><input type=range min=0 step=any aria-label="time">' +
    "<select aria-label=speed></select><output></output>";
  const [button, slider, speed, status] = box.children;
  slider.max = motion.end;
  slider.style.backgroundImage = buildShading(motion);
  for (const factor of SPEEDS) speed.add(new Option(`${factor}×`, factor, false, factor === 50));
  let time = 0;
  let before = null; // clock of the last frame while the figure plays, otherwise null
  let drawing = false;

  async function show() {
    slider.value = time;
    status.textContent = [`${time.toFixed(0)} s`, ...motion.names(time)].join(" · ");
    if (drawing) return;
    drawing = true;
    await Plotly.restyle(node, motion.at(time), motion.which);
    drawing = false;
  }
  function stop() {
    before = null;
    button.textContent = "Play";
  }
  function tick(clock) {
    if (before === null || !box.isConnected) return stop();
    time = Math.min(time + ((clock - before) / 1000) * Number(speed.value), motion.end);
    before = clock;
    show();
    if (time < motion.end) requestAnimationFrame(tick);
    else stop();
  }
  button.addEventListener("click", () => {
    if (before !== null) return stop();
    if (time >= motion.end) time = 0;
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

// Printed pages have still pictures: one at the start of each phase, and one at the end ------------
const MAX_STILLS = 9;

/** Return the times of the still pictures: the starts of the first phases, and the end. */
function listStillTimes({ end, phases }) {
  const starts = phases.filter((phase) => !phase.shaded && phase.from < end).map((phase) => phase.from);
  const times = [...new Set([0, ...starts])].sort((a, b) => a - b).slice(0, MAX_STILLS - 1);
  return [...times, end];
}

/** Return the projection of a point for the eye of a plotly camera: right, down, toward the eye. */
function buildProjection({ x, y, z }) {
  const far = Math.hypot(x, y, z);
  const flat = Math.hypot(x, y) || 1;
  const across = [-y / flat, x / flat, 0];
  const [a, b, c] = [x / far, y / far, z / far];
  const up = [b * across[2] - c * across[1], c * across[0] - a * across[2], a * across[1] - b * across[0]];
  const dot = (v, p) => v[0] * p[0] + v[1] * p[1] + v[2] * p[2];
  return (point) => [dot(across, point), -dot(up, point), dot([a, b, c], point)];
}

/** Return an SVG element with attributes. */
function createSvg(name, attributes) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  return node;
}

/** Return the corners of the convex hull of plane points in order, by Andrew's monotone chain. */
function computeHull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const buildHalf = (points) => {
    const chain = [];
    for (const p of points) {
      while (chain.length > 1) {
        const [a, b] = chain.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) > (b[1] - a[1]) * (p[0] - a[0])) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...buildHalf(sorted), ...buildHalf(sorted.reverse())];
}

/**
 * Return the SVG elements of a trace, each with its distance toward the eye. A mesh is drawn as its
 * outline.
 */
function drawShapes(trace, points, project) {
  const gap = (x) => x === null || Number.isNaN(x);
  const flat = points[0].map((x, i) => (gap(x) ? null : project([x, points[1][i], points[2][i]])));
  const at = (p) => `${p[0].toFixed(3)},${p[1].toFixed(3)}`;
  const near = (some) => some.reduce((sum, p) => sum + p[2], 0) / some.length;
  const { opacity = 1, mode = "lines", marker = {}, line = {} } = trace;
  const look = (part) => (typeof part.color === "string" ? part.color : "#767676");
  if (trace.type === "mesh3d") {
    const some = flat.filter(Boolean);
    const fill = trace.color || "#9aa3ad";
    return [[near(some), createSvg("polygon", { points: computeHull(some).map(at).join(" "), fill, opacity: 0.6 * opacity })]];
  }
  const drawn = [];
  let run = [];
  for (const point of mode.includes("lines") ? [...flat, null] : []) {
    if (point) run.push(point);
    else if (run.length) {
      const stroke = { fill: "none", stroke: look(line), opacity, "stroke-width": 0.006 * (line.width || 2) };
      drawn.push([near(run), createSvg("polyline", { points: run.map(at).join(" "), ...stroke })]);
      run = [];
    }
  }
  const each = (value, i) => (Array.isArray(value) ? value[i] : value);
  flat.forEach((point, i) => {
    if (!point) return;
    const size = each(marker.size === undefined ? 6 : marker.size, i);
    if (mode.includes("markers") && size) {
      drawn.push([point[2], createSvg("circle", { cx: point[0], cy: point[1], r: 0.006 * size, fill: look(marker), opacity })]);
    }
    if (mode.includes("text") && each(trace.text, i)) {
      const label = createSvg("text", { x: point[0] + 0.03, y: point[1] - 0.03, "font-size": 0.17, fill: "#222222" });
      label.textContent = each(trace.text, i);
      drawn.push([9, label]);
    }
  });
  return drawn;
}

/** Return the still pictures of an animated figure for the printed page. */
function buildStills(figure) {
  const motion = buildMotion(figure);
  const eye = ((figure.layout.scene || {}).camera || {}).eye || { x: 1.25, y: 1.25, z: 1.25 };
  const project = buildProjection(eye);
  const box = document.createElement("div");
  box.className = "stills printed-only";
  const coordinates = figure.data.map((trace) => ["x", "y", "z"].map((key) => Array.from(decodeArray(trace[key] || []))));
  const isDrawable = figure.data.map((trace) => trace.type === "mesh3d" || trace.type === "scatter3d");
  let size = 1;
  for (const [k, points] of coordinates.entries()) {
    if (isDrawable[k]) points[0].forEach((x, i) => x !== null && !Number.isNaN(x) && (size = Math.max(size, Math.hypot(x, points[1][i], points[2][i]))));
  }
  for (const time of listStillTimes(motion)) {
    const now = motion.at(time);
    const all = figure.data.flatMap((trace, k) => {
      if (!isDrawable[k] || trace.visible === false) return [];
      const index = motion.which.indexOf(k);
      const points = index < 0 ? coordinates[k] : ["x", "y", "z"].map((key) => now[key][index]);
      return drawShapes(index < 0 ? trace : { ...trace, opacity: now.opacity[index] }, points, project);
    });
    all.sort((a, b) => a[0] - b[0]);
    const extent = 1.1 * size;
    const picture = createSvg("svg", { viewBox: `${-extent} ${-extent} ${2 * extent} ${2 * extent}`, role: "img" });
    picture.append(...all.map(([, node]) => node));
    const caption = document.createElement("figcaption");
    caption.textContent = [`${time.toFixed(0)} s`, ...motion.names(time)].join(" · ");
    box.appendChild(document.createElement("figure")).append(picture, caption);
  }
  return box;
}

// Figures of one solution ---------------------------------------------------------------------

// Animated figures are drawn when they scroll into view, so that the page opens without delay.
const observer = new IntersectionObserver(
  (entries) => entries.filter((entry) => entry.isIntersecting).forEach(({ target }) => play(target)),
  { rootMargin: "200px" },
);

async function play(box) {
  observer.unobserve(box);
  const figure = box.moving;
  await draw(box.firstChild, figure, false);
  if (box.moving !== figure) return; // Another solution was selected meanwhile.
  box.replaceChildren(box.firstChild, buildPlayer(box.firstChild, figure), buildStills(figure));
}

/** Draw figures, an object by name, into the cells of a grid. */
function drawGrid(box, figures) {
  const names = Object.keys(figures);
  while (box.children.length > names.length) box.lastChild.remove();
  while (box.children.length < names.length) {
    box.appendChild(document.createElement("div")).appendChild(document.createElement("div"));
  }
  return Promise.all(names.map((name, i) => {
    const place = box.children[i];
    const figure = figures[name];
    place.firstChild.dataset.name = name; // for its description, if the figure has no title
    place.classList.toggle("moving", "motion" in (figure.layout.meta || {}));
    place.moving = (figure.layout.meta || {}).motion ? figure : null;
    place.replaceChildren(place.firstChild); // Remove the controls of the previous figure.
    observer.unobserve(place);
    if (!place.moving) return draw(place.firstChild, figure, false);
    place.appendChild(buildStills(figure));
    place.firstChild.style.minHeight = `${figure.layout.height || 400}px`;
    observer.observe(place);
  }));
}
