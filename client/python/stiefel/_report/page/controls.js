// Time, keys and pointer.
const views = [];
function draw() {
  for (const view of views) view.draw();
  drawRates();
  drawAccuracy();
  const t = time(), step = t / scene.step;
  const k = Math.floor(now), utc = instants ? `, ${new Date(instants[k] + (t - at[k]) * 1000).toISOString().slice(0, 19).replace("T", " ")} UTC` : "";
  $("time").value = Math.round(now);
  $("now").textContent = `time ${short(t, 6)}${seconds}${clock[0] > 1 ? ` = ${(t / clock[0]).toFixed(2)} ${clock[1].slice(2, -1)}` : ""}, step ${Number.isInteger(+step.toFixed(6)) ? Math.round(step) : step.toFixed(1)}${utc}`;
  $("time").setAttribute("aria-valuetext", $("now").textContent);
}
function go(index) { now = Math.max(0, Math.min(count - 1, index)); draw(); }
let playing = null;
function play(on) {
  if (on && now >= count - 1) now = 0;
  playing = on ? performance.now() : null;
  $("play").textContent = on ? "Stop" : "Play";
  $("play").setAttribute("aria-pressed", on);
  if (on) requestAnimationFrame(advance);
}
function advance(clock) {
  if (playing === null) return;
  go(now + Math.max(0, clock - playing) / 1000 * $("speed").value * turn);
  playing = clock;
  now >= count - 1 ? play(false) : requestAnimationFrame(advance);
}
describe();
$("time").max = count - 1;
for (const [v, text] of [[.05, "1/20 turn a second"], [.2, "1/5 turn a second"], [1, "1 turn a second"], [5, "5 turns a second"]]) $("speed").add(new Option(text, v, v === .2, v === .2));
$("window").add(new Option("all that is shown", 0));
for (const n of [1, 3, 10, 30]) if (D.turn && n * D.turn < Math.abs(span) * .8) $("window").add(new Option(n === 1 ? "1 turn" : `${n} turns`, n * D.turn * Math.sign(span)));
const initial = [...$("window").options].find(o => o.text === "10 turns");
if (initial && Math.abs(span) > 30 * D.turn) initial.selected = true;
if (!$("body").hidden) views.push(new View("body", bodies ? paintBody : paintFrame, [.6, .35]));
if (rigid) {
  // The axis that the momentum circles is turned towards the viewer.
  const u = onSphere[0], level = dot(u, u.map((x, i) => x / inertia.moments[i])) * inertia.moments[1];
  views.push(new View("polhode", paintPolhode, level < 1 ? [.6, u[2] < 0 ? -.9 : .9] : [.5 + (u[0] < 0 ? Math.PI : 0), .35]));
}
if (!$("body").hidden && !bodies && coordinates > 3) {
  $("axes").hidden = false;
  [...$("axes").querySelectorAll("select")].forEach((select, i) => {
    for (let j = 0; j < coordinates; ++j) select.add(new Option(j, j, j === i, j === i));
    select.addEventListener("change", () => { chosen[i] = +select.value; draw(); });
  });
}
$("time").addEventListener("input", () => { play(false); go(+$("time").value); });
$("play").addEventListener("click", () => play(playing === null));
$("window").addEventListener("change", draw);
document.addEventListener("keydown", e => {
  if (e.key !== " " || /^(BUTTON|SELECT)$/.test(e.target.tagName)) return;
  e.preventDefault();
  play(playing === null);
});
const rates = document.querySelector("#rates canvas");
const goTo = e => go((ratesAxis.time(e.offsetX) * clock[0] - at[0]) / span * (count - 1));
rates.addEventListener("pointerdown", e => { rates.setPointerCapture(e.pointerId); play(false); goTo(e); });
rates.addEventListener("pointermove", e => { if (e.buttons) goTo(e); });
rates.addEventListener("keydown", e => {
  const by = { ArrowLeft: -1, ArrowRight: 1, PageDown: -count / 10, PageUp: count / 10, Home: -count, End: count }[e.key];
  if (by) { e.preventDefault(); play(false); go(Math.round(now + by)); }
});
function drawAll() { draw(); if (D.tradeoff) drawFront(); }
window.addEventListener("resize", drawAll);
window.addEventListener("beforeprint", drawAll);
drawAll();
