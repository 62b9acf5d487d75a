// The polhode on the momentum sphere, among those of other energies.
const inPrincipal = m => inertia.axes.map(axis => dot(axis, m));
const onSphere = rigid ? [...Array(count).keys()].map(k => unit(inPrincipal(momentum(k)))) : [];
function paintPolhode(frame) {
  const { project } = frame;
  ball(frame);
  for (const curve of inertia.others) path(frame, curve, "#aab4bf", .8, .35);
  for (const curve of inertia.separatrix) path(frame, curve, "#16202c", 1.5, .3, [6, 4]);
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
