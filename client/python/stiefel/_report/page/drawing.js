// Drawing on a canvas: views of space that can be turned, paths, arrows, labels.
function prepare(canvas) {
  const scale = window.devicePixelRatio || 1, { width, height } = canvas.getBoundingClientRect();
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const g = canvas.getContext("2d");
  g.setTransform(scale, 0, 0, scale, 0, 0);
  g.font = '12.5px system-ui, "DejaVu Sans", Arial, sans-serif';
  g.lineJoin = g.lineCap = "round";
  Object.assign(canvas, { shownWidth: width, shownHeight: height });
  return { g, width, height };
}
/** Writes a text, as near to (x, y) as it is inside the canvas. */
function label(g, text, x, y, colour, align = "center") {
  const wide = g.measureText(text).width + 3, left = { left: 2, center: wide / 2, right: wide }[align];
  x = Math.max(left, Math.min(x, g.canvas.shownWidth - wide + left));
  y = Math.max(8, Math.min(y, g.canvas.shownHeight - 8));
  Object.assign(g, { textAlign: align, textBaseline: "middle", lineWidth: 3.5, strokeStyle: "rgba(255,255,255,.9)", fillStyle: colour });
  g.setLineDash([]);
  g.strokeText(text, x, y);
  g.fillText(text, x, y);
}

/** A view of space that the pointer and the keys turn. `paint` draws with `project`: [x, y, depth towards the viewer]. */
class View {
  constructor(id, paint, home) {
    Object.assign(this, { canvas: document.querySelector(`#${id} canvas`), paint, home });
    this.reset();
    let last = null;
    this.canvas.addEventListener("pointerdown", e => { last = [e.clientX, e.clientY]; this.canvas.setPointerCapture(e.pointerId); });
    this.canvas.addEventListener("pointermove", e => {
      if (!last) return;
      this.turn((e.clientX - last[0]) / 120, (e.clientY - last[1]) / 120);
      last = [e.clientX, e.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => { last = null; });
    this.canvas.addEventListener("keydown", e => {
      const turns = { ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1] };
      if (turns[e.key]) this.turn(...turns[e.key]);
      else if (e.key === "+" || e.key === "=") this.zoom = Math.min(this.zoom * 1.1, 4);
      else if (e.key === "-") this.zoom = Math.max(this.zoom / 1.1, .4);
      else if (e.key === "Home") this.reset();
      else return;
      e.preventDefault();
      this.draw();
    });
  }
  reset() { [this.azimuth, this.elevation, this.zoom] = [...this.home, 1]; }
  turn(right, down) {
    this.azimuth += right;
    this.elevation = Math.max(-1.57, Math.min(1.57, this.elevation + down));
    this.draw();
  }
  draw() {
    const frame = prepare(this.canvas), { g, width, height } = frame;
    const [c, s, C, S] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    this.radius = Math.min(width, height) * .42 * this.zoom;
    const project = v => {
      const x = -s * v[0] + c * v[1], out = c * v[0] + s * v[1];
      return [width / 2 + this.radius * x, height / 2 - this.radius * (C * v[2] - S * out), C * out + S * v[2]];
    };
    this.paint({ ...frame, project, radius: this.radius });
  }
}
/** Draws a curve of points of space, those behind the centre faintly. */
function path({ g, project }, points, colour, width, behind = .25, dash = []) {
  const pixels = points.map(project);
  for (const front of [false, true]) {
    g.beginPath();
    pixels.forEach((p, k) => {
      const q = pixels[k - 1];
      if (q && (p[2] + q[2] >= 0) === front) { g.moveTo(q[0], q[1]); g.lineTo(p[0], p[1]); }
    });
    Object.assign(g, { strokeStyle: colour, lineWidth: width, globalAlpha: front ? 1 : behind });
    g.setLineDash(dash);
    g.stroke();
  }
  g.globalAlpha = 1;
  g.setLineDash([]);
}
function arrow({ g, project }, from, to, colour, width, name, dash = [], aside = false) {
  const a = project(from), b = project(to), way = [b[0] - a[0], b[1] - a[1]], length = Math.hypot(...way) || 1;
  const [x, y] = [way[0] / length, way[1] / length], head = Math.min(11, length);
  Object.assign(g, { strokeStyle: colour, fillStyle: colour, lineWidth: width });
  g.setLineDash(dash);
  g.beginPath(); g.moveTo(a[0], a[1]); g.lineTo(b[0] - x * head * .7, b[1] - y * head * .7); g.stroke();
  g.setLineDash([]);
  g.beginPath(); g.moveTo(b[0], b[1]);
  g.lineTo(b[0] - x * head - y * head * .38, b[1] - y * head + x * head * .38);
  g.lineTo(b[0] - x * head + y * head * .38, b[1] - y * head - x * head * .38);
  g.fill();
  if (name) aside ? label(g, name, b[0] - y * 12 - x * 6, b[1] + x * 12 - y * 6, colour) : label(g, name, b[0] + x * 13, b[1] + y * 11, colour);
}
function ball({ g, width, height, radius }) {
  const fill = g.createRadialGradient(width / 2 - radius * .35, height / 2 - radius * .4, radius * .1, width / 2, height / 2, radius);
  fill.addColorStop(0, "#ffffff");
  fill.addColorStop(1, "#e3e9ef");
  g.beginPath(); g.arc(width / 2, height / 2, radius, 0, 7);
  Object.assign(g, { fillStyle: fill, strokeStyle: "#9aa6b2", lineWidth: 1 });
  g.fill(); g.stroke();
}
function point({ g }, [x, y], colour) {
  g.beginPath(); g.arc(x, y, 6, 0, 7);
  Object.assign(g, { fillStyle: colour, strokeStyle: "#fff", lineWidth: 2 });
  g.fill(); g.stroke();
}
