// Curves over time, and error against cost.
function ticks(low, high, most) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough)), step = power * [1, 2, 5, 10].find(f => f * power >= rough);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(+(k * step).toPrecision(12));
  return found;
}
const power = e => "1e" + e;
/** Draws series {name, x, y, k, marks, colour} and returns the functions between pixels and x. Nulls are gaps. */
function curves(id, series, { x, y, logX = false, log = false, domain, range, cursor = null }) {
  const canvas = document.querySelector(`#${id} canvas`), { g, width, height } = prepare(canvas);
  const shown = series.filter(s => s.name), rows = [];
  let room = 0;
  for (const s of shown) {
    const wide = g.measureText(s.name).width + 48;
    if (!rows.length || room + wide > width - 60) { rows.push([]); room = 0; }
    rows.at(-1).push([s, room]);
    room += wide;
  }
  const box = { left: 68, right: width - 20, top: 8 + 18 * rows.length, bottom: height - 38 };
  const [x0, x1] = domain, [y0, y1] = range, f = log ? Math.log10 : v => v, fx = logX ? Math.log10 : v => v;
  const px = v => box.left + (fx(v) - fx(x0)) / (fx(x1) - fx(x0) || 1) * (box.right - box.left);
  const py = v => box.bottom - (f(v) - f(y0)) / (f(y1) - f(y0) || 1) * (box.bottom - box.top);
  const powers = (a, b) => {
    const [e0, e1] = [Math.ceil(Math.log10(a) - 1e-9), Math.floor(Math.log10(b) + 1e-9)], every = Math.max(1, Math.ceil((e1 - e0) / 7));
    return [...Array(Math.max(0, e1 - e0 + 1)).keys()].map(k => e0 + k).filter(e => (e - e0) % every === 0);
  };
  Object.assign(g, { strokeStyle: "#e4e9ee", fillStyle: "#3b4754", lineWidth: 1, textBaseline: "middle" });
  const line = (a, b, c, d) => { g.beginPath(); g.moveTo(a, b); g.lineTo(c, d); g.stroke(); };
  const [ny, nx] = [Math.max(3, Math.floor(height / 60)), Math.max(3, Math.floor(width / 95))];
  for (const [v, text] of log ? powers(y0, y1).map(e => [10 ** e, power(e)]) : ticks(y0, y1, ny).map(v => [v, short(v)])) {
    line(box.left, py(v), box.right, py(v)); g.textAlign = "right"; g.fillText(text, box.left - 6, py(v));
  }
  for (const [v, text] of logX ? powers(x0, x1).map(e => [10 ** e, power(e)]) : ticks(x0, x1, nx).map(v => [v, short(v)])) {
    line(px(v), box.top, px(v), box.bottom);
    g.textAlign = "center"; g.fillText(text, Math.min(px(v), width - g.measureText(text).width / 2), box.bottom + 11);
  }
  g.fillText(x, (box.left + box.right) / 2, box.bottom + 28);
  g.save(); g.translate(10, (box.top + box.bottom) / 2); g.rotate(-Math.PI / 2); g.fillText(y, 0, 0); g.restore();
  g.save();
  g.beginPath(); g.rect(box.left, box.top - 4, box.right - box.left + 6, box.bottom - box.top + 8); g.clip();
  for (const s of series) {
    Object.assign(g, { strokeStyle: s.colour || COLOURS[s.k % 6], fillStyle: s.colour || COLOURS[s.k % 6], lineWidth: s.width || 1.7 });
    g.setLineDash(s.dash || DASHES[(s.k || 0) % 6]);
    g.beginPath();
    let pen = false;
    for (let k = 0; k < s.x.length; ++k) {
      if (s.y[k] === null || !Number.isFinite(s.y[k])) { pen = false; continue; }
      pen ? g.lineTo(px(s.x[k]), py(s.y[k])) : g.moveTo(px(s.x[k]), py(s.y[k]));
      pen = true;
    }
    if (!s.bare) g.stroke();
    g.setLineDash([]);
    if (s.marks) s.x.forEach((v, k) => { if (s.y[k] !== null) { g.beginPath(); g.arc(px(v), py(s.y[k]), s.marks, 0, 7); s.hollow ? g.stroke() : g.fill(); } });
  }
  if (cursor !== null) { Object.assign(g, { strokeStyle: "#16202c", lineWidth: 1 }); g.setLineDash([3, 3]); line(px(cursor), box.top, px(cursor), box.bottom); g.setLineDash([]); }
  g.restore();
  rows.forEach((row, r) => row.forEach(([s, left]) => {
    const [X, Y] = [box.left + left, 9 + 18 * r];
    Object.assign(g, { strokeStyle: s.colour || COLOURS[s.k % 6], fillStyle: s.colour || COLOURS[s.k % 6], lineWidth: 2 });
    g.setLineDash(s.dash || DASHES[(s.k || 0) % 6]);
    if (!s.bare) line(X, Y, X + 28, Y);
    g.setLineDash([]);
    if (s.marks) { g.beginPath(); g.arc(X + 14, Y, s.marks, 0, 7); s.hollow ? g.stroke() : g.fill(); }
    Object.assign(g, { fillStyle: "#16202c", textAlign: "left" });
    g.fillText(s.name, X + 33, Y);
  }));
  return { time: pixel => x0 + (pixel - box.left) / (box.right - box.left) * (x1 - x0) };
}

