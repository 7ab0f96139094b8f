// Traces as on a scope: every signal of a run and its error over one time axis, runs laid over each other, two cursors.
function tracesView(root) {
  if (!page.runs.length) return;
  const hasTwin = page.runs[0].traces.some(t => t.before);
  const shows = { values: true, errors: hasTwin };
  const hidden = new Set(), tall = new Map();
  let window_ = null, hover = null, cursors = null, box = null, boxes = true, overlay = "", aligned = true, plots = [];
  const LEFT = 66, RIGHT = 10;
  const readout = make("p", { className: "readout", role: "status" });
  const bar = make("div", { className: "bar" }), tools = make("div", { className: "bar" }), channels = make("div", { className: "bar channels" });
  const pressed = (button, is) => button.setAttribute("aria-pressed", String(is));
  const button = (word, act, label) => make("button", { type: "button", onclick: act, ...(label ? { "aria-label": label } : {}) }, word);
  const toggle = (word, of, act) => {
    const own = button(word, () => { act(); pressed(own, of()); });
    pressed(own, of());
    return own;
  };
  const zoom = factor => { const [a, b] = range(); scaleAt((a + b) / 2, factor); };
  const whole = () => { window_ = null; tall.clear(); drawAll(); };
  bar.append(runPicker());
  if (page.runs.length > 1) {
    const select = make("select", { "aria-label": "overlay", onchange: () => { overlay = select.value; window_ = null; build(); } });
    select.append(make("option", { value: "" }, "none"), make("option", { value: "all" }, "all runs"));
    page.runs.forEach((run, k) => select.append(make("option", { value: k }, run.name)));
    const align = make("input", { type: "checkbox", checked: true, onchange: () => { aligned = align.checked; build(); } });
    bar.append(make("label", {}, "overlay", select), make("label", {}, align, "aligned at start of motion"));
  }
  if (hasTwin) {
    const kind = key => () => { shows[key] = !shows[key]; if (!shows.values && !shows.errors) shows[key] = true; build(); };
    bar.append(toggle("signals", () => shows.values, kind("values")), toggle("errors", () => shows.errors, kind("errors")));
  }
  const drag = button("drag: box zoom", () => { boxes = !boxes; drag.textContent = boxes ? "drag: box zoom" : "drag: move"; });
  const setCursors = on => { const [a, b] = range(); cursors = on ? [a + (b - a) / 3, a + 2 * (b - a) / 3] : null; pressed(measure, on); tell(); drawAll(); };
  const measure = button("cursors A B", () => setCursors(!cursors));
  pressed(measure, false);
  tools.append(drag, button("+", () => zoom(0.5), "zoom in"), button("−", () => zoom(2), "zoom out"), button("whole run", whole), measure,
    button("save CSV", saveCsv), button("save PNG", savePng));
  const legend = make("div", { className: "legend" });
  const table = make("div", { className: "cursors" });
  const stack = make("div", { className: "stack", tabIndex: 0, role: "group", "aria-label": "traces; arrow keys move, plus and minus zoom, 0 shows the whole run, A and B set cursors" });
  const time = make("canvas", { className: "time", role: "img", "aria-label": "time axis" });
  root.append(bar, tools, channels, legend, readout, stack, table,
    make("p", { className: "hint" }, "Drag a box to zoom into it (Shift drags the other way), wheel with Ctrl or pinch zooms time, double click or 0 shows the whole run; " +
      "arrow keys, + and − move and zoom; A and B set the cursors where the pointer is, and they can be dragged. A click on the legend hides a curve."));

  // Runs that are drawn: the chosen one, then those laid over it, each with how far it is moved in time.
  function starts(run) { return run.events.length ? run.events[0][0] : 0; }
  function drawn() {
    const main = runOf(shared.run), list = [{ run: main, offset: 0, index: shared.run }];
    page.runs.forEach((_, k) => {
      if (k === shared.run || !(overlay === "all" || overlay === String(k))) return;
      const run = runOf(k);
      list.push({ run, index: k, offset: aligned ? starts(main) - starts(run) : 0 });
    });
    return list;
  }
  function extent() {
    const list = drawn();
    return [Math.min(0, ...list.map(o => o.offset)), Math.max(...list.map(o => o.run.end + o.offset))];
  }
  function range() { return window_ || extent(); }
  function setRange(from, width) {
    const [begin, end] = extent(), most = end - begin;
    width = Math.min(most, Math.max(width, 12 * runOf(shared.run).period));
    from = Math.min(Math.max(from, begin), end - width);
    window_ = width >= most * 0.999 ? null : [from, from + width];
    drawAll();
  }
  function scaleAt(at, factor) { const [a, b] = range(), width = (b - a) * factor; setRange(at - (at - a) * factor, width); }
  function shift(by) { const [a, b] = range(); if (window_) setRange(a + by, b - a); }
  stack.addEventListener("keydown", event => {
    const [a, b] = range(), step = (b - a) / 8;
    const place = k => { if (!cursors) setCursors(true); cursors[k] = hover ?? shared.time; tell(); drawAll(); };
    const acts = { ArrowLeft: () => shift(-step), ArrowRight: () => shift(step), "+": () => zoom(0.5), "=": () => zoom(0.5),
      "-": () => zoom(2), "0": whole, a: () => place(0), b: () => place(1) };
    const act = event.ctrlKey || event.metaKey ? null : acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (act) { act(); event.preventDefault(); }
  });

  const overlayColours = c => [c.law, c.third, c.second, c.calibration, c.event, c.unexplained, c.noise];
  function build() {
    const c = colours(), run = runOf(shared.run);
    legend.replaceChildren(); channels.replaceChildren();
    const key = (id, colour, word, dashed) => {
      const line = make("i", { className: dashed ? "dash" : "" });
      line.style.borderColor = colour;
      const own = toggle("", () => !hidden.has(id), () => { if (!hidden.delete(id)) hidden.add(id); drawAll(); });
      own.append(line, word);
      legend.append(own);
    };
    key("measured", c.measured, hasTwin ? "machine" : "recorded");
    if (hasTwin) { key("before", c.before, page.before || "twin as it is"); key("after", c.after, "twin with the causes"); }
    key("reference", c.reference, "command", true);
    drawn().slice(1).forEach((other, n) => key("run " + other.index, overlayColours(c)[n % 7], other.run.name));
    for (const trace of run.traces) {
      channels.append(toggle(trace.word, () => !hidden.has(trace.key), () => {
        if (!hidden.delete(trace.key)) hidden.add(trace.key);
        if (run.traces.every(t => hidden.has(t.key))) hidden.delete(trace.key);
        build();
      }));
    }
    stack.replaceChildren();
    plots = [];
    run.traces.forEach(trace => {
      for (const kind of ["values", "errors"]) {
        if (hidden.has(trace.key) || !shows[kind] || (kind === "errors" && !trace.before)) continue;
        const canvas = make("canvas", { className: "trace", role: "img", "aria-label": `${trace.word}, ${kind}` });
        stack.append(canvas);
        const plot = { canvas, trace, kind, id: `${trace.key} ${kind}` };
        plots.push(plot);
        pointers(plot);
      }
    });
    stack.append(time);
    tell();
    drawAll();
  }

  function pointers(plot) {
    const active = new Map(), canvas = plot.canvas;
    let held = null, moved = false;
    const timeAt = x => { const [a, b] = range(); return a + (x - LEFT) / Math.max(canvas.clientWidth - LEFT - RIGHT, 1) * (b - a); };
    canvas.addEventListener("pointerdown", event => {
      active.set(event.pointerId, event.offsetX);
      canvas.setPointerCapture(event.pointerId);
      moved = false;
      const [a, b] = range(), px = t => LEFT + (t - a) / (b - a) * (canvas.clientWidth - LEFT - RIGHT);
      held = cursors ? [0, 1].find(k => Math.abs(px(cursors[k]) - event.offsetX) < 8) ?? null : null;
      const boxed = held === null && active.size === 1 && boxes !== event.shiftKey;
      box = boxed ? { plot, x: [event.offsetX, event.offsetX], y: [event.offsetY, event.offsetY] } : null;
    });
    const release = event => {
      active.delete(event.pointerId);
      held = null;
      const done = box;
      box = null;
      if (done && event.type === "pointerup") zoomTo(done, timeAt);
      else if (done) drawAll();
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", event => {
      const [a, b] = range(), perPx = (b - a) / Math.max(canvas.clientWidth - LEFT - RIGHT, 1), [begin, end] = extent();
      hover = Math.min(Math.max(timeAt(event.offsetX), begin), end);
      if (active.has(event.pointerId)) {
        const before = active.get(event.pointerId);
        if (Math.abs(event.offsetX - before) > 2) moved = true;
        if (active.size === 2) {
          box = null;
          const other = [...active.entries()].find(([id]) => id !== event.pointerId)[1];
          const old = Math.max(Math.abs(before - other), 4), now = Math.max(Math.abs(event.offsetX - other), 4);
          scaleAt(timeAt(other), old / now);
        } else if (held !== null) cursors[held] = hover;
        else if (box) { box.x[1] = event.offsetX; box.y[1] = event.offsetY; }
        else shift((before - event.offsetX) * perPx);
        active.set(event.pointerId, event.offsetX);
      }
      tell(plot);
      drawAll();
    });
    canvas.addEventListener("pointerleave", () => { hover = null; drawAll(); });
    canvas.addEventListener("dblclick", whole);
    canvas.addEventListener("click", () => { if (hover !== null && !moved) shared.set({ time: Math.min(Math.max(hover, 0), runOf(shared.run).end) }); });
    canvas.addEventListener("wheel", event => {
      if (!event.ctrlKey && !event.metaKey && !event.shiftKey) return;
      event.preventDefault();
      scaleAt(timeAt(event.offsetX), event.deltaY > 0 ? 1.25 : 0.8);
    }, { passive: false });
  }

  // A box of some width zooms time, one of some height that plot's height.
  function zoomTo({ plot, x, y }, timeAt) {
    const [x0, x1] = [...x].sort((p, q) => p - q), [y0, y1] = [...y].sort((p, q) => p - q);
    if (x1 - x0 < 6) { drawAll(); return; }
    if (y1 - y0 > 12 && plot.height) tall.set(plot.id, [plot.height(y1), plot.height(y0)]);
    const [from, to] = [timeAt(x0), timeAt(x1)];
    setRange(from, to - from);
  }

  const digits = x => String(Number(x.toPrecision(5))).replace("-", "−");
  function sample(trace, run, t) { return Math.max(0, Math.min(lower(trace.at, t / run.period - 0.5), trace.values.length - 1)); }
  function tell(plot) {
    const run = runOf(shared.run);
    if (plot && hover !== null) {
      const { trace } = plot, k = sample(trace, run, hover);
      let text = `${trace.word} at ${hover.toFixed(4)} s: ${digits(trace.values[k] * trace.factor)} ${trace.unit}`;
      if (trace.before) text += `; error before ${digits(trace.before[k] * trace.errorFactor)}, after ${digits(trace.after[k] * trace.errorFactor)} ${trace.errorUnit}`;
      readout.textContent = text;
    }
    table.replaceChildren();
    if (!cursors) return;
    const [a, b] = cursors, apart = b - a, rows = [];
    if (!plot || hover === null) readout.textContent = `A ${digits(a)} s, B ${digits(b)} s, B − A ${digits(apart)} s` + (apart ? `, 1/(B − A) ${digits(1 / Math.abs(apart))} Hz` : "");
    const row = (tag, cells) => make("tr", {}, ...cells.map((cell, k) => make(tag, k ? { className: "n", "data-label": heads[k] } : {}, cell)));
    const heads = ["", "A", "B", "B − A"];
    rows.push(["time in s", digits(a), digits(b), `${digits(apart)} (${apart ? digits(1 / Math.abs(apart)) + " Hz" : "–"})`]);
    const three = (word, at, factor, unit) => rows.push([`${word} in ${unit}`, ...[at[0], at[1], at[1] - at[0]].map(x => digits(x * factor))]);
    for (const trace of run.traces) {
      if (hidden.has(trace.key)) continue;
      const ks = cursors.map(t => sample(trace, run, t)), of = list => ks.map(k => list[k]);
      three(trace.word, of(trace.values), trace.factor, trace.unit);
      if (trace.before && shows.errors) {
        three(`${trace.word}, error before`, of(trace.before), trace.errorFactor, trace.errorUnit);
        three(`${trace.word}, error after`, of(trace.after), trace.errorFactor, trace.errorUnit);
      }
    }
    table.append(make("table", {}, make("thead", {}, row("th", heads)), make("tbody", {}, ...rows.map(cells => row("td", cells)))));
  }

  function drawAll() {
    plots.forEach(drawPlot);
    const c = colours(), { context: g, width, height } = fitted(time, 38), [t0, t1] = range();
    g.clearRect(0, 0, width, height);
    timeAxis(g, c, t0, t1, t => LEFT + (t - t0) / (t1 - t0) * (width - LEFT - RIGHT), width, "time in s");
  }

  // Curves of one plot: what they are drawn from, with the samples that are in view.
  function curvesOf({ trace, kind }, c, t0, t1) {
    const list = [];
    const add = (id, run, offset, at, of, count, colour, more) => {
      if (hidden.has(id)) return;
      const from = Math.max(lower(at, (t0 - offset) / run.period) - 1, 0), to = Math.min(lower(at, (t1 - offset) / run.period) + 2, count);
      list.push({ at, of, colour, offset, period: run.period, from, to, ...more });
    };
    drawn().slice(1).forEach(({ run, offset, index }, n) => {
      const own = run.traces.find(t => t.key === trace.key);
      if (!own) return;
      const errors = hidden.has("after") ? own.before : own.after, colour = overlayColours(c)[n % 7];
      const of = kind === "values" ? k => own.values[k] * trace.factor : errors && (k => errors[k] * trace.errorFactor);
      if (of) add("run " + index, run, offset, own.at, of, own.values.length, colour, { thin: true });
    });
    const run = runOf(shared.run), count = trace.values.length;
    const main = (id, of, colour, more) => add(id, run, 0, trace.at, of, count, colour, more);
    if (kind === "values") {
      const reference = run.reference;
      if (trace.key.startsWith("position")) add("reference", run, 0, reference.at, k => reference.values[k] * trace.factor, reference.values.length, c.reference, { dashed: true });
      main("measured", k => trace.values[k] * trace.factor, c.measured);
      if (trace.before) {
        main("before", k => (trace.values[k] - trace.before[k]) * trace.factor, c.before);
        main("after", k => (trace.values[k] - trace.after[k]) * trace.factor, c.after);
      }
    } else {
      main("before", k => trace.before[k] * trace.errorFactor, c.before);
      main("after", k => trace.after[k] * trace.errorFactor, c.after);
    }
    return list;
  }

  function drawPlot(plot) {
    const c = colours(), run = runOf(shared.run), { trace, kind } = plot;
    const body = kind === "values" ? 120 : 100, head = kind === "values" || cursors ? 22 : 6;
    const { context: g, width, height } = fitted(plot.canvas, head + body + 6);
    g.clearRect(0, 0, width, height);
    const [t0, t1] = range(), curves = curvesOf(plot, c, t0, t1);
    let low = Infinity, high = -Infinity;
    for (const { of, from, to } of curves) for (let k = from; k < to; k++) { const y = of(k); if (y < low) low = y; if (y > high) high = y; }
    if (!(high >= low)) { low = 0; high = 1; }
    const margin = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1e-6;
    [low, high] = tall.get(plot.id) || [low - margin, high + margin];
    const X = t => LEFT + (t - t0) / (t1 - t0) * (width - LEFT - RIGHT);
    const Y = y => head + body * (1 - (y - low) / (high - low));
    plot.height = y => low + (head + body - y) / body * (high - low);
    axes(g, c, { low, high, t0, t1, X, Y, head, body, width });
    g.fillStyle = c.ink; g.font = "600 12px system-ui,sans-serif"; g.textAlign = "left";
    if (kind === "values") g.fillText(trace.word, 8, 14);
    if (cursors) between(g, c, plot, run, width);
    g.save();
    g.fillStyle = c.pale; g.font = "11.5px system-ui,sans-serif"; g.textAlign = "center";
    g.translate(12, head + body / 2); g.rotate(-Math.PI / 2);
    g.fillText(kind === "values" ? trace.unit : `error, ${trace.errorUnit}`, 0, 0);
    g.restore();
    g.save();
    g.beginPath(); g.rect(LEFT, head - 2, width - LEFT - RIGHT, body + 4); g.clip();
    curves.forEach(one => curve(g, one, X, Y));
    const upright = (t, colour, dashed) => {
      if (t === null || t < t0 || t > t1) return;
      g.strokeStyle = colour; g.lineWidth = 1; if (dashed) g.setLineDash([3, 3]);
      g.beginPath(); g.moveTo(X(t), head); g.lineTo(X(t), head + body); g.stroke(); g.setLineDash([]);
    };
    run.events.forEach(([t]) => upright(t, c.event, true));
    if (kind === "values") words(g, c, run, t0, t1, X, head, width);
    upright(shared.time, c.third);
    upright(hover, c.pale);
    g.textAlign = "left";
    (cursors || []).forEach((t, k) => {
      upright(t, c.ink);
      if (t >= t0 && t <= t1) { g.fillStyle = c.ink; g.font = "600 11px system-ui,sans-serif"; g.fillText("AB"[k], X(t) + 3, head + body - 4); }
    });
    if (box) {
      const [x0, x1] = [...box.x].sort((p, q) => p - q), [y0, y1] = [...box.y].sort((p, q) => p - q), own = box.plot === plot;
      const is_tall = own && y1 - y0 > 12;
      g.fillStyle = c.after; g.globalAlpha = own ? 0.18 : 0.08;
      g.fillRect(x0, is_tall ? y0 : head, x1 - x0, is_tall ? y1 - y0 : body);
      g.globalAlpha = 1;
    }
    g.restore();
  }

  // What the cursors read, above the plot.
  function between(g, c, { trace, kind }, run, width) {
    const [a, b] = cursors.map(t => sample(trace, run, t));
    const three = (word, list, factor) => `${word}A ${digits(list[a] * factor)}  B ${digits(list[b] * factor)}  B−A ${digits((list[b] - list[a]) * factor)}`;
    const narrow = width < 560;
    const text = kind === "values" ? `${three("", trace.values, trace.factor)} ${trace.unit}`
      : (narrow ? "" : three("before: ", trace.before, trace.errorFactor) + "   ") + `${three("after: ", trace.after, trace.errorFactor)} ${trace.errorUnit}`;
    g.font = "11px system-ui,sans-serif"; g.fillStyle = c.pale; g.textAlign = "right";
    g.fillText(text, width - RIGHT, 14);
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

  function nameOf(ending) {
    const part = window_ ? "_" + window_.map(t => t.toFixed(4)).join("-") + "s" : "";
    return runOf(shared.run).name.replace(/[^\w.-]+/g, "_") + part + ending;
  }
  function saveCsv() {
    const run = runOf(shared.run), keys = new Set(run.traces.map(t => t.key).filter(key => !hidden.has(key)));
    for (const { run: own, offset } of drawn()) {
      const [t0, t1] = range();
      const name = own === run ? nameOf(".csv") : own.name.replace(/[^\w.-]+/g, "_") + "_over_" + nameOf(".csv");
      save(name, new Blob([csvOf(own, keys, [t0 - offset, t1 - offset], true)], { type: "text/csv" }));
    }
  }
  // The view as it stands, twice as fine.
  function savePng() {
    const c = colours(), FINE = 2, HEAD = 44;
    sharpness.ratio = FINE;
    drawAll();
    const all = [...plots.map(plot => plot.canvas), time], width = time.width;
    const sheet = make("canvas", { width, height: HEAD * FINE + all.reduce((sum, canvas) => sum + canvas.height, 0) });
    const g = sheet.getContext("2d");
    g.fillStyle = c.ground; g.fillRect(0, 0, sheet.width, sheet.height);
    g.setTransform(FINE, 0, 0, FINE, 0, 0);
    g.fillStyle = c.ink; g.font = "600 13px system-ui,sans-serif"; g.fillText(runOf(shared.run).name, 8, 16);
    g.font = "12px system-ui,sans-serif";
    let x = 8;
    for (const own of legend.children) {
      if (own.getAttribute("aria-pressed") !== "true") continue;
      g.strokeStyle = own.firstElementChild.style.borderColor; g.lineWidth = 3;
      g.beginPath(); g.moveTo(x, 32); g.lineTo(x + 22, 32); g.stroke();
      g.fillText(own.textContent, x + 27, 36);
      x += 27 + g.measureText(own.textContent).width + 16;
    }
    g.setTransform(1, 0, 0, 1, 0, 0);
    let y = HEAD * FINE;
    for (const canvas of all) { g.drawImage(canvas, 0, y); y += canvas.height; }
    sharpness.ratio = 0;
    drawAll();
    sheet.toBlob(blob => save(nameOf(".png"), blob), "image/png");
  }

  shared.listeners.push(change => {
    if ("run" in change) { window_ = null; hover = null; tall.clear(); if (cursors) setCursors(true); build(); }
    else if (!("silent" in change)) drawAll();
  });
  redraws.push(build);
  build();
}
