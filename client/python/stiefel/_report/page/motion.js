// The motion: fields of the samples, attitudes, momenta, principal axes.
const samples = D.samples, at = decode(samples.time), count = at.length, instants = samples.utc && decode(samples.utc);
const fields = Object.fromEntries(Object.entries(samples.fields).map(([name, f]) => [name, { ...f, values: decode(f) }]));
const Q = fields.Q || fields.q;
const right = D.side === "right", complex = Boolean(Q && Q.complex);
const inertia = D.inertia, rigid = Boolean(inertia), bodies = rigid && Q && Q.rows === 3 && Q.cols === 3;
const whole = D.horizon, clock = !scene.body ? [1, " (1)"] : Math.abs(whole) >= 2 * 86400 ? [86400, " (days)"] : Math.abs(whole) >= 7200 ? [3600, " (hours)"] : [1, " (s)"];
const span = at[count - 1] - at[0], seconds = scene.body ? " s" : "";

const entry = (f, k, i, j) => f.values[(k * f.rows + i) * f.cols + j];
/** Returns the rotation from body to space at sample k. */
const attitude = k => [0, 1, 2].map(i => [0, 1, 2].map(j => right ? entry(Q, k, j, i) : entry(Q, k, i, j)));
/** Returns the momentum in the caller's body axes at sample k. */
const momentum = k => scaled([entry(fields.M, k, 2, 1), entry(fields.M, k, 0, 2), entry(fields.M, k, 1, 0)], right ? -1 : 1);

/** Returns the angular velocity in the caller's body axes for a momentum. */
const velocity = m => inertia.axes.reduce((sum, axis, i) => sum.map((x, j) => x + dot(axis, m) / inertia.moments[i] * axis[j]), [0, 0, 0]);

/** Interpolates a function of the sample index linearly, for a real index. */
function between(f, s) {
  const k = Math.min(Math.floor(s), count - 2 < 0 ? 0 : count - 2), u = s - k;
  if (u === 0 || count < 2) return f(Math.round(s));
  const mix = (a, b) => Array.isArray(a) ? a.map((x, i) => mix(x, b[i])) : a + u * (b - a);
  return mix(f(k), f(k + 1));
}
/** Returns the nearest rotation by Gram and Schmidt, which keeps a reflection. */
function orthogonal(R) {
  const [a, b, c] = transposed(R), x = unit(a), y = unit(b.map((t, i) => t - dot(b, x) * x[i]));
  const z = unit(c.map((t, i) => t - dot(c, x) * x[i] - dot(c, y) * y[i]));
  return transposed([x, y, z]);
}