const rated = D.rates.curves.map(c => ({ name: c.name, y: decode(c) })), rateRange = (([low, high]) => {
  const pad = .06 * (high - low) || Math.abs(high) * .1 || 1;
  return [low - pad, high + pad];
})(rated.map(s => extent(s.y)).reduce((a, b) => [Math.min(a[0], b[0]), Math.max(a[1], b[1])]));
let ratesAxis = null;
function drawRates() {
  const [from, to] = visible(), step = Math.max(1, Math.floor((to - from) / 3000)), index = [];
  for (let k = from; k <= to; k += step) index.push(k);
  const x = index.map(k => at[k] / clock[0]);
  ratesAxis = curves("rates", rated.map((s, k) => ({ name: s.name, k, x, y: index.map(n => s.y[n]) })),
    { x: `time${clock[1]}`, y: `${rigid ? "\u03c9" : D.rates.title.split(":")[0]}${rigid && seconds ? " (rad/s)" : " (1)"}`, domain: [at[from] / clock[0], at[to] / clock[0]], range: rateRange, cursor: time() / clock[0] });
}

// Drift and error have one scale, so that the two panels can be compared.
const FLOOR = 2 ** -53, above = y => y === null ? null : Math.max(y, FLOOR);
const inClock = list => list.map(t => t / clock[0]);
const families = D.drift.families.map((f, k) => ({ name: f.name, k, x: inClock(D.drift.time), y: f.drift.map(above), marks: D.drift.time.length < 4 ? 3 : 0 }));
const errors = D.error.time.length ? [["attitude", 0], ["momentum", 1]].map(([name, k]) =>
  ({ name, k, x: inClock(D.error.time), y: D.error[name].map(above), marks: 3 })).filter(s => s.y.some(v => v !== null)) : [];
const accuracy = (() => {
  const all = [...families, ...errors].flatMap(s => s.y).filter(v => v !== null && Number.isFinite(v));
  const top = all.length ? Math.max(...all) : 1;
  return [FLOOR / 2, 10 ** Math.ceil(Math.log10(Math.max(top, 1e-14)) + .1)];
})();
function drawAccuracy() {
  const frame = y => ({ x: `time${clock[1]}`, y, log: true, domain: [0, (whole || 1) / clock[0]], range: accuracy, cursor: time() / clock[0] });
  curves("drift", families, frame("relative drift (1)"));
  if (errors.length) curves("error", errors, frame("estimated error (1)"));
}
function drawFront() {
  const { points, reference_error: known } = D.tradeoff, ok = points.filter(p => p.error !== null);
  const value = p => Math.max(p.error, known), front = ok.filter(p => p.front).sort((a, b) => a.work - b.work);
  const works = ok.map(p => p.work), errors = ok.map(value), pad = 1.6;
  curves("front", [
    { name: "all methods", colour: "#9aa6b2", x: works, y: errors, marks: 2.2, bare: true },
    { name: "Pareto front", colour: "#16202c", x: front.map(p => p.work), y: front.map(value), width: 2, dash: [] },
    ...[...new Set(front.map(p => p.method))].map((name, k) => ({ name, k, bare: true, marks: 4.5, hollow: k >= 6,
      x: front.filter(p => p.method === name).map(p => p.work), y: front.filter(p => p.method === name).map(value) })),
    { name: `error of the reference`, colour: "#5a6673", dash: [2, 3], x: [Math.min(...works) / pad, Math.max(...works) * pad], y: [known, known], width: 1 },
  ], { x: "work (instructions)", y: "error at the end of the run (1)", logX: true, log: true,
       domain: [Math.min(...works) / pad, Math.max(...works) * pad * 2], range: [Math.min(known, ...errors) / 3, Math.max(...errors) * 3] });
}
