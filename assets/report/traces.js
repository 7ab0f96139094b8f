// Traces: every signal of a run and its error, zoomed together.
function tracesView(root) {
  if (!page.runs.length) return;
  const hasTwin = page.runs[0].traces.some(t => t.before);
  const shows = { values: true, errors: hasTwin };
  let window_ = null, cursor = null, plots = [];
  const readout = make("p", { className: "readout", role: "status" });
  const bar = make("div", { className: "bar" }, runPicker());
  const toggle = (key, word) => {
    const button = make("button", { type: "button", "aria-pressed": String(shows[key]), onclick: () => {
      shows[key] = !shows[key];
      if (!shows.values && !shows.errors) shows[key] = true;
      button.setAttribute("aria-pressed", String(shows[key]));
      build();
    } }, word);
    return button;
  };
  if (hasTwin) bar.append(toggle("values", "signals"), toggle("errors", "errors"));
  const zoom = factor => { const [a, b] = range(); scaleAt((a + b) / 2, factor); };
  bar.append(
    make("button", { type: "button", "aria-label": "zoom in", onclick: () => zoom(0.5) }, "+"),
    make("button", { type: "button", "aria-label": "zoom out", onclick: () => zoom(2) }, "−"),
    make("button", { type: "button", onclick: () => { window_ = null; drawAll(); } }, "whole run"));
  const legend = make("div", { className: "legend" });
  const stack = make("div", { tabIndex: 0, role: "group", "aria-label": "traces; arrow keys move, plus and minus zoom, 0 shows the whole run" });
  root.append(bar, legend, readout, stack,
    make("p", { className: "hint" }, "Drag to move, wheel with Ctrl or pinch to zoom, double click for the whole run; arrow keys, + − and 0 do the same."));

  function range() { return window_ || [0, runOf(shared.run).end]; }
  function scaleAt(at, factor) {
    const end = runOf(shared.run).end, [a, b] = range();
    const width = Math.min(end, Math.max((b - a) * factor, 12 * runOf(shared.run).period));
    const from = Math.min(Math.max(at - (at - a) * width / (b - a), 0), end - width);
    window_ = width >= end * 0.999 ? null : [from, from + width];
    drawAll();
  }
  function shift(by) {
    const end = runOf(shared.run).end, [a, b] = range();
    const from = Math.min(Math.max(a + by, 0), end - (b - a));
    if (window_) { window_ = [from, from + (b - a)]; drawAll(); }
  }
  stack.addEventListener("keydown", event => {
    const [a, b] = range(), step = (b - a) / 8;
    const acts = { ArrowLeft: () => shift(-step), ArrowRight: () => shift(step), "+": () => zoom(0.5), "=": () => zoom(0.5),
      "-": () => zoom(2), "0": () => { window_ = null; drawAll(); } };
    if (acts[event.key]) { acts[event.key](); event.preventDefault(); }
  });

  function build() {
    const c = colours();
    legend.replaceChildren();
    const key = (colour, word, dashed) => {
      const line = make("i", { className: dashed ? "dash" : "" });
      line.style.borderColor = colour;
      legend.append(make("span", {}, line, word));
    };
    key(c.measured, hasTwin ? "machine" : "recorded");
    if (hasTwin) { key(c.before, page.before || "twin as it is"); key(c.after, "twin with the causes"); }
    key(c.reference, "command", true);
    stack.replaceChildren();
    plots = [];
    const run = runOf(shared.run);
    run.traces.forEach((trace, k) => {
      for (const kind of ["values", "errors"]) {
        if (!shows[kind] || (kind === "errors" && !trace.before)) continue;
        const canvas = make("canvas", { className: "trace", role: "img", "aria-label": `${trace.word}, ${kind}` });
        stack.append(canvas);
        const plot = { canvas, trace, kind, k };
        plots.push(plot);
        pointers(plot);
      }
    });
    drawAll();
  }

  const LEFT = 62, RIGHT = 10;
  function pointers(plot) {
    const active = new Map();
    const timeAt = x => {
      const [a, b] = range(), width = plot.canvas.clientWidth - LEFT - RIGHT;
      return a + (x - LEFT) / width * (b - a);
    };
    const canvas = plot.canvas;
    canvas.addEventListener("pointerdown", event => { active.set(event.pointerId, event.offsetX); canvas.setPointerCapture(event.pointerId); });
    const release = event => active.delete(event.pointerId);
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", event => {
      const [a, b] = range(), perPx = (b - a) / Math.max(canvas.clientWidth - LEFT - RIGHT, 1);
      if (active.has(event.pointerId)) {
        const before = active.get(event.pointerId);
        if (active.size === 2) {
          const other = [...active.entries()].find(([id]) => id !== event.pointerId)[1];
          const old = Math.max(Math.abs(before - other), 4), now = Math.max(Math.abs(event.offsetX - other), 4);
          scaleAt(timeAt(other), old / now);
        } else shift((before - event.offsetX) * perPx);
        active.set(event.pointerId, event.offsetX);
      }
      cursor = Math.min(Math.max(timeAt(event.offsetX), 0), runOf(shared.run).end);
      tell(plot);
      drawAll();
    });
    canvas.addEventListener("pointerleave", () => { cursor = null; drawAll(); });
    canvas.addEventListener("dblclick", () => { window_ = null; drawAll(); });
    canvas.addEventListener("click", () => { if (cursor !== null) shared.set({ time: cursor }); });
    canvas.addEventListener("wheel", event => {
      if (!event.ctrlKey && !event.metaKey && !event.shiftKey) return;
      event.preventDefault();
      scaleAt(timeAt(event.offsetX), event.deltaY > 0 ? 1.25 : 0.8);
    }, { passive: false });
  }

  function tell(plot) {
    const run = runOf(shared.run), { trace } = plot;
    const k = Math.min(lower(trace.at, cursor / run.period), trace.values.length - 1);
    const digits = x => Number(x.toPrecision(4));
    let text = `${trace.word} at ${cursor.toFixed(4)} s: ${digits(trace.values[k] * trace.factor)} ${trace.unit}`;
    if (trace.before) text += `; error before ${digits(trace.before[k] * trace.errorFactor)}, after ${digits(trace.after[k] * trace.errorFactor)} ${trace.errorUnit}`;
    readout.textContent = text;
  }

  function drawAll() { plots.forEach((plot, k) => drawPlot(plot, k === plots.length - 1)); }

  function drawPlot(plot, isLast) {
    const c = colours(), run = runOf(shared.run), { trace, kind } = plot;
    const body = kind === "values" ? 120 : 100, head = kind === "values" ? 22 : 6, foot = isLast ? 36 : 6;
    const { context: g, width, height } = fitted(plot.canvas, head + body + foot);
    g.clearRect(0, 0, width, height);
    const [t0, t1] = range();
    const curves = [];
    if (kind === "values") {
      if (trace.key.startsWith("position")) curves.push([run.reference.at, k => run.reference.values[k] * trace.factor, c.reference, true, run.reference.values.length]);
      curves.push([trace.at, k => trace.values[k] * trace.factor, c.measured, false, trace.values.length]);
      if (trace.before) {
        curves.push([trace.at, k => (trace.values[k] - trace.before[k]) * trace.factor, c.before, false, trace.values.length]);
        curves.push([trace.at, k => (trace.values[k] - trace.after[k]) * trace.factor, c.after, false, trace.values.length]);
      }
    } else {
      curves.push([trace.at, k => trace.before[k] * trace.errorFactor, c.before, false, trace.values.length]);
      curves.push([trace.at, k => trace.after[k] * trace.errorFactor, c.after, false, trace.values.length]);
    }
    let low = Infinity, high = -Infinity;
    const spans = curves.map(([at, of, , , count]) => {
      const from = Math.max(lower(at, t0 / run.period) - 1, 0), to = Math.min(lower(at, t1 / run.period) + 2, count);
      for (let k = from; k < to; k++) { const y = of(k); if (y < low) low = y; if (y > high) high = y; }
      return [from, to];
    });
    if (!(high >= low)) { low = 0; high = 1; }
    const margin = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1e-6;
    low -= margin; high += margin;
    const X = t => LEFT + (t - t0) / (t1 - t0) * (width - LEFT - RIGHT);
    const Y = y => head + body * (1 - (y - low) / (high - low));
    axes(g, c, { low, high, t0, t1, X, Y, head, body, width, isLast });
    g.fillStyle = c.ink; g.font = "600 12px system-ui,sans-serif"; g.textAlign = "left";
    if (kind === "values") g.fillText(trace.word, 8, 14);
    g.save();
    g.fillStyle = c.pale; g.font = "11.5px system-ui,sans-serif"; g.textAlign = "center";
    g.translate(13, head + body / 2); g.rotate(-Math.PI / 2);
    g.fillText(kind === "values" ? trace.unit : `error, ${trace.errorUnit}`, 0, 0);
    g.restore();
    g.save();
    g.beginPath(); g.rect(LEFT, head - 2, width - LEFT - RIGHT, body + 4); g.clip();
    curves.forEach(([at, of, colour, dashed], n) => curve(g, spans[n], at, of, colour, dashed, X, Y, run.period));
    for (const [t, word] of run.events) {
      if (t < t0 || t > t1) continue;
      g.strokeStyle = c.event; g.setLineDash([3, 3]); g.lineWidth = 1;
      g.beginPath(); g.moveTo(X(t), head); g.lineTo(X(t), head + body); g.stroke(); g.setLineDash([]);
    }
    if (kind === "values") words(g, c, run, t0, t1, X, head, width);
    for (const [t, colour] of [[shared.time, c.third], [cursor, c.pale]]) {
      if (t === null || t < t0 || t > t1) continue;
      g.strokeStyle = colour; g.lineWidth = 1;
      g.beginPath(); g.moveTo(X(t), head); g.lineTo(X(t), head + body); g.stroke();
    }
    g.restore();
  }

  function words(g, c, run, t0, t1, X, head, width) {
    let free = LEFT;
    g.fillStyle = c.event; g.font = "10.5px system-ui,sans-serif"; g.textAlign = "left";
    for (const [t, word] of run.events) {
      const x = X(t), takes = g.measureText(word).width;
      if (t < t0 || t > t1 || x < free || x + takes > width - RIGHT) continue;
      g.lineWidth = 3; g.lineJoin = "round"; g.strokeStyle = c.ground; g.strokeText(word, x + 3, head + 10);
      g.fillText(word, x + 3, head + 10);
      free = x + takes + 8;
    }
  }

  // Of every column the first, lowest, highest and last sample: no peak is lost.
  function curve(g, [from, to], at, of, colour, dashed, X, Y, period) {
    g.strokeStyle = colour; g.lineWidth = 1.4; g.lineJoin = "round";
    if (dashed) g.setLineDash([5, 4]);
    g.beginPath();
    let column = null, low = 0, high = 0, last = 0;
    const flush = () => { if (column !== null) { g.lineTo(column, Y(low)); g.lineTo(column, Y(high)); g.lineTo(column, Y(last)); } };
    for (let k = from; k < to; k++) {
      const x = Math.round(X(at[k] * period) * 2) / 2, y = of(k);
      if (x !== column) { flush(); g.lineTo(x, Y(y)); column = x; low = high = y; }
      else { if (y < low) low = y; if (y > high) high = y; }
      last = y;
    }
    flush();
    g.stroke(); g.setLineDash([]);
  }

  shared.listeners.push(change => {
    if ("run" in change) { window_ = null; cursor = null; build(); }
    else if (!("silent" in change)) drawAll();
  });
  redraws.push(build);
  build();
}

