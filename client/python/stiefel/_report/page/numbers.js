// Data of the page, numbers and vectors.
const D = JSON.parse(document.getElementById("data").textContent);
const scene = JSON.parse(D.scene);
const $ = id => document.getElementById(id);
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#b0568d", "#b87d00", "#2f8fc0"];
const DASHES = [[], [9, 3], [10, 3, 2, 3], [2, 2.5], [14, 3, 2, 3, 2, 3], [5, 5]];

const decode = part => {
  const bytes = Uint8Array.from(atob(part.data), c => c.charCodeAt(0)).buffer;
  return part.dtype === "float64" ? new Float64Array(bytes) : new Float32Array(bytes);
};
const short = (x, digits = 4) => x === 0 ? "0" : Math.abs(x) < 1e-3 || Math.abs(x) >= 1e6
  ? x.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e") : String(+x.toPrecision(digits));
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const scaled = (a, s) => a.map(x => x * s);
const norm = a => Math.sqrt(a.reduce((sum, x) => sum + x * x, 0));
const unit = a => scaled(a, 1 / (norm(a) || 1));
const times = (A, v) => A.map(row => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
const transposed = A => A[0].map((_, j) => A.map(row => row[j]));
const extent = values => values.reduce(([a, b], y) => [Math.min(a, y), Math.max(b, y)], [Infinity, -Infinity]);
