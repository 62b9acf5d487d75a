// The polhode on the momentum sphere, among those of other energies.
const inPrincipal = m => inertia.axes.map(axis => dot(axis, m));
const onSphere = rigid ? [...Array(count).keys()].map(k => unit(inPrincipal(momentum(k)))) : [];
/** Returns the closed curves of the sphere on which twice the energy over |m|^2 is `level`, around the axes +-k. */
function levels(level, k) {
  const inverse = inertia.moments.map(I => 1 / I), [i, j] = [(k + 1) % 3, (k + 2) % 3];
  const [a, b] = [i, j].map(n => Math.sqrt((level - inverse[k]) / (inverse[n] - inverse[k])));
  return [1, -1].map(sign => [...Array(121).keys()].map(n => {
    const v = [0, 0, 0], phi = n / 60 * Math.PI;
    [v[i], v[j]] = [a * Math.cos(phi), b * Math.sin(phi)];
    v[k] = sign * Math.sqrt(Math.max(0, 1 - v[i] ** 2 - v[j] ** 2));
    return v;
  }));
}
function separatrix() {
  const [a, b, c] = inertia.moments.map(I => 1 / I), s = Math.sqrt((a - b) / (b - c)), d = unit([1, 0, s]);
  return [1, -1].map(sign => [...Array(121).keys()].map(n => {
    const [x, y] = [Math.cos(n / 60 * Math.PI), Math.sin(n / 60 * Math.PI)];
    return [x * d[0], y, sign * x * d[2]];
  }));
}
const [least, middle, most] = inertia ? inertia.moments : [0, 0, 0];
const threeMoments = inertia && middle - least > 1e-9 * most && most - middle > 1e-9 * most;
function paintPolhode(frame) {
  const { project } = frame;
  ball(frame);
  if (threeMoments) {
    for (const u of [.25, .5, .75]) {
      for (const curve of levels(1 / most + u * (1 / middle - 1 / most), 2)) path(frame, curve, "#aab4bf", .8, .35);
      for (const curve of levels(1 / least + u * (1 / middle - 1 / least), 0)) path(frame, curve, "#aab4bf", .8, .35);
    }
    for (const curve of separatrix()) path(frame, curve, "#16202c", 1.5, .3, [6, 4]);
  }
  const [from, to] = visible(), step = Math.max(1, Math.floor((to - from) / 4000)), points = [];
  for (let k = from; k <= to; k += step) points.push(onSphere[k]);
  path(frame, points, COLOURS[0], 2.4, .3);
  for (const sign of [1, -1]) inertia.names.forEach((name, i) => {
    const v = [0, 0, 0]; v[i] = sign;
    const [x, y, depth] = project(v), [X, Y] = project(scaled(v, 1.1));
    frame.g.globalAlpha = depth >= 0 ? 1 : .35;
    frame.g.beginPath(); frame.g.arc(x, y, 3, 0, 7); frame.g.fillStyle = "#16202c"; frame.g.fill();
    label(frame.g, (sign < 0 ? "\u2212" : "+") + name, X, Y, "#16202c");
    frame.g.globalAlpha = 1;
  });
  const p = project(unit(between(k => onSphere[k], now)));
  frame.g.globalAlpha = p[2] >= 0 ? 1 : .45;
  point(frame, p, COLOURS[1]);
  frame.g.globalAlpha = 1;
}
