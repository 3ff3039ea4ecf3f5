// The page: a pipeline's text at the left, what becomes of it at the right.
import { Editor } from "./editor.js";
import { element } from "./element.js";
import { listed } from "./problems.js";
import { fill, filter } from "./settings.js";
import { pack, unpack } from "./share.js";
import { listen_to_drops, listen_to_stage } from "./stage.js";
import { Answerer } from "./worker.js";

const $ = (id) => document.getElementById(id);

const SYSTEMS = ["nebula", "mantis", "caracal", "awsm", "lore", "umbra"];
const SCENES = ["courtyard", "figure", "foliage", "interior"];
const SIZE = [960, 540];
/** So long after the last keystroke every configuration is checked. */
const CHECK_AFTER = 1500;

/** The files as they come, and what was changed of them. */
const files = await (await fetch("files.json")).json();
const changed = {};
let templates = {};
const text_of = (path) => changed[path] ?? files[path] ?? templates[path] ?? "";

const chosen = { pipeline: "pipelines/umbra.json", scene: "courtyard", preset: "", parameters: {}, features: {} };
const open = [];
let shown = null;
/** The last answer of the checker that had a plan. */
let planned = null;

const values = () => {
  const { preset, parameters, features } = chosen;
  return JSON.stringify({ format: 1, ...(preset && { preset }), parameters, features });
};

// ---------------------------------------------------------------- checking

/** What was changed as of the last answer: with it the checker begins again when it dies. */
const last_good = {};
const checker = new Answerer("checker.js", {
  begin: (self) => void self.ask("write", { files: { ...files, ...last_good } }).catch(() => {}),
  died(reason) {
    notice(`The checker stopped at this text of ${shown} and was started again with the one before: ${reason}`);
  },
});

/** What checks every configuration, which takes longer than to type: an edit ends it. */
const prover = new Answerer("checker.js", {
  begin: (self) => void self.ask("write", { files: { ...files, ...changed } }).catch(() => {}),
});

let asked = 0;
let later = 0;

/** Checks what is written, and draws it where it is right. */
async function check() {
  const number = ++asked;
  clearTimeout(later);
  prover.stop("something was changed");
  try {
    const answer = await checker.ask("plan", { path: chosen.pipeline, values: values(), size: SIZE });
    Object.assign(last_good, changed);
    if (number !== asked) return;
    tell(answer, false);
    if (!answer.plan) return;
    planned = answer.plan;
    show_plan();
    draw_pipeline();
    later = setTimeout(() => check_all(number), CHECK_AFTER);
  } catch {
    // The notice says it.
  }
}

/** Checks every configuration. */
async function check_all(number) {
  const answer = await prover.ask("check", { path: chosen.pipeline, size: SIZE }).catch(() => null);
  if (answer && number === asked) tell(answer, true);
}

const plural = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;

function tell({ diagnostics, milliseconds }, is_all) {
  const count = (severity) => diagnostics.filter((one) => one.severity === severity).length;
  const [errors, warnings] = [count("error"), count("warning")];
  const state = $("state");
  state.dataset.state = errors ? "error" : warnings ? "warning" : "fine";
  const words = errors ? plural(errors, "error") : warnings ? plural(warnings, "warning") : is_all ? "proven in every configuration" : "valid";
  state.textContent = words;
  state.title = `${is_all ? "Every configuration was checked" : "One configuration was planned"} in ${milliseconds.toFixed(0)} ms`;
  problems(diagnostics);
}

