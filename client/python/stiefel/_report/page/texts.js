// Titles, captions, tables, and the scene.
function errorText() {
  const e = D.error.last;
  if (!e) return "The error was not estimated.";
  if (e.missing) return `Not estimated: ${e.missing}.`;
  const known = ["attitude", "momentum"].map(name => `${name} ${typeof e[name] === "number" ? short(e[name], 2) : `below ${short(2 * e.reference_error, 2)}`}`);
  return `At the last step: ${known.join(", ")}, beside ${e.reference}.`;
}
/** Returns a unit of the scenes that have units, those with `body`. */
const unitOf = name => scene.body ? ` ${name}` : "";
/** Returns what the principal axes are in the body axes in which the rates are drawn. */
function axesText() {
  const vector = axis => `(${axis.map(x => short(Math.abs(x) < 1e-9 ? 0 : x, 3)).join(", ")})`;
  return inertia.names[0] === "a" ? ` In the body axes x, y, z of \u03c9: ${inertia.names.map((name, i) => `${name} = ${vector(inertia.axes[i])}`).join(", ")}.` : "";
}
function describe() {
  const s = scene, method = s.method ? s.method.name + (s.method.order ? ` of order ${s.method.order}` : "") : "a discrete system";
  document.title = `${D.name} \u2013 stiefel`;
  $("title").textContent = D.name;
  $("subtitle").textContent = `${s.system}, ${method}, ${D.to} steps of ${short(s.step, 6)}${seconds}` +
    (s.method && s.method.substeps > 1 ? ` with ${s.method.substeps} substeps each` : "") +
    `, up to time ${short(whole, 6)}${seconds}` + (D.epoch ? ` after ${D.epoch}` : "") + (D.member === null ? "" : `; member ${D.member} of ${s.members}`);
  if (D.character) $("character").textContent = D.character + (D.turn ? `, about ${short(Math.abs(whole) / D.turn, 3)} turns.` : ".");
  $("shown").textContent = Math.abs(span) < Math.abs(whole) * (1 - 1e-9)
    ? `The body and the rates are shown up to time ${short(at[count - 1], 5)}${seconds} in ${count} samples; drift and error over the whole run.`
    : `${count} samples.`;
  if (D.choice) $("shown").textContent += ` The method was chosen: ${D.choice}`;
  if (D.outcome !== "REACHED") {
    $("stopped").hidden = false;
    $("stopped").textContent = `${D.outcome} after step ${D.to}: ${D.message}`;
  }
  $("build").textContent = `stiefel ${D.version}, numerics id ${D.numerics_id}. ` +
    "A build with this numerics id gives the same numbers to the last bit.";
  $("again").textContent = `stiefel report ${D.file} --to ${D.to}\n\nimport stiefel\nstiefel.simulate("${D.file}", to=${D.to}).report("report.html")`;
  $("scene").textContent = D.whole_scene ? D.scene : "The arrays of the initial state are too large for this page: " + D.scene;
  $("save").hidden = !D.whole_scene;
  $("save").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([D.scene + "\n"], { type: "application/json" }));
    link.download = D.file.endsWith(".json") ? D.file : D.file + ".json";
    link.click();
  });
  const row = (cells, kind) => { const tr = $("invariants").insertRow(); for (const c of cells) { const cell = document.createElement(kind); cell.textContent = c; tr.append(cell); } };
  row(["family", "invariants", "largest relative drift over the run (1)", "the method keeps it"], "th");
  for (const f of D.drift.families) row([f.name, f.count || "", short(Math.max(...f.drift), 2), f.conservation], "td");
  const caption = (id, text) => { document.querySelector(`#${id} figcaption`).textContent = text; document.querySelector(`#${id} canvas`).setAttribute("aria-label", text); };
  document.querySelector("#body h2").textContent = bodies ? "The body in space" : "The frame, projected on three coordinates";
  caption("body", bodies ? `A box with the body's moments of inertia, its principal axes ${inertia.names.join(", ")} (moments ${inertia.moments.map(I => short(I)).join(", ")}${unitOf("kg m\u00b2")}), ` +
    "the constant angular momentum L and the spin axis \u03c9 (dashed) with its path. Drag or use the arrow keys to turn the view." + axesText()
    : (vectors === 1 ? "The vector q, with the path of its end over about a turn." : `${byRows ? "Rows" : "Columns"} 0 to ${vectors - 1} of Q, with the paths of their ends over about a turn.`)
      + (coordinates > 3 ? " An end inside the circle has components along other coordinates too." : ""));
  caption("polhode", rigid ? `The momentum in the body, divided by its norm, on axes ${inertia.names.join(", ")} (smallest to largest moment). ` +
    (inertia.separatrix.length ? "Dashed: the separatrix; grey: other energies. " : "") + "The dot is the present." : "");
  document.querySelector("#rates h2").textContent = D.rates.title;
  caption("rates", "Click, drag or use the arrow keys to move the time." + (rigid ? axesText() : ""));
  caption("drift", "The largest relative drift in each family of invariants, not below the rounding unit 1.1e-16. A small drift does not mean a small error.");
  caption("error", (errors.length ? "On the scale of the drifts. An error too small to tell is drawn as its bound. " : "") + errorText());
  document.querySelector("#error canvas").hidden = !errors.length;
  if (D.tradeoff) caption("front", `Errors at time ${short(D.tradeoff.horizon)}${seconds}, ${Math.abs(D.tradeoff.horizon - Math.abs(whole)) <= Math.abs(scene.step) ? "the end of this run" : "not the end of this run"}. No point beats those of the Pareto front in both work and error.`);
  $("front").hidden = !D.tradeoff;
  $("polhode").hidden = !rigid;
  $("body").hidden = !Q || complex;
}
