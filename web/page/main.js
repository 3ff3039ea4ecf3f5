// The page: a pipeline's text at the left, what becomes of it at the right.
import { fill_choices, move_among_tabs, switch_theme } from "./choices.js";
import { Course, is_solved, step_of } from "./course.js";
import { Editor } from "./editor.js";
import { element } from "./element.js";
import { listen_to_folder } from "./folder.js";
import { Frame, cover } from "./frame.js";
import { fill_gallery } from "./gallery.js";
import { beside } from "./graph/beside.js";
import { Graph } from "./graph/graph.js";
import { LanguageClient } from "./language.js";
import { keep_frame, keep_offline } from "./offline.js";
import { told } from "./problems.js";
import { parse, pipeline_address } from "./route.js";
import { fill, filter } from "./settings.js";
import { keep, pack, unpack } from "./share.js";
import { listen_to_drops, listen_to_stage } from "./stage.js";
import { changed, files, original, scene_bytes, take, templates, text_of } from "./texts.js";
import { VALUES, Values } from "./values.js";
import { Answerer } from "./worker.js";

const $ = (id) => document.getElementById(id);

const SIZE = [960, 540];
/** So long after the last keystroke every configuration is checked. */
const CHECK_AFTER = 1500;

const chosen = { pipeline: "pipelines/umbra.json", scene: "courtyard", preset: "", parameters: {}, features: {} };
const open = [];
let shown = null;
/** The last answer of the checker that had a plan. */
let planned = null;

const hand = new Values(chosen);
const values = () => hand.text;
// ---------------------------------------------------------------- checking

/** What was changed as of the last answer: with it the checker begins again when it dies. */
const last_good = { ...changed };
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
/** The checker's last answer, with a plan or without. */
let answered = null;