function problems(diagnostics) {
  const here = diagnostics.filter((one) => one.place?.file === shown && one.place.line);
  const range = ({ line, column, end_line, end_column }) => {
    const from = editor.offset(line, column);
    return { from, to: Math.max(from, editor.offset(end_line, end_column)) };
  };
  const changes = (fix) => fix.map(({ place, replacement }) => ({ ...range(place), insert: replacement }));
  const mend = (one) => one.fix?.every(({ place }) => place?.file === shown) && (() => editor.edit(changes(one.fix)));
  editor.underline(here.map((one) => ({
    ...range(one.place), severity: one.severity === "note" ? "info" : one.severity,
    message: `${one.message}${one.help ? `\n${one.help}` : ""}`,
    actions: mend(one) ? [{ name: "Mend", apply: () => mend(one)() }] : [],
  })));
  $("problems").replaceChildren(listed(diagnostics, {
    mend,
    go({ file, line, column }) {
      if (text_of(file)) show(file);
      if (line) editor.go(editor.offset(line, column));
    },
  }));
}

function notice(text) {
  $("notice").hidden = !text;
  $("notice").textContent = text ?? "";
}

// ---------------------------------------------------------------- text

const editor = new Editor($("editor"), {
  changed(path, text) {
    if (text === (files[path] ?? templates[path])) delete changed[path];
    else changed[path] = text;
    checker.ask("write", { files: { [path]: text } }).catch(() => {});
    painter?.ask("write", { files: { [path]: text } }).catch(() => {});
    mark_tabs();
    check();
  },
});

