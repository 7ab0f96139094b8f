//! Pages in a real browser: plots are drawn, nothing runs over the edge, no error is told.
//!
//! Needs Chromium: `.ci/run` installs it; SLIDEWAY_CHROMIUM names another one. Pictures are left in the folder of the
//! tests' temporary files.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{self, needs};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const SLIDEWAY: &str = env!("CARGO_BIN_EXE_slideway");
/// Virtual time that a page has to come to rest, in ms.
const REST_MS: u32 = 4000;
/// Widths of a desktop's page and of a telephone's.
const DESKTOP: u32 = 1000;
const PHONE: u32 = 390;
/// A picture of one colour, or of paper and one ink, shows nothing.
const LEAST_COLOURS: u64 = 4;
/// A page of ten figures printed is larger than this.
const LEAST_PDF: u64 = 50_000;

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("screenshots");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs Chromium and returns its standard output and what pages told on their console.
fn browse(arguments: &[&str], file: &Path) -> (String, Vec<String>) {
    let profile = tempfile::TempDir::new().unwrap();
    let output = Command::new(support::chromium().unwrap())
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--enable-logging=stderr",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("--virtual-time-budget={REST_MS}"))
        .args(arguments)
        .arg(format!("file://{}", file.display()))
        .output()
        .unwrap();
    let console = String::from_utf8_lossy(&output.stderr);
    // Probes read canvases back, which Chromium remarks on.
    let told = |line: &&str| line.contains("CONSOLE") && !line.contains("willReadFrequently");
    let console = console.lines().filter(told).map(str::to_owned).collect();
    (String::from_utf8_lossy(&output.stdout).into_owned(), console)
}

/// What a page is asked once it stands: canvases and their colours, its width, labels, errors.
const PROBE: &str = r#"<script>
setTimeout(() => {
  const canvases = [...document.querySelectorAll("canvas")].map(canvas => {
    const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
    return { name: canvas.getAttribute("aria-label"), colours: new Set(pixels).size, width: canvas.width };
  });
  const shown = [...document.querySelectorAll("svg.fig")].filter(svg => svg.getBoundingClientRect().width > 0);
  const smallest = Math.min(...shown.flatMap(svg => {
    const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
    return [...svg.querySelectorAll("text")].map(text => scale * Number(text.getAttribute("font-size")));
  }));
  const texts = shown.flatMap(svg => [...svg.querySelectorAll("text")].map(text => text.textContent));
  const edges = shown.flatMap(svg => {
    const box = svg.getBoundingClientRect();
    return [...svg.querySelectorAll("text")].filter(text => {
      const own = text.getBoundingClientRect();
      return own.right > box.right + 2 || own.left < box.left - 2;
    }).map(text => text.textContent);
  });
  parent.postMessage(JSON.stringify({
    canvases, texts, edges, smallest, inner: innerWidth, scroll: document.documentElement.scrollWidth,
    height: document.documentElement.scrollHeight, ground: getComputedStyle(document.body).backgroundColor,
  }), "*");
}, 1200);
</script>"#;

/// A page in a frame of this width, and what it answers.
fn framed(page: &str, probe: &str, name: &str, width: u32) -> PathBuf {
    let inside = page.replace("</body>", &format!("{probe}</body>"));
    let inside = serde_json::to_string(&inside).unwrap().replace('<', "\\u003c");
    let text = format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><body style=\"margin:0\"><pre id=\"answer\" hidden></pre>\
         <iframe id=\"frame\" style=\"border:0;width:{width}px;height:9000px\"></iframe><script>\
         onmessage = event => {{ const answer = document.getElementById('answer'); answer.textContent = event.data; \
         document.getElementById('frame').style.height = JSON.parse(event.data).height + 'px'; }};\
         document.getElementById('frame').srcdoc = {inside};</script></body>"
    );
    let file = folder().join(format!("{name}.html"));
    fs::write(&file, text).unwrap();
    file
}

