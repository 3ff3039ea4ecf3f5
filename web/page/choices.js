// The lists at the top, tabs, and the theme.
import { element } from "./element.js";
import { changed, files, original, other_scenes } from "./texts.js";
import { is_pipeline } from "./zip.js";

const $ = (id) => document.getElementById(id);

const SYSTEMS = ["nebula", "mantis", "caracal", "awsm", "lore", "umbra"];
const SCENES = ["courtyard", "figure", "foliage", "interior"];

/** Fills the lists of pipelines and scenes. */
export function fill_choices(chosen) {
  const option = (path, name) => element("option", { value: path, textContent: name, selected: path === chosen.pipeline });
  const lessons = Object.keys(files).filter((path) => /^pipelines\/learn\/[^/]+$/.test(path));
  const systems = SYSTEMS.map((name) => option(`pipelines/${name}.json`, name));
  const extended = Object.keys(files).filter((path) => path.startsWith("pipelines/extended/"));
  const named = (path) => option(path, path.replace(/^.*\/|\.json$/g, "").replaceAll(/[-_]/g, " "));
  const own = Object.keys(changed).filter((path) => original(path) === undefined && is_pipeline(path, changed[path]));
  $("pipeline").replaceChildren(
    ...(own.length ? [element("optgroup", { label: "Project" }, ...own.map(named))] : []),
    element("optgroup", { label: "Systems" }, ...systems),
    element("optgroup", { label: "Lessons" }, ...lessons.map(named)),
    element("optgroup", { label: "Extended systems" }, ...extended.map(named)),
  );
  $("scene").replaceChildren(...[...SCENES, ...other_scenes()].map((name) => element("option", { value: name, textContent: name, selected: name === chosen.scene })));
}

/** The arrow keys go from tab to tab. */
export function move_among_tabs(list, key) {
  if (key !== "ArrowLeft" && key !== "ArrowRight") return;
  const at = [...list.children].findIndex((tab) => tab.getAttribute("aria-selected") === "true");
  const to = (at + (key === "ArrowRight" ? 1 : list.children.length - 1)) % list.children.length;
  list.children[to].click();
  list.children[to].focus();
}

/** From light to dark, or back. */
export function switch_theme() {
  const { dataset } = document.documentElement;
  const is_dark = dataset.theme ? dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  dataset.theme = is_dark ? "light" : "dark";
}