/** Checks what is written, and draws it where it is right. */
async function check() {
  const number = ++asked;
  clearTimeout(later);
  prover.stop("something was changed");
  try {
    const answer = await checker.ask("plan", { path: chosen.pipeline, values: values(), size: SIZE });
    Object.assign(last_good, changed);
    keep(changed);
    if (number !== asked) return;
    tell(answer, false);
    answered = answer;
    judge();
    if (!answer.plan) return $("graph").hidden || show_graph();
    planned = answer.plan;
    show_plan();
    if (!answer.diagnostics.some(({ severity }) => severity === "error")) frame.draw();
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
  $("problems").replaceChildren(told(diagnostics, editor, shown, (path) => (path === VALUES || text_of(path)) && show(path)));
  if (is_all) return;
  performance.clearMarks("diagnostics");
  performance.mark("diagnostics");
}

function notice(text) {
  $("notice").hidden = !text;
  $("notice").textContent = text ?? "";
}

// ---------------------------------------------------------------- text

const language = new LanguageClient({
  show(path) {
    show(path);
    return editor.view;
  },
  edit: (path, update) => edited(path, editor.edit_hidden(path, text_of(path), update)),
});

const editor = new Editor($("editor"), {
  changed: edited,
  extension: (path) => (path === VALUES ? [] : language.extension(path)),
});
for (const event of ["focusin", "pointerenter"]) $("editor").addEventListener(event, () => language.start());

function edited(path, text) {
  if (path === VALUES) {
    hand.type(text);
    filled = "";
    return void check();
  }
  take(path, text);
  write({ [path]: text });
  mark_tabs();
  check();
}

/** Gives files to what checks and what draws; those that come later take them from what is changed. */
function write(given) {
  checker.ask("write", { files: given }).catch(() => {});
  frame.write(given);
  language.write(given);
}

const short = (path) => path.replace(/^pipelines\//, "");

function show(path) {
  if (!open.includes(path)) open.push(path);
  shown = path;
  editor.show(path, path === VALUES ? values() : text_of(path));
  mark_tabs();
}

/** Shows the parameter file anew, if it is shown. */
function show_values() {
  if (shown === VALUES) show(VALUES);
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

/** The files that are behind the plan. */
function used_files() {
  const { passes, resources } = planned.report;
  const places = [...passes, ...resources].map(({ declared }) => declared.replace(/:\d+$/, ""));
  return [...new Set([chosen.pipeline, ...places])].filter((path) => path in files || path in changed).sort();
}

function fill_open() {
  const used = used_files();
  const option = (path) => element("option", { value: path, textContent: short(path) });
  $("open").replaceChildren(
    element("option", { value: "", textContent: "Open…" }),
    element("optgroup", { label: "Files of the pipeline" }, ...used.map(option), option(VALUES)),
    element("optgroup", { label: "Changed" }, ...Object.keys(changed).filter((path) => !used.includes(path)).sort().map(option)),
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
  const range = ([name, { min, max }]) => [name, min, max];
  const kind = JSON.stringify([chosen.pipeline, chosen.preset, Object.entries(settings.parameters).map(range), Object.keys(settings.features)]);
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
  hand.take({ [kind]: { [name]: value } });
  show_values();
  if (!is_live) return void check();
  frame.set(name, value).catch((error) => notice(error.message));
  judge();
}

/** Asks the checker about the pipeline as it is chosen. */
const ask = (kind, asked) => checker.ask(kind, { path: chosen.pipeline, values: values(), size: SIZE, ...asked });

const graph = new Graph($("graph"), beside({ ask, editor, text_of, show, shown: () => shown, frame: () => frame }));

async function show_graph() {
  const number = asked;
  const answer = await ask("graph").catch(() => null);
  if (answer && planned && number === asked) graph.show(chosen.pipeline, planned.report, answer);
}

// ---------------------------------------------------------------- frame

const frame = new Frame(SIZE, {
  files: () => ({ ...files, ...changed }),
  scene: () => chosen.scene,
  scene_bytes,
  asked: () => planned && { path: chosen.pipeline, values: values() },
});

function start_frame() {
  if (!navigator.gpu) return cover("This browser has no WebGPU.");
  frame.start().then(() => keep_frame(chosen.scene), (error) => {
    cover(error.message);
    notice(`Nothing can be drawn: ${error.message}. The page still checks, plans and explains.`);
  });
}

// ---------------------------------------------------------------- course

const course = new Course($("course"), {
  solve(step, { file = step.pipeline, edits = [], values }) {
    if (edits.length) {
      show(file);
      editor.edit(edits.flatMap(([find, insert]) => {
        const from = text_of(file).indexOf(find);
        return from < 0 ? [] : [{ from, to: from + find.length, insert }];
      }));
    }
    if (values) set_values(values);
  },
  reset({ pipeline, tasks }) {
    for (const path of new Set(tasks.map(({ file = pipeline }) => file))) revert(path);
    choose(pipeline);
  },
});

const judge = () => answered && course.judge({ ...answered, values: chosen });

function set_values(found) {
  hand.take(found);
  filled = "";
  show_values();
  check();
}

/** Brings a file back as it came, as one step of undo. */
function revert(path) {
  if (!(path in changed) || original(path) === undefined) return;
  show(path);
  editor.edit([{ from: 0, to: text_of(path).length, insert: original(path) }]);
}

// ---------------------------------------------------------------- project

const take_dropped = listen_to_folder({
  begin: (name, kind) => checker.ask("project", { name, of: kind }),
  used: () => [chosen.pipeline, ...(planned ? used_files() : [])],
  values: () => (hand.is_set ? values() : null),
  write,
  notice,
  take_scene: (bytes, name) => frame.take_scene(bytes, name),
  open(pipeline = chosen.pipeline, scene, found) {
    fill_choices(chosen);
    history.pushState(null, "", pipeline_address(pipeline, scene));
    go();
    if (found) edited(VALUES, found);
  },
  revert() {
    const { pipeline } = chosen;
    Object.keys(changed).forEach(revert);
    show(pipeline);
  },
});

// ---------------------------------------------------------------- choices

function choose(pipeline) {
  chosen.pipeline = pipeline;
  hand.clear();
  open.length = 0;
  planned = answered = null;
  $("pipeline").value = pipeline;
  show(pipeline);
  check();
}

/** Shows what the address asks for. */
async function go() {
  const { link, step: id, ...route } = parse(location.hash);
  const shared = link ? await unpack(link) : null;
  const step = step_of(id) ?? null;
  const { pipeline, scene } = step ?? shared?.chosen ?? route;
  const is_work = Boolean(pipeline) && (text_of(pipeline) !== "" || Boolean(shared?.changed[pipeline]));
  document.body.dataset.view = is_work ? "work" : "gallery";
  $("gallery").hidden = is_work;
  $("work").hidden = !is_work;
  document.title = is_work ? `${step?.title ?? short(pipeline).replace(/\.json$/, "")} · umbragraph` : "umbragraph";
  course.show(is_work ? step : null);
  if (!is_work) return fill_gallery($("gallery"), is_solved);
  if (shared) {
    const before = Object.keys(changed).map((path) => [path, original(path) ?? ""]);
    Object.keys(changed).forEach((path) => delete changed[path]);
    Object.assign(changed, shared.changed);
    editor.clear();
    write({ ...Object.fromEntries(before), ...changed });
    fill_choices(chosen);
  }
  const is_other_scene = scene && scene !== chosen.scene;
  if (scene) $("scene").value = chosen.scene = scene;
  choose(pipeline);
  if (shared) set_values(shared.chosen);
  if (!frame.is_started) start_frame();
  else if (is_other_scene) frame.take_scene();
}

function listen() {
  $("pipeline").onchange = () => (location.hash = pipeline_address($("pipeline").value));
  addEventListener("hashchange", go);
  $("scene").onchange = () => {
    chosen.scene = $("scene").value;
    frame.take_scene();
  };
  $("preset").onchange = () => {
    hand.clear($("preset").value);
    show_values();
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
    frame.play(on);
  };
  $("reset").onclick = () => frame.reset();
  $("save").onclick = () => frame.save(`${short(chosen.pipeline).replace(/\W+/g, "-")}.png`).catch((error) => notice(error.message));
  $("share").onclick = async () => {
    history.replaceState(null, "", await pack({ chosen, changed }));
    await navigator.clipboard?.writeText(location.href).catch(() => {});
    $("share").textContent = "Copied";
    setTimeout(() => ($("share").textContent = "Copy link"), 1500);
  };
  $("theme").onclick = switch_theme;
  const views = [...$("views").children];
  const pick = (picked) => {
    for (const tab of views) {
      tab.setAttribute("aria-selected", String(tab === picked));
      tab.tabIndex = tab === picked ? 0 : -1;
      $(tab.getAttribute("aria-controls")).hidden = tab !== picked;
    }
    if (picked.id === "tab-graph" && planned) show_graph();
  };
  views.forEach((tab) => (tab.onclick = () => pick(tab)));
  for (const id of ["tabs", "views"]) $(id).onkeydown = (event) => move_among_tabs($(id), event.key);
  listen_to_stage($("stage"), (...way) => frame.look(...way));
  listen_to_drops(take_dropped);
}

keep_offline();
fill_choices(chosen);
listen();
if (!navigator.gpu) notice("This browser has no WebGPU, so nothing is drawn. The page still checks, plans and explains.");
checker.ask("templates").then((found) => {
  Object.assign(templates, found);
  if (planned) fill_open();
}, () => {});
go();