fn answer(dom: &str) -> Value {
    let text = dom
        .split_once("<pre id=\"answer\" hidden=\"\">")
        .expect("an answer")
        .1
        .split_once("</pre>")
        .unwrap()
        .0;
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Looks at a page in one width and either theme, and leaves a picture of it.
fn look(page: &str, name: &str, width: u32, is_dark: bool) -> Value {
    let file = framed(page, PROBE, name, width);
    let theme = format!("--blink-settings=preferredColorScheme={}", if is_dark { 0 } else { 1 });
    let window = format!("--window-size={},1200", width.max(520));
    let (dom, console) = browse(&["--dump-dom", &theme, &window], &file);
    assert!(console.is_empty(), "{name}: {console:?}");
    let told = answer(&dom);
    let tall = format!("--window-size={},{}", width.max(520), told["height"].as_u64().unwrap().min(16_000));
    let picture = folder().join(format!("{name}.png"));
    let shot = format!("--screenshot={}", picture.display());
    browse(&[&shot, &theme, &tall], &file);
    assert!(fs::metadata(&picture).is_ok_and(|file| file.len() > 10_000), "no picture of {name}");
    told
}

/// Canvases that show something, no text cut or too small, nothing over the edge.
fn assert_sound(told: &Value, name: &str, canvases: usize) {
    let list = told["canvases"].as_array().unwrap();
    assert!(list.len() >= canvases, "{name}: {} canvases", list.len());
    for canvas in list {
        assert!(canvas["colours"].as_u64().unwrap() >= LEAST_COLOURS, "{name}: blank {canvas}");
    }
    let (scroll, inner) = (told["scroll"].as_u64().unwrap(), told["inner"].as_u64().unwrap());
    assert!(scroll <= inner + 1, "{name}: {scroll} px in {inner}");
    assert_eq!(told["edges"].as_array().unwrap().len(), 0, "{name}: cut {}", told["edges"]);
    // None where no still figure is shown.
    assert!(
        told["smallest"].as_f64().is_none_or(|px| px >= 7.5),
        "{name}: letters of {} px",
        told["smallest"]
    );
}

fn has_text(told: &Value, wanted: &str) -> bool {
    told["texts"].as_array().unwrap().iter().any(|text| text.as_str().is_some_and(|t| t.contains(wanted)))
}

fn report() -> &'static (String, PathBuf) {
    static REPORT: OnceLock<(String, PathBuf)> = OnceLock::new();
    REPORT.get_or_init(|| {
        let file = folder().join("report.html");
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let output = Command::new(SLIDEWAY)
            .args(["diagnose", "assets/hidden_coulomb", "--quiet", "--html"])
            .arg(&file)
            .current_dir(root)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (fs::read_to_string(&file).unwrap(), file)
    })
}

#[test]
fn exact_plots_are_drawn_on_a_desktop() {
    needs!(support::chromium());
    let told = look(&report().0, "desktop", DESKTOP, false);
    // The machine, and value and error of five signals.
    assert_sound(&told, "desktop", 11);
    for label in ["frequency in Hz", "speed in m/min", "position in mm", "time in s", "guide"] {
        assert!(has_text(&told, label), "no {label}");
    }
}

#[test]
fn exact_a_telephone_shows_everything_in_its_width() {
    needs!(support::chromium());
    assert_sound(&look(&report().0, "phone", PHONE, false), "phone", 11);
}

#[test]
fn exact_the_readers_dark_ground_is_kept() {
    needs!(support::chromium());
    let told = look(&report().0, "dark", DESKTOP, true);
    assert_sound(&told, "dark", 11);
    assert_eq!(told["ground"], "rgb(20, 23, 26)");
}

#[test]
fn exact_without_a_script_the_still_figures_stand() {
    needs!(support::chromium());
    let page = &report().0;
    let still = page[..page.rfind("<script>").unwrap()].to_owned() + "</body></html>";
    let told = look(&still, "no_script", DESKTOP, false);
    assert_sound(&told, "no_script", 0);
    assert_eq!(told["canvases"].as_array().unwrap().len(), 0);
    assert!(has_text(&told, "error, µm") && has_text(&told, "position"), "traces without a script");
}

/// Plays the machine, turns it, zooms the traces, changes the run; tells after each whether the picture changed.
const HANDS: &str = r#"<script>
// In virtual time no frames are asked for.
window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 16);
const sum = canvas => new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer)
  .reduce((all, pixel) => (all * 31 + pixel) >>> 0, 7);
