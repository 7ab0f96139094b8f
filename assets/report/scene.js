// The machine from its own meshes: drawn triangle by triangle into a picture with a depth for every point, so that it
// needs no graphics card and no library.
function sceneView(root) {
  const machine = page.machine;
  if (!machine || !machine.surfaces.length) return false;
  const surfaces = machine.surfaces.map(s => {
    const surface = { moves: s.moves, vertices: floats(s.vertices), triangles: new Uint32Array(bytes(s.triangles)) };
    surface.edges = features(surface);
    return surface;
  });
  const box = bounds(surfaces), size = Math.max(...[0, 1, 2].map(k => box[1][k] - box[0][k]));
  const middle = [0, 1, 2].map(k => (box[0][k] + box[1][k]) / 2);
  const turning = page.motion === "revolute";
  const home = { azimuth: 0.62, elevation: 0.5, zoom: 1 };
  const view = { ...home };
  const state = { playing: false, rate: 1, factor: 1, twin: "before", loads: machine.sliders.length > 0, mode: -1, phase: 0, joint: 0 };
  const hasRuns = page.runs.length > 0;
  const hasTwin = hasRuns && page.runs[0].traces.some(t => t.before);

  const canvas = make("canvas", { className: "view", tabIndex: 0, role: "img",
    "aria-label": "the machine in three dimensions; arrow keys turn it, plus and minus zoom" + (hasRuns ? ", space plays" : "") });
  const readout = make("p", { className: "readout", role: "status" });
  const bar = make("div", { className: "bar" }), options = make("div", { className: "bar" });
  root.append(canvas, bar, readout, options,
    make("p", { className: "hint" }, "Drag or arrow keys turn the machine, wheel with Ctrl, pinch or + − zoom" + (hasRuns ? ", space plays." : ".")));
  controls();

  function controls() {
    if (hasRuns) {
      const play = make("button", { type: "button", "aria-pressed": "false", onclick: () => toggle() }, "▶ play");
      const scrub = make("input", { type: "range", min: 0, max: 1000, value: 0, step: 1, "aria-label": "time",
        oninput: () => shared.set({ time: scrub.value / 1000 * runOf(shared.run).end }) });
      const time = make("output", {}, "0.000 s");
      state.follow = () => {
        scrub.value = String(Math.round(1000 * shared.time / runOf(shared.run).end));
        time.textContent = shared.time.toFixed(3) + " s";
        play.textContent = state.playing ? "❚❚ pause" : "▶ play";
        play.setAttribute("aria-pressed", String(state.playing));
      };
      bar.append(play, make("span", { className: "scrub" }, scrub, time));
      options.append(runPicker(), choice("speed", [["¼", 0.25], ["1", 1], ["4", 4]], 1, value => { state.rate = value; }, "×"));
    } else {
      const [from, to] = machine.limits;
      const scrub = make("input", { type: "range", min: 0, max: 1000, value: String(1000 * (0 - from) / (to - from)), "aria-label": "joint position",
        oninput: () => { state.joint = from + scrub.value / 1000 * (to - from); draw(); } });
      bar.append(make("label", { className: "scrub" }, "joint", scrub));
    }
    if (hasTwin) {
      options.append(choice("twin", [[(page.before || "twin as it is").replace("twin ", ""), "before"], ["with the causes", "after"], ["hidden", ""]], "before", value => { state.twin = value; draw(); }));
      const factors = [1, 10, 100, 1000, 10000, 100000];
      state.factor = automatic(factors);
      options.append(choice("gap shown", factors.map(f => [f.toLocaleString("en").replace(/,/g, " "), f]), state.factor, value => { state.factor = value; draw(); }, "× "));
    }
    if (machine.sliders.length && hasRuns) {
      const tick = make("input", { type: "checkbox", checked: true, onchange: () => { state.loads = tick.checked; draw(); } });
      options.append(make("label", {}, tick, "slider loads"));
    }
    if (machine.modes.length) {
      const modes = [["base at rest", -1], ...machine.modes.map(([hertz], k) => [`base mode ${k + 1}: ${hertz} Hz`, k])];
      options.append(choice("base", modes, -1, value => { state.mode = value; loop(); draw(); }));
    }
    options.append(make("button", { type: "button", onclick: () => { Object.assign(view, home); draw(); } }, "reset view"));
  }
  function choice(word, list, value, act, before) {
    const select = make("select", { "aria-label": word, onchange: () => act(list[select.selectedIndex][1]) });
    list.forEach(([text, own]) => select.append(make("option", { selected: own === value }, (before || "") + text)));
    return make("label", {}, word, select);
  }

  function position(run) { return run.traces.find(t => t.key.startsWith("position")) || null; }
  // The factor that makes the largest gap a visible share of the machine.
  function automatic(factors) {
    let most = 0;
    page.runs.forEach((_, k) => {
      if (k > 3) return;
      const trace = position(runOf(k));
      if (trace && trace.before) for (const e of trace.before) most = Math.max(most, Math.abs(e));
    });
    const wanted = turning ? 0.35 : 0.05 * size;
    return factors.filter(f => f * most <= wanted).pop() || 1;
  }
  function sampled(at, values, sample) {
    const k = Math.min(Math.max(lower(at, sample), 1), values.length - 1);
    const share = Math.min(Math.max((sample - at[k - 1]) / Math.max(at[k] - at[k - 1], 1e-9), 0), 1);
    return values[k - 1] + share * (values[k] - values[k - 1]);
  }
  function moment() {
    if (!hasRuns) return { q: state.joint, gap: null };
    const run = runOf(shared.run), sample = shared.time / run.period, trace = position(run);
    if (!trace) return { q: run.reference.values.length ? sampled(run.reference.at, run.reference.values, sample) : 0, gap: null };
    const q = sampled(trace.at, trace.values, sample);
    const errors = state.twin && trace[state.twin];
    return { q, gap: errors ? sampled(trace.at, errors, sample) : null, trace };
  }

  // Camera: parallel projection, as in the still picture; the first view fills the canvas.
  let spans = null;
  function camera(width, height) {
    const { azimuth: a, elevation: e, zoom } = view;
    const right = [Math.cos(a), -Math.sin(a), 0], up = [Math.sin(a) * Math.sin(e), Math.cos(a) * Math.sin(e), Math.cos(e)];
    const toward = [-Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
    if (!spans) {
      spans = [0, 0];
      for (const { vertices } of surfaces) for (let k = 0; k < vertices.length; k += 3) {
        const p = [0, 1, 2].map(n => vertices[k + n] - middle[n]);
        spans = [Math.max(spans[0], Math.abs(dot(p, right))), Math.max(spans[1], Math.abs(dot(p, up)))];
      }
    }
    const scale = zoom * Math.min((width - 30) / (2 * spans[0]), (height - 60) / (2 * spans[1]));
    return { right, up, toward, scale, width, height, project(p) {
      const d = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]];
      return [width / 2 + scale * dot(d, right), height / 2 + 8 - scale * dot(d, up), dot(d, toward)];
    } };
  }
  // Where a point of the moving part is at joint position q.
  function mover(q, base) {
    const [x, y, z] = machine.axis, o = machine.origin;
    if (!turning) { const s = q + base; return p => [p[0] + x * s, p[1] + y * s, p[2] + z * s]; }
    const c = Math.cos(q), s = Math.sin(q);
    return p => {
      const r = [p[0] - o[0], p[1] - o[1], p[2] - o[2]], d = x * r[0] + y * r[1] + z * r[2];
      const n = [y * r[2] - z * r[1], z * r[0] - x * r[2], x * r[1] - y * r[0]];
      return [0, 1, 2].map(k => o[k] + r[k] * c + n[k] * s + machine.axis[k] * d * (1 - c));
    };
  }

  let buffer = null;
  function draw() {
    const c = colours();
    const width = canvas.clientWidth || 600;
    const { context: g, height, ratio } = fitted(canvas, Math.max(260, Math.min(460, width * 0.56)), width > 700 ? 1.5 : 2);
    const look = camera(width, height), now = moment();
    const base = state.mode < 0 ? 0 : 0.03 * size * Math.sin(state.phase);
    const stands = p => [p[0] + machine.axis[0] * base, p[1] + machine.axis[1] * base, p[2] + machine.axis[2] * base];
    const moves = mover(now.q, base);
    paint(g, c, look, ratio, surface => surface.moves ? moves : stands);
    if (now.gap !== null && state.twin) ghost(g, c, look, mover(now.q - state.factor * now.gap, base));
    if (turning) {
      spoke(g, c.measured, look, moves);
      if (now.gap !== null && state.twin) spoke(g, state.twin === "before" ? c.before : c.after, look, mover(now.q - state.factor * now.gap, base));
    }
    direction(g, c, look);
    scaleBar(g, c, look);
    if (state.loads) loads(g, c, look, moves);
    tell(now);
    if (state.follow) state.follow();
  }

  // Fills the triangles, nearest first by depth, and draws the edges between faces.
  function paint(g, c, look, ratio, placed) {
    const w = canvas.width, h = canvas.height;
    if (!buffer || buffer.w !== w || buffer.h !== h) buffer = { w, h, image: new ImageData(w, h), depth: new Float32Array(w * h) };
    const pixels = new Uint32Array(buffer.image.data.buffer), depth = buffer.depth;
    pixels.fill(packed(rgb(c.card))); depth.fill(-Infinity);
    const dark = luminance(rgb(c.card)) < 0.4;
    const edges = [];
    for (const surface of surfaces) {
      const { vertices: v, triangles: t } = surface, of = placed(surface), n = v.length / 3;
      const world = new Float32Array(3 * n), flat = new Float32Array(3 * n);
      for (let k = 0; k < n; k++) {
        const p = of([v[3 * k], v[3 * k + 1], v[3 * k + 2]]), s = look.project(p);
        world.set(p, 3 * k);
        flat[3 * k] = s[0] * ratio; flat[3 * k + 1] = s[1] * ratio; flat[3 * k + 2] = s[2];
      }
      const tint = surface.moves ? (dark ? [62, 140, 190] : [70, 150, 205]) : (dark ? [150, 158, 165] : [205, 210, 214]);
      for (let k = 0; k < t.length; k += 3) triangle(pixels, depth, w, h, world, flat, t[k], t[k + 1], t[k + 2], look, tint);
      edges.push([surface, flat]);
    }
    const line = packed(dark ? [12, 14, 16] : [60, 66, 72]);
    for (const [surface, flat] of edges) for (let k = 0; k < surface.edges.length; k += 2) {
      segment(pixels, depth, w, h, flat, surface.edges[k], surface.edges[k + 1], line);
    }
    g.putImageData(buffer.image, 0, 0);
  }

  function triangle(pixels, depth, w, h, world, flat, i, j, k, look, tint) {
    i *= 3; j *= 3; k *= 3;
    const ux = world[j] - world[i], uy = world[j + 1] - world[i + 1], uz = world[j + 2] - world[i + 2];
    const vx = world[k] - world[i], vy = world[k + 1] - world[i + 1], vz = world[k + 2] - world[i + 2];
    let nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const length = Math.hypot(nx, ny, nz);
    if (!length) return;
    nx /= length; ny /= length; nz /= length;
    const facing = nx * look.toward[0] + ny * look.toward[1] + nz * look.toward[2];
    if (facing <= 0) return;
    const side = nx * look.right[0] + ny * look.right[1] + nz * look.right[2];
    const light = Math.min(1.12, 0.42 + 0.38 * Math.max(nz, 0) + 0.25 * facing + 0.12 * side);
    const colour = packed(tint.map(x => Math.min(255, x * light)));
    const [ax, ay, az, bx, by, bz, cx, cy, cz] = [flat[i], flat[i + 1], flat[i + 2], flat[j], flat[j + 1], flat[j + 2], flat[k], flat[k + 1], flat[k + 2]];
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if (!area) return;
    const y0 = Math.max(0, Math.ceil(Math.min(ay, by, cy))), y1 = Math.min(h - 1, Math.floor(Math.max(ay, by, cy)));
    for (let y = y0; y <= y1; y++) {
      // Where the three edges cut this row.
      let from = Infinity, to = -Infinity;
      const cut = (px, py, qx, qy) => {
        if ((py <= y && qy > y) || (qy <= y && py > y)) {
          const x = px + (y - py) / (qy - py) * (qx - px);
          if (x < from) from = x; if (x > to) to = x;
        }
      };
      cut(ax, ay, bx, by); cut(bx, by, cx, cy); cut(cx, cy, ax, ay);
      const x0 = Math.max(0, Math.floor(from)), x1 = Math.min(w - 1, Math.ceil(to));
      for (let x = x0; x <= x1; x++) {
        const s = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area, r = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area;
        const z = az + s * (bz - az) + r * (cz - az), at = y * w + x;
        if (z > depth[at]) { depth[at] = z; pixels[at] = colour; }
      }
    }
  }
  function segment(pixels, depth, w, h, flat, i, j, colour) {
    const [ax, ay, az, bx, by, bz] = [flat[3 * i], flat[3 * i + 1], flat[3 * i + 2], flat[3 * j], flat[3 * j + 1], flat[3 * j + 2]];
    const steps = Math.ceil(Math.max(Math.abs(bx - ax), Math.abs(by - ay)));
    if (!(steps > 0) || steps > 8000) return;
    for (let n = 0; n <= steps; n++) {
      const s = n / steps, x = Math.round(ax + s * (bx - ax)), y = Math.round(ay + s * (by - ay));
      if (x < 0 || y < 0 || x >= w || y >= h) continue;
      if (az + s * (bz - az) > depth[y * w + x] - 0.006 * size) pixels[y * w + x] = colour;
    }
  }

  function ghost(g, c, look, of) {
    g.strokeStyle = state.twin === "before" ? c.before : c.after; g.lineWidth = 1.1;
    g.beginPath();
    for (const surface of surfaces) {
      if (!surface.moves) continue;
      const at = k => look.project(of([surface.vertices[3 * k], surface.vertices[3 * k + 1], surface.vertices[3 * k + 2]]));
      for (let k = 0; k < surface.edges.length; k += 2) {
        const a = at(surface.edges[k]), b = at(surface.edges[k + 1]);
        g.moveTo(a[0], a[1]); g.lineTo(b[0], b[1]);
      }
    }
    g.stroke();
  }
  // A mark on what turns: without it a disc seems to stand.
  let rim = null;
  function spoke(g, colour, look, of) {
    if (!rim) {
      const o = machine.origin, n = machine.axis;
      const across = Math.abs(n[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
      const r = [n[1] * across[2] - n[2] * across[1], n[2] * across[0] - n[0] * across[2], n[0] * across[1] - n[1] * across[0]];
      const length = Math.hypot(...r);
      let top = -Infinity, reach = 0;
      for (const { moves, vertices: v } of surfaces) if (moves) for (let k = 0; k < v.length; k += 3) {
        const d = [v[k] - o[0], v[k + 1] - o[1], v[k + 2] - o[2]], along = dot(d, n);
        top = Math.max(top, along); reach = Math.max(reach, Math.sqrt(Math.max(dot(d, d) - along * along, 0)));
      }
      const centre = o.map((x, k) => x + top * n[k]);
      rim = [centre, centre.map((x, k) => x + reach * r[k] / length)];
    }
    const [a, b] = rim.map(p => look.project(of(p)));
    g.strokeStyle = colour; g.lineWidth = 2.2;
    g.beginPath(); g.moveTo(a[0], a[1]); g.lineTo(b[0], b[1]); g.stroke();
  }
  function arrow(g, from, to) {
    const dx = to[0] - from[0], dy = to[1] - from[1], length = Math.hypot(dx, dy);
    if (length < 1) return;
    const [ux, uy] = [dx / length, dy / length], head = Math.min(9, length);
    g.beginPath(); g.moveTo(from[0], from[1]); g.lineTo(to[0] - ux * head * 0.7, to[1] - uy * head * 0.7); g.stroke();
    g.beginPath(); g.moveTo(to[0], to[1]);
    g.lineTo(to[0] - head * ux + head * 0.45 * uy, to[1] - head * uy - head * 0.45 * ux);
    g.lineTo(to[0] - head * ux - head * 0.45 * uy, to[1] - head * uy + head * 0.45 * ux);
    g.closePath(); g.fill();
  }
  function label(g, c, text, x, y, align) {
    g.font = "600 12px system-ui,sans-serif"; g.textAlign = align || "left"; g.lineJoin = "round";
    g.lineWidth = 3.5; g.strokeStyle = c.card; g.strokeText(text, x, y);
    g.fillStyle = c.ink; g.fillText(text, x, y);
  }
  function direction(g, c, look) {
    const flat = [dot(machine.axis, look.right), -dot(machine.axis, look.up)], long = 44 / Math.max(Math.hypot(...flat), 0.2);
    const at = [look.width - 62, look.height - 40], half = flat.map(x => x * long / 2);
    g.strokeStyle = g.fillStyle = c.after; g.lineWidth = 2;
    arrow(g, [at[0] - half[0], at[1] - half[1]], [at[0] + half[0], at[1] + half[1]]);
    label(g, c, turning ? "+ axis" : "+ direction", look.width - 12, look.height - 8, "right");
  }
  function scaleBar(g, c, look) {
    const wanted = 0.22 * look.width / look.scale, decade = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map(m => m * decade).find(m => m <= wanted) || decade;
    const y = look.height - 14, x = 14, px = length * look.scale;
    g.strokeStyle = c.ink; g.lineWidth = 2;
    g.beginPath(); g.moveTo(x, y - 5); g.lineTo(x, y); g.lineTo(x + px, y); g.lineTo(x + px, y - 5); g.stroke();
    label(g, c, `${Number((1000 * length).toPrecision(3))} mm`, x + px + 8, y + 3);
  }
  function loads(g, c, look, of) {
    const all = hasRuns && page.runs[shared.run].loads;
    if (!all || !all.values.length) return;
    const k = Math.min(Math.round(shared.time / runOf(shared.run).period / all.every), all.values.length - 1);
    const most = Math.max(...all.values.flat().map(Math.abs), 1e-9);
    const [rest] = all.values;
    g.lineWidth = 3;
    const labels = [];
    const middleX = machine.sliders.reduce((sum, [, place]) => sum + look.project(of(place))[0], 0) / machine.sliders.length;
    machine.sliders.forEach(([name, place], n) => {
      const load = all.values[k][n], p = of(place);
      const from = look.project(p), to = look.project([p[0], p[1], p[2] + 0.22 * size * load / most]);
      g.strokeStyle = g.fillStyle = c.third;
      arrow(g, from, to);
      const change = load - rest[n];
      const more = look.width > 520 ? ` (${change < 0 ? "−" : "+"}${Math.abs(change).toFixed(1)})` : "";
      const text = `${name.slice(-1).toUpperCase()} ${load.toFixed(0)} N${more}`, isLeft = to[0] < middleX;
      labels.push([text, to[0] + (isLeft ? -7 : 7), to[1] + 2, isLeft ? "right" : "left"]);
    });
    // On top of all arrows.
    labels.forEach(([text, x, y, align]) => label(g, c, text, x, y, align));
  }
  function tell({ q, gap, trace }) {
    const nice = (x, unit) => `${String(Number(x.toPrecision(4))).replace("-", "−")} ${unit}`;
    const parts = [];
    if (trace) parts.push(`position ${nice(q * trace.factor, trace.unit)}`);
    if (gap !== null && gap !== undefined) parts.push(`machine less twin ${nice(gap * trace.errorFactor, trace.errorUnit)}, drawn ${state.factor} times as large`);
    if (state.loads && hasRuns) parts.push("slider loads in N, in brackets the change since the start");
    if (state.mode >= 0) {
      const [hertz, kg] = machine.modes[state.mode];
      parts.push(`base mode at ${hertz} Hz, modal mass ${kg} kg: drawn once a second and far too large; the model knows its motion along the joint`);
    }
    readout.textContent = parts.join(" · ");
  }

  // Motion in time.
  let last = null, running = false;
  // The first time from the beginning, then on from where it was halted; at the end over again.
  let begun = false;
  function toggle() { state.playing = !state.playing; last = null; if (state.playing && !begun) { begun = true; shared.set({ time: 0 }); } loop(); draw(); }
  shared.listeners.push(change => { if ("run" in change) begun = state.playing; });
  function loop() {
    if (running) return;
    running = true;
    requestAnimationFrame(step);
  }
  function step(now) {
    const passed = last === null ? 0 : Math.min((now - last) / 1000, 0.1);
    last = now;
    if (state.mode >= 0) state.phase += 2 * Math.PI * passed;
    if (state.playing) {
      const end = runOf(shared.run).end;
      const time = shared.time + passed * state.rate;
      shared.set({ time: time >= end ? 0 : time });
    } else if (state.mode >= 0) draw();
    if (state.playing || state.mode >= 0) requestAnimationFrame(step); else { running = false; last = null; draw(); }
  }

  // Mouse, touch, keyboard.
  const active = new Map();
  const turn = (dx, dy) => { view.azimuth += dx; view.elevation = Math.min(1.5, Math.max(-0.4, view.elevation + dy)); draw(); };
  const nearer = factor => { view.zoom = Math.min(20, Math.max(0.4, view.zoom * factor)); draw(); };
  canvas.addEventListener("pointerdown", event => { active.set(event.pointerId, [event.clientX, event.clientY]); canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", event => {
    if (!active.has(event.pointerId)) return;
    const [x, y] = active.get(event.pointerId);
    if (active.size === 2) {
      const [, other] = [...active.entries()].find(([id]) => id !== event.pointerId);
      const span = (px, py) => Math.hypot(px - other[0], py - other[1]);
      nearer(span(event.clientX, event.clientY) / Math.max(span(x, y), 1));
    } else turn((event.clientX - x) * 0.008, (event.clientY - y) * 0.006);
    active.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, event => active.delete(event.pointerId));
  canvas.addEventListener("wheel", event => {
    if (!event.ctrlKey && !event.metaKey && !event.shiftKey) return;
    event.preventDefault(); nearer(event.deltaY > 0 ? 0.9 : 1.1);
  }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const acts = { ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.08), ArrowDown: () => turn(0, -0.08),
      "+": () => nearer(1.15), "=": () => nearer(1.15), "-": () => nearer(0.87), "0": () => { Object.assign(view, home); draw(); }, " ": () => { if (hasRuns) toggle(); } };
    if (acts[event.key]) { acts[event.key](); event.preventDefault(); }
  });
  if (hasRuns) {
    // The moment of the largest gap says more than the first one.
    const trace = position(runOf(0)), run = runOf(0);
    if (trace && trace.before) {
      let best = 0;
      trace.before.forEach((e, k) => { if (Math.abs(e) > Math.abs(trace.before[best])) best = k; });
      shared.time = trace.at[best] * run.period;
    }
  }
  shared.listeners.push(() => draw());
  redraws.push(draw);
  draw();
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
function bounds(surfaces) {
  const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (const { vertices } of surfaces) for (let k = 0; k < vertices.length; k++) {
    box[0][k % 3] = Math.min(box[0][k % 3], vertices[k]); box[1][k % 3] = Math.max(box[1][k % 3], vertices[k]);
  }
  return box;
}
// Edges at which two faces meet at an angle, or that have one face only.
function features({ vertices: v, triangles: t }) {
  // Corners at one place are one corner.
  const place = new Map(), same = new Uint32Array(v.length / 3);
  for (let k = 0; k < same.length; k++) {
    const key = `${v[3 * k].toFixed(6)},${v[3 * k + 1].toFixed(6)},${v[3 * k + 2].toFixed(6)}`;
    if (!place.has(key)) place.set(key, k);
    same[k] = place.get(key);
  }
  const sides = new Map();
  for (let k = 0; k < t.length; k += 3) {
    const [a, b, c] = [same[t[k]], same[t[k + 1]], same[t[k + 2]]];
    const at = n => [v[3 * n], v[3 * n + 1], v[3 * n + 2]];
    const [p, q, r] = [at(a), at(b), at(c)], u = [0, 1, 2].map(n => q[n] - p[n]), w = [0, 1, 2].map(n => r[n] - p[n]);
    const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]], length = Math.hypot(...n) || 1;
    const normal = n.map(x => x / length);
    for (const [from, to] of [[a, b], [b, c], [c, a]]) {
      const key = from < to ? `${from}_${to}` : `${to}_${from}`;
      if (!sides.has(key)) sides.set(key, { from, to, normals: [] });
      sides.get(key).normals.push(normal);
    }
  }
  const edges = [];
  for (const { from, to, normals } of sides.values()) if (normals.length !== 2 || dot(normals[0], normals[1]) < 0.85) edges.push(from, to);
  return Uint32Array.from(edges);
}
function rgb(text) {
  const hex = text.replace("#", ""), full = hex.length === 3 ? [...hex].map(x => x + x).join("") : hex;
  return [0, 2, 4].map(k => parseInt(full.slice(k, k + 2), 16) || 0);
}
const luminance = ([r, g, b]) => (0.3 * r + 0.59 * g + 0.11 * b) / 255;
const packed = ([r, g, b]) => (255 << 24 | b << 16 | g << 8 | r) >>> 0;