// Round ticks between two values.
function ticks(low, high, most) {
  const raw = (high - low) / most, decade = 10 ** Math.floor(Math.log10(raw));
  const inside = s => Math.floor(high / s) - Math.ceil(low / s) + 1;
  const steps = [1, 2, 5, 10].map(m => m * decade);
  let step = steps.find(s => s >= raw * 0.999) || raw;
  // One value alone tells no scale.
  if (inside(step) < 2) step = steps.filter(s => inside(s) >= 2).pop() || step;
  const places_ = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const list = [];
  for (let k = Math.ceil(low / step); k * step <= high; k++) list.push([k * step, (k * step).toFixed(Math.min(places_, 8)).replace("-", "−")]);
  return list;
}

function axes(g, c, { low, high, t0, t1, X, Y, head, body, width, isLast }) {
  g.font = "11.5px system-ui,sans-serif"; g.lineWidth = 1; g.strokeStyle = c.line; g.fillStyle = c.pale;
  const bottom = head + body, left = X(t0), right = X(t1);
  g.textAlign = "right";
  for (const [y, text] of ticks(low, high, Math.max(3, Math.min(6, body / 24)))) {
    g.beginPath(); g.moveTo(left, Y(y)); g.lineTo(right, Y(y)); g.stroke();
    g.fillText(text, left - 6, Y(y) + 4);
  }
  g.textAlign = "center";
  for (const [t, text] of ticks(t0, t1, width < 500 ? 4 : 9)) {
    g.beginPath(); g.moveTo(X(t), head); g.lineTo(X(t), bottom); g.stroke();
    if (isLast) g.fillText(text, X(t), bottom + 15);
  }
  if (isLast) g.fillText("time in s", (left + right) / 2, bottom + 31);
  g.strokeStyle = c.reference;
  g.beginPath(); g.moveTo(left, head); g.lineTo(left, bottom); g.lineTo(right, bottom); g.stroke();
}
