// What the traces are drawn and saved with: axes, curves, files.

// Round ticks between two values; small ones share a power of ten.
function ticks(low, high, most) {
  const raw = (high - low) / most, decade = 10 ** Math.floor(Math.log10(raw));
  const inside = s => Math.floor(high / s) - Math.ceil(low / s) + 1;
  const steps = [1, 2, 5, 10].map(m => m * decade);
  let step = steps.find(s => s >= raw * 0.999) || raw;
  // One value alone tells no scale.
  if (inside(step) < 2) step = steps.filter(s => inside(s) >= 2).pop() || step;
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9), list = [];
  const largest = Math.max(Math.abs(first), Math.abs(last)) * step;
  for (let k = first; k <= last; k++) list.push([k * step, tickLabel(k * step, step, largest)]);
  return list;
}
function tickLabel(value, step, largest) {
  const decade = size => Math.floor(Math.log10(size * (1 + 1e-9)));
  if (value === 0) return "0";
  if (largest < 1e-3 || step >= 1e6) {
    const exponent = decade(largest), places_ = Math.min(Math.max(exponent - decade(step), 0), 8);
    const raised = String(exponent).replace(/-/, "⁻").replace(/\d/g, digit => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);
    return `${(value / 10 ** exponent).toFixed(places_).replace("-", "−")}·10${raised}`;
  }
  return value.toFixed(Math.min(Math.max(-decade(step), 0), 12)).replace("-", "−");
}

// Grid and heights of one plot.
function axes(g, c, { low, high, t0, t1, X, Y, head, body, width }) {
  g.font = "11.5px system-ui,sans-serif"; g.lineWidth = 1; g.strokeStyle = c.line; g.fillStyle = c.pale;
  const bottom = head + body, left = X(t0), right = X(t1);
  g.textAlign = "right";
  for (const [y, text] of ticks(low, high, Math.max(3, Math.min(6, body / 24)))) {
    g.beginPath(); g.moveTo(left, Y(y)); g.lineTo(right, Y(y)); g.stroke();
    g.fillText(text, left - 6, Y(y) + 4);
  }
  for (const [t] of ticks(t0, t1, width < 500 ? 4 : 9)) {
    g.beginPath(); g.moveTo(X(t), head); g.lineTo(X(t), bottom); g.stroke();
  }
  g.strokeStyle = c.reference;
  g.beginPath(); g.moveTo(left, head); g.lineTo(left, bottom); g.lineTo(right, bottom); g.stroke();
}
// The time axis of all plots.
function timeAxis(g, c, t0, t1, X, width, label) {
  g.font = "11.5px system-ui,sans-serif"; g.fillStyle = c.pale; g.textAlign = "center";
  g.strokeStyle = c.reference; g.lineWidth = 1;
  g.beginPath(); g.moveTo(X(t0), 0.5); g.lineTo(X(t1), 0.5); g.stroke();
  for (const [t, text] of ticks(t0, t1, width < 500 ? 4 : 9)) {
    g.beginPath(); g.moveTo(X(t), 0); g.lineTo(X(t), 4); g.stroke();
    g.fillText(text, X(t), 16);
  }
  g.fillText(label, (X(t0) + X(t1)) / 2, 31);
}

// Of every column the first, lowest, highest and last sample: no peak is lost.
function curve(g, { at, of, colour, dashed, thin, offset, period, from, to }, X, Y) {
  g.strokeStyle = colour; g.lineWidth = thin ? 1 : 1.4; g.lineJoin = "round";
  if (dashed) g.setLineDash([5, 4]);
  g.beginPath();
  let column = null, low = 0, high = 0, last = 0;
  const flush = () => { if (column !== null) { g.lineTo(column, Y(low)); g.lineTo(column, Y(high)); g.lineTo(column, Y(last)); } };
  for (let k = from; k < to; k++) {
    const x = Math.round(X(at[k] * period + offset) * 2) / 2, y = of(k);
    if (x !== column) { flush(); g.lineTo(x, Y(y)); column = x; low = high = y; }
    else { if (y < low) low = y; if (y > high) high = y; }
    last = y;
  }
  flush();
  g.stroke(); g.setLineDash([]);
}

// Hands a file to the reader; nothing leaves the page otherwise.
function save(name, blob) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// Lines of the samples between two times, in SI: a column a signal, and two for what the twins predict.
function csvOf(run, keys, [t0, t1], withTwin) {
  const shown = run.traces.filter(trace => keys.has(trace.key));
  const number = x => String(Number(x.toPrecision(7)));
  const heads = ["time_s"], columns = [];
  const add = (head, at, of) => { heads.push(head); columns.push(new Map()); const own = columns[columns.length - 1];
    const from = lower(at, t0 / run.period - 1e-6), to = lower(at, t1 / run.period + 1e-6);
    for (let k = from; k < to; k++) own.set(at[k], number(of(k))); };
  for (const trace of shown) {
    add(trace.key, trace.at, k => trace.values[k]);
    if (trace.before && withTwin) {
      add(trace.key + "_twin_before", trace.at, k => trace.values[k] - trace.before[k]);
      add(trace.key + "_twin_after", trace.at, k => trace.values[k] - trace.after[k]);
    }
    if (trace.key.startsWith("position") && run.reference.values.length) {
      add(trace.key.replace("position", "position_reference"), run.reference.at, k => run.reference.values[k]);
    }
  }
  const samples = [...new Set(columns.flatMap(column => [...column.keys()]))].sort((a, b) => a - b);
  const rows = samples.map(k => [Number((k * run.period).toPrecision(10)), ...columns.map(column => column.get(k) ?? "")].join(","));
  return [heads.join(","), ...rows].join("\n") + "\n";
}
