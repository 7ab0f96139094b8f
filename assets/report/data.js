"use strict";
// Data of the page: numbers as text, unpacked once.
const page = JSON.parse(document.getElementById("data").textContent);

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) out[k] = raw.charCodeAt(k);
  return out.buffer;
}
const floats = text => new Float32Array(bytes(text));
function shorts(packed) {
  if (!packed) return null;
  const codes = new Int16Array(bytes(packed.codes));
  return Float32Array.from(codes, code => code * packed.step);
}
function places(text, count) {
  if (text) return new Uint32Array(bytes(text));
  return Uint32Array.from({ length: count }, (_, k) => k);
}

// A property that is worked out when it is first asked for.
function lazy(object, name, make) {
  Object.defineProperty(object, name, { configurable: true, enumerable: true, get() {
    const value = make();
    Object.defineProperty(object, name, { value });
    return value;
  } });
}

// One run as typed arrays, unpacked when it is first shown.
const unpacked = new Map();
function runOf(index) {
  if (unpacked.has(index)) return unpacked.get(index);
  const raw = page.runs[index];
  const reference = floats(raw.reference.values);
  const run = {
    name: raw.name, role: raw.role, period: raw.period_s, samples: raw.samples,
    end: raw.samples * raw.period_s, events: raw.events, loads: raw.loads,
    reference: { at: places(raw.reference.at, reference.length), values: reference },
    traces: raw.traces.map(t => {
      const trace = { key: t.key, word: t.word, unit: t.unit, factor: t.factor, errorUnit: t.error_unit, errorFactor: t.error_factor };
      lazy(trace, "values", () => floats(t.values));
      lazy(trace, "at", () => places(t.at, trace.values.length));
      lazy(trace, "before", () => shorts(t.before));
      lazy(trace, "after", () => shorts(t.after));
      return trace;
    }),
  };
  unpacked.set(index, run);
  return run;
}

// First place in a sorted list that is not below a value.
function lower(list, value) {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] < value) low = middle + 1; else high = middle;
  }
  return low;
}

// What all live views share: the run, the moment, the colours.
const redraws = [];
const shared = {
  run: 0, time: 0, listeners: [],
  set(change) { Object.assign(this, change); for (const listen of this.listeners) listen(change); },
};
function colours() {
  const style = getComputedStyle(document.querySelector(".fig") || document.documentElement);
  const page = getComputedStyle(document.documentElement);
  const of = name => style.getPropertyValue("--" + name).trim() || "#777";
  const names = ["ground", "ink", "pale", "line", "measured", "before", "after", "reference", "law", "event", "heat", "third", "second", "calibration", "unexplained", "noise"];
  const found = Object.fromEntries(names.map(name => [name, of(name)]));
  found.card = page.getPropertyValue("--card").trim() || "#eee";
  return found;
}

function make(tag, properties, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(properties || {})) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key in element && key !== "list") element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

// Pictures that are saved are finer than the screen.
const sharpness = { ratio: 0 };
// A canvas as fine as the screen; returns its context and its size in CSS px.
function fitted(canvas, height, most) {
  const ratio = Math.min(sharpness.ratio || window.devicePixelRatio || 1, most || 3);
  const width = canvas.clientWidth || canvas.parentElement.clientWidth || 300;
  canvas.style.height = height + "px";
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height, ratio };
}

function runPicker() {
  const select = make("select", { "aria-label": "run", onchange: () => shared.set({ run: Number(select.value), time: 0 }) });
  page.runs.forEach((run, k) => select.append(make("option", { value: k }, run.role ? `${run.name} (${run.role})` : run.name)));
  shared.listeners.push(() => { select.value = String(shared.run); });
  return make("label", {}, "run", select);
}