const changed = {};
const act = (name, canvas, hand) => { const before = sum(canvas()); hand(); changed[name] = () => sum(canvas()) !== before; };
const settle = name => { changed[name] = changed[name](); };
const view = () => document.querySelector("canvas.view"), trace = () => document.querySelector("canvas.trace");
const key = (element, name) => element.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true }));
const pointer = (kind, x, y) => view().dispatchEvent(new PointerEvent(kind, { pointerId: 1, clientX: x, clientY: y, bubbles: true }));
view().setPointerCapture = () => {};
const press = word => [...document.querySelectorAll("button")].find(button => button.textContent === word).click();
let saved = 0;
URL.createObjectURL = blob => { if (blob.size > 1000) saved++; return "data:,"; };
const option = (label, index) => {
  const select = document.querySelector(`select[aria-label="${label}"]`);
  select.selectedIndex = index; select.dispatchEvent(new Event("change"));
};
const steps = [
  ["turn", view, () => key(view(), "ArrowLeft")],
  ["drag", view, () => { pointer("pointerdown", 50, 50); pointer("pointermove", 90, 60); pointer("pointerup", 90, 60); }],
  ["factor", view, () => option("gap shown", 3)],
  ["box", trace, () => {
    trace().setPointerCapture = () => {};
    const hand = (kind, x, y) => { const at = trace().getBoundingClientRect();
      trace().dispatchEvent(new PointerEvent(kind, { pointerId: 1, clientX: at.left + x, clientY: at.top + y, bubbles: true })); };
    hand("pointerdown", 200, 40); hand("pointermove", 300, 60); hand("pointerup", 300, 90);
  }],
  ["cursors", trace, () => press("cursors A B")],
  ["overlay", trace, () => option("overlay", 1)],
  ["png", () => { const sheet = document.createElement("canvas"); sheet.width = sheet.height = 1; sheet.getContext("2d").fillRect(0, 0, saved, 1); return sheet; },
    () => { press("save CSV"); press("save PNG"); }],
  ["zoom", trace, () => key(trace().parentElement, "+")],
  ["shift", trace, () => key(trace().parentElement, "ArrowRight")],
  ["run", trace, () => option("run", 1)],
  ["scrub", view, () => { const s = document.querySelector(".scrub input"); s.value = 200; s.dispatchEvent(new Event("input")); }],
  ["mode", view, () => option("base", 1)],
  ["play", view, () => document.querySelector(".bar button").click()],
];
let at = 0;
const next = () => {
  if (at > 0) settle(steps[at - 1][0]);
  if (at === steps.length) { parent.postMessage(JSON.stringify({ changed, height: 4000 }), "*"); return; }
  act(...steps[at++]);
  setTimeout(next, 250);
};
setTimeout(next, 600);
</script>"#;

#[test]
fn exact_hands_move_the_machine_and_the_traces() {
    needs!(support::chromium());
    let file = framed(&report().0, HANDS, "hands", DESKTOP);
    let (dom, console) = browse(&["--dump-dom", "--window-size=1000,1200"], &file);
    assert!(console.is_empty(), "{console:?}");
    let told = answer(&dom);
    let changed = told["changed"].as_object().unwrap();
    assert_eq!(changed.len(), 13, "{told}");
    assert!(changed.values().all(|value| value == true), "{told}");
}

#[test]
fn exact_a_page_prints() {
    needs!(support::chromium());
    let pdf = folder().join("report.pdf");
    let print = format!("--print-to-pdf={}", pdf.display());
    let (_, console) = browse(&[&print, "--no-pdf-header-footer"], &report().1);
    assert!(console.is_empty(), "{console:?}");
    let bytes = fs::read(&pdf).unwrap();
    assert!(bytes.starts_with(b"%PDF") && bytes.len() as u64 > LEAST_PDF, "{} bytes", bytes.len());
}

#[test]
fn exact_other_pages_are_drawn_too() {
    needs!(support::chromium());
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (name, arguments, canvases) in [
        ("inspect_machine", vec!["inspect", "models/grinder"], 1),
        ("inspect_recording", vec!["inspect", "assets/hidden_coulomb"], 6),
        ("identify", vec!["identify", "--machine", "models/grinder"], 0),
        ("inspect_turning", vec!["inspect", "models/delta_a3/machine.toml"], 1),
    ] {
        let file = folder().join(format!("{name}_page.html"));
        let output = Command::new(SLIDEWAY)
            .args(&arguments)
            .args(["--quiet", "--html"])
            .arg(&file)
            .current_dir(root)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_sound(&look(&fs::read_to_string(&file).unwrap(), name, PHONE, false), name, canvases);
    }
}
