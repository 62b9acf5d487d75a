// The body in space, or the frame, at the present time.
let now = 0;  // a real sample index
/** Returns the indices of the samples in the time window around the present. */
function visible() {
  const width = +$("window").value, t = time();
  if (!width) return [0, count - 1];
  const start = Math.max(at[0], Math.min(t - width / 2, at[count - 1] - width));
  const index = when => Math.round((when - at[0]) / span * (count - 1));
  return [Math.max(0, index(start)), Math.min(count - 1, index(start + width))];
}
const time = () => between(k => at[k], now);
const trail = (f, length) => {
  const end = Math.floor(now), from = Math.max(0, end - length), step = Math.max(1, Math.floor((end - from) / 1500)), points = [];
  for (let k = from; k < end; k += step) points.push(f(k));
  return [...points, between(f, now)];
};
const turn = D.turn && span ? Math.max(8, Math.round(D.turn / Math.abs(span) * (count - 1))) : 60;  // samples in one turn

function paintBody(frame) {
  const { g, project } = frame;
  const R = orthogonal(between(attitude, now)), m = between(momentum, now), L = unit(times(R, m));
  const spin = k => unit(times(attitude(k), velocity(momentum(k))));
  "XYZ".split("").forEach((name, i) => {
    const end = [0, 0, 0]; end[i] = 1.02;
    arrow(frame, [0, 0, 0], end, "#a3adb8", 1, name);
  });
  // Half lengths of the box with these moments: the second moment of mass along an axis is a third of their squares.
  const total = inertia.moments.reduce((a, b) => a + b) / 2;
  const squares = inertia.moments.map(I => Math.max(total - I, total * .012)), size = .78 / Math.sqrt(squares.reduce((a, b) => a + b));
  const half = squares.map(s => size * Math.sqrt(s)), axes = inertia.axes.map(axis => times(R, axis));
  const light = unit([.5, .35, 1]);
  /** Returns the point where the ray from the centre leaves the box. */
  const leaves = d => scaled(d, Math.min(...axes.map((axis, i) => half[i] / Math.max(1e-9, Math.abs(dot(axis, d))))));
  const W = unit(times(R, velocity(m)));
  const arrows = [[L, .98, "#16202c", 2.6, "L", []], [W, .82, "#b0568d", 2.4, "\u03c9", [7, 3]],
                  ...axes.map((axis, i) => [axis, half[i] + .2, COLOURS[i], 2, inertia.names[i], []])];
  const draw = front => arrows.filter(([d]) => (project(d)[2] >= 0) === front).forEach(([d, length, colour, width, name, dash]) =>
    arrow(frame, front ? leaves(d) : [0, 0, 0], scaled(d, length), colour, width, name, dash, d === W));
  path(frame, trail(k => scaled(spin(k), .82), 4 * turn), "#b0568d", 1.3, .35, [2, 3]);
  path(frame, trail(k => scaled(times(attitude(k), inertia.axes[0]), half[0] + .2), 2 * turn), COLOURS[0], 1.2, .35);
  draw(false);
  const faces = [];
  axes.forEach((axis, i) => {
    const [u, v] = [(i + 1) % 3, (i + 2) % 3];
    for (const side of [1, -1]) faces.push({ i, side, normal: scaled(axis, side), corners: [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) =>
      [0, 1, 2].map(k => side * half[i] * axis[k] + a * half[u] * axes[u][k] + b * half[v] * axes[v][k])) });
  });
  for (const face of faces.filter(f => project(f.normal)[2] > 0)) {
    const shade = 62 + 28 * Math.max(0, dot(face.normal, light)) + (face.side > 0 ? 0 : 6), pixels = face.corners.map(project);
    g.beginPath(); pixels.forEach(([x, y], k) => k ? g.lineTo(x, y) : g.moveTo(x, y)); g.closePath();
    Object.assign(g, { fillStyle: `hsl(${[203, 26, 164][face.i]},${face.side > 0 ? 45 : 22}%,${shade}%)`, strokeStyle: "#3b4754", lineWidth: 1.1 });
    g.fill(); g.stroke();
  }
  draw(true);
}

// Frames in more dimensions, projected on three coordinates.
const byRows = Q && Q.rows < Q.cols, vectors = Q ? Math.min(6, byRows ? Q.rows : Q.cols) : 0, coordinates = Q ? (byRows ? Q.cols : Q.rows) : 0;
let chosen = [0, 1, 2];
const vector = i => k => chosen.map(j => j < coordinates ? (byRows ? entry(Q, k, i, j) : entry(Q, k, j, i)) : 0);
function paintFrame(frame) {
  const { g, width, height, radius, project } = frame;
  g.beginPath(); g.arc(width / 2, height / 2, radius, 0, 7);
  Object.assign(g, { strokeStyle: "#c3ccd5", lineWidth: 1 });
  g.stroke();
  chosen.forEach((name, i) => {
    const end = [0, 0, 0]; end[i] = 1.22;  // past the names of the frame's vectors
    arrow(frame, [0, 0, 0], end, "#a3adb8", 1, `x[${name}]`);
  });
  const all = [...Array(vectors).keys()];
  all.forEach(i => path(frame, trail(vector(i), turn), COLOURS[i], 1.3, .5, DASHES[i]));
  all.map(i => ({ i, end: between(vector(i), now) })).sort((a, b) => project(a.end)[2] - project(b.end)[2])
    .forEach(({ i, end }) => arrow(frame, [0, 0, 0], end, COLOURS[i], 2.4, Q.rows === 1 ? "q" : i));
}
