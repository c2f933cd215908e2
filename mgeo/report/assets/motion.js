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
  const turns = {};
  for (const [name, turn] of Object.entries(motion.turns)) turns[name] = orientation(turn);
  const which = [...figure.data.keys()].filter((k) => figure.data[k].meta && figure.data[k].meta.turn);
  const parts = which.map((k) => {
    const { meta, x, y, z, opacity = 1 } = figure.data[k];
    return { ...meta, opacity, points: [x, y, z].map((values) => Array.from(numbers(values))) };
  });
  const names = (time) => phases.filter(lasting(time)).map((phase) => phase.name);
  const at = (time) => {
    const now = names(time);
    const change = { x: [], y: [], z: [], opacity: [] };
    for (const { turn, faint, opacity, points } of parts) {
      const rows = turns[turn](time);
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