const short = (path) => path.replace(/^pipelines\//, "");

function show(path) {
  if (!open.includes(path)) open.push(path);
  shown = path;
  editor.show(path, text_of(path));
  mark_tabs();
}

function mark_tabs() {
  $("tabs").replaceChildren(...open.map((path) => {
    const tab = element("button", { type: "button", role: "tab", textContent: `${short(path)}${path in changed ? " •" : ""}` });
    tab.setAttribute("aria-selected", String(path === shown));
    tab.tabIndex = path === shown ? 0 : -1;
    tab.onclick = () => {
      show(path);
      check();
    };
    return tab;
  }));
}

/** The files that are behind the plan, and all templates. */
function fill_open() {
  const { passes, resources } = planned.report;
  const places = [...passes, ...resources].map(({ declared }) => declared.replace(/:\d+$/, ""));
  const used = [...new Set([chosen.pipeline, ...places])].filter((path) => path in files).sort();
  const option = (path) => element("option", { value: path, textContent: short(path) });
  $("open").replaceChildren(
    element("option", { value: "", textContent: "Open…" }),
    element("optgroup", { label: "Files of the pipeline" }, ...used.map(option)),
    element("optgroup", { label: "Templates" }, ...Object.keys(templates).map(option)),
  );
}

// ---------------------------------------------------------------- plan

const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(1)} MiB`;

let filled = "";

function show_plan() {
  const { report, settings, presets } = planned;
  const live = report.passes.filter((pass) => pass.live).length;
  const culled = report.passes.length - live;
  $("figures").textContent = `${live} ${live === 1 ? "pass" : "passes"}` +
    `${culled ? `, ${culled} culled` : ""} · ${megabytes(report.memory.created)} of textures and buffers`;
  // Controls that are in use stay as they are.
  const kind = JSON.stringify([chosen.pipeline, chosen.preset, Object.keys(settings.parameters), Object.keys(settings.features)]);
  if (kind !== filled) {
    filled = kind;
    fill($("settings"), settings, set);
    filter($("settings"), $("find").value);
    fill_open();
    const option = (name) => element("option", { value: name, textContent: name || "none", selected: name === chosen.preset });
    $("preset").replaceChildren(...["", ...presets].map(option));
    $("preset").disabled = !presets.length;
  }
  if (!$("graph").hidden) show_graph();
}

function set(kind, name, value, is_live) {
  chosen[kind][name] = value;
  if (is_live) painter?.ask("set", { name, value }).catch((error) => notice(error.message));
  else check();
}

async function show_graph() {
  const page = await checker.ask("graph", { path: chosen.pipeline, values: values(), size: SIZE }).catch(() => null);
  const frame = $("graph").querySelector("iframe");
  if (page && frame.srcdoc !== page) frame.srcdoc = page;
}

// ---------------------------------------------------------------- frame

let painter = null;
let view = [0, 0, 1];
let is_opened = false;

const cover = (text) => {
  $("cover").hidden = !text;
  $("cover").textContent = text ?? "";
};

/**
 * Starts what draws, on a canvas of its own: one that was lent once cannot be lent again. A device that is lost is replaced
 * once, by one whose pictures are read back: some browsers draw, and lose the device when they are to show it.
 */
async function open_painter(is_plain = false) {
  is_opened = false;
  painter?.stop("it is replaced");
  $("stage").querySelector("canvas")?.remove();
  const canvas = element("canvas", { width: SIZE[0], height: SIZE[1] });
  $("stage").append(canvas);
  painter = new Answerer("painter.js", {
    died: (reason) => is_opened && cover(`Drawing stopped: ${reason}\nReload the page to start it again.`),
    events({ frame, failed, lost }) {
      if (lost !== undefined && !is_plain) return void open_painter(true).catch((error) => cover(error.message));
      if (lost !== undefined) return cover(`The device is lost: ${lost}\nReload the page to get another.`);
      if (failed) return cover(failed);
      cover("");
      $("time").textContent = `${frame.recorded.toFixed(1)} ms to record, ${frame.total.toFixed(0)} ms to the end of the frame`;
      document.documentElement.dataset.frames = Number(document.documentElement.dataset.frames ?? 0) + 1;
    },
  });
  const lent = canvas.transferControlToOffscreen();
  await painter.ask("open", { canvas: lent, is_plain }, [lent]);
  await painter.ask("write", { files: { ...files, ...changed } });
  is_opened = true;
  await take_scene();
}

async function take_scene(bytes, name = `${chosen.scene}.glb`) {
  if (!is_opened) return;
  const taken = bytes ?? (await (await fetch(`scenes/${name}`)).arrayBuffer());
  try {
    await painter.ask("scene", { name, bytes: taken }, [taken]);
    await draw_pipeline();
  } catch (error) {
    cover(error.message);
  }
}

let is_drawing = false;
let is_due = false;

/** Gives the painter what is written; what is written meanwhile is given next. */
async function draw_pipeline() {
  if (!is_opened || !planned) return;
  if (is_drawing) {
    is_due = true;
    return;
  }
  is_drawing = true;
  const answer = await painter.ask("pipeline", { path: chosen.pipeline, values: values(), size: SIZE }).catch(() => null);
  const errors = answer?.diagnostics.filter((one) => one.severity === "error") ?? [];
  if (errors.length) cover(answer.text);
  is_drawing = false;
  if (is_due) {
    is_due = false;
    draw_pipeline();
  }
}

function look(side, up, distance) {
  view = [view[0] + side, Math.max(-1.2, Math.min(1.2, view[1] + up)), Math.max(0.1, Math.min(6, view[2] * distance))];
  painter?.ask("look", { view }).catch(() => {});
}

async function save() {
  const texels = await painter.ask("read");
  const canvas = new OffscreenCanvas(...SIZE);
  canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(texels), ...SIZE), 0, 0);
  const link = element("a", { href: URL.createObjectURL(await canvas.convertToBlob()), download: `${short(chosen.pipeline).replace(/\W+/g, "-")}.png` });
  link.click();
  URL.revokeObjectURL(link.href);
}

// ---------------------------------------------------------------- choices

function choose(pipeline) {
  Object.assign(chosen, { pipeline, preset: "", parameters: {}, features: {} });
  open.length = 0;
  editor.clear();
  planned = null;
  label_next();
  show(pipeline);
  check();
}

function label_next() {
  $("next").textContent = lessons().includes(chosen.pipeline) ? "Next lesson" : "First lesson";
}

function fill_choices() {
  const option = (path, name) => element("option", { value: path, textContent: name, selected: path === chosen.pipeline });
  const systems = SYSTEMS.map((name) => option(`pipelines/${name}.json`, name));
  const extended = Object.keys(files).filter((path) => path.startsWith("pipelines/extended/"));
  const named = (path) => option(path, path.replace(/^.*\/|\.json$/g, "").replaceAll(/[-_]/g, " "));
  $("pipeline").replaceChildren(
    element("optgroup", { label: "Systems" }, ...systems),
    element("optgroup", { label: "Lessons" }, ...lessons().map(named)),
    element("optgroup", { label: "Extended systems" }, ...extended.map(named)),
  );
  $("scene").replaceChildren(...SCENES.map((name) => element("option", { value: name, textContent: name, selected: name === chosen.scene })));
}

const lessons = () => Object.keys(files).filter((path) => /^pipelines\/learn\/[^/]+$/.test(path));

/** The arrow keys go from tab to tab. */
function move_among_tabs(list, key) {
  if (key !== "ArrowLeft" && key !== "ArrowRight") return;
  const at = [...list.children].findIndex((tab) => tab.getAttribute("aria-selected") === "true");
  const to = (at + (key === "ArrowRight" ? 1 : list.children.length - 1)) % list.children.length;
  list.children[to].click();
  list.children[to].focus();
}

function listen() {
  $("pipeline").onchange = () => choose($("pipeline").value);
  $("scene").onchange = () => {
    chosen.scene = $("scene").value;
    take_scene();
  };
  $("preset").onchange = () => {
    Object.assign(chosen, { preset: $("preset").value, parameters: {}, features: {} });
    check();
  };
  $("open").onchange = () => {
    if ($("open").value) show($("open").value);
    $("open").value = "";
    check();
  };
  $("find").oninput = () => filter($("settings"), $("find").value);
  $("play").onclick = () => {
    const on = $("play").getAttribute("aria-pressed") !== "true";
    $("play").setAttribute("aria-pressed", String(on));
    $("play").textContent = on ? "Pause" : "Play";
    painter?.ask("play", { on }).catch(() => {});
  };
  $("reset").onclick = () => {
    view = [0, 0, 1];
    look(0, 0, 1);
  };
  $("save").onclick = () => save().catch((error) => notice(error.message));
  $("share").onclick = async () => {
    location.hash = await pack({ chosen, changed });
    await navigator.clipboard?.writeText(location.href).catch(() => {});
    $("share").textContent = "Copied";
    setTimeout(() => ($("share").textContent = "Copy link"), 1500);
  };
  $("theme").onclick = () => {
    const dark = document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.theme = dark ? "light" : "dark";
  };
  const views = [...$("views").children];
  const pick = (picked) => {
    for (const tab of views) {
      tab.setAttribute("aria-selected", String(tab === picked));
      tab.tabIndex = tab === picked ? 0 : -1;
      $(tab.getAttribute("aria-controls")).hidden = tab !== picked;
    }
    if (picked.id === "tab-graph") show_graph();
  };
  views.forEach((tab) => (tab.onclick = () => pick(tab)));
  for (const id of ["tabs", "views"]) $(id).onkeydown = (event) => move_among_tabs($(id), event.key);
  $("next").onclick = () => {
    const all = lessons();
    choose(all[(all.indexOf(chosen.pipeline) + 1) % all.length]);
    $("pipeline").value = chosen.pipeline;
  };
  listen_to_stage($("stage"), look);
  listen_to_drops(take_scene);
}

const shared = await unpack(location.hash);
Object.assign(chosen, shared?.chosen);
Object.assign(changed, shared?.changed);
fill_choices();
label_next();
listen();
show(chosen.pipeline);
checker.ask("templates").then((found) => {
  templates = found;
  if (planned) fill_open();
}, () => {});
check();
if (navigator.gpu) {
  open_painter().catch((error) => {
    cover(error.message);
    notice(`Nothing can be drawn: ${error.message}. The page still checks, plans and explains.`);
  });
} else {
  cover("This browser has no WebGPU.");
  notice("This browser has no WebGPU, so nothing is drawn. The page still checks, plans and explains.");
}
