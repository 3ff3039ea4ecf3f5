// Parameters and features as controls.
import { element } from "./element.js";

const rounded = (number) => Number(number.toPrecision(4)).toString();

/** The step of a slider: a thousandth of its range, or one of whole numbers. */
function step({ type, min, max }) {
  if (type === "u32" || type === "i32") return 1;
  return 10 ** Math.floor(Math.log10((max - min) / 500));
}

function control(name, about, id, set) {
  const { value, values, min, max } = about;
  if (values?.length) {
    const options = values.map((word) => element("option", { value: word, textContent: word, selected: word === value }));
    const select = element("select", { id, className: "wide" }, ...options);
    select.onchange = () => set(name, select.value);
    return [select];
  }
  if (typeof value === "boolean") {
    const box = element("input", { id, type: "checkbox", checked: value, className: "wide" });
    box.onchange = () => set(name, box.checked);
    return [box];
  }
  if (typeof value === "number" && min != null && max != null) {
    const shown = element("output", { textContent: rounded(value) });
    const slider = element("input", { id, type: "range", min, max, step: step(about), value });
    slider.oninput = () => {
      shown.textContent = rounded(slider.valueAsNumber);
      if (about.live) set(name, slider.valueAsNumber);
    };
    slider.onchange = () => set(name, slider.valueAsNumber);
    return [slider, shown];
  }
  if (typeof value === "number") {
    const box = element("input", { id, type: "number", step: "any", value, className: "wide" });
    box.onchange = () => Number.isFinite(box.valueAsNumber) && set(name, box.valueAsNumber);
    return [box];
  }
  if (value.every?.((one) => typeof one === "number")) {
    const set_all = () => boxes.every((box) => box.reportValidity() && box.value) && set(name, boxes.map((box) => box.valueAsNumber));
    const boxes = value.map((one, at) => {
      const box = element("input", { id: at ? `${id}-${at}` : id, type: "number", step: "any", value: rounded(one), onchange: set_all });
      if (min != null) box.min = min;
      if (max != null) box.max = max;
      if (at) box.setAttribute("aria-label", `${name.replaceAll("_", " ")}, number ${at + 1}`);
      return box;
    });
    return [element("span", { className: "wide list" }, ...boxes)];
  }
  const box = element("input", { id, type: "text", value: JSON.stringify(value), className: "wide" });
  box.onchange = () => {
    try {
      set(name, JSON.parse(box.value));
      box.setCustomValidity("");
    } catch {
      box.setCustomValidity("a list of numbers in brackets");
      box.reportValidity();
    }
  };
  return [box];
}

function group(title, entries, kind, set) {
  if (!entries.length) return [];
  const rows = entries.map(([name, about]) => {
    const id = `${kind}-${name}`;
    const label = element("label", { htmlFor: id, textContent: name.replaceAll("_", " ") });
    if (about.unit && about.unit !== "1") label.append(` (${about.unit})`);
    const row = element("div", { className: "setting" }, label, ...control(name, about, id, set));
    row.dataset.find = `${name.replaceAll("_", " ")} ${about.description ?? ""}`.toLowerCase();
    if (about.description) row.append(element("p", { className: "about", textContent: about.description }));
    return row;
  });
  return [element("fieldset", {}, element("legend", { textContent: title }), ...rows)];
}

/** Fills a form; `set` is called with `parameters` or `features`, a name, a value, and whether it can be set in a frame. */
export function fill(form, settings, set) {
  const parameters = Object.entries(settings.parameters);
  const of = (live) => parameters.filter(([, about]) => about.live === live);
  form.replaceChildren(
    ...group("In each frame", of(true), "parameters", (name, value) => set("parameters", name, value, true)),
    ...group("Features", Object.entries(settings.features), "features", (name, value) => set("features", name, value, false)),
    ...group("Planned again", of(false), "parameters", (name, value) => set("parameters", name, value, false)),
  );
}

/** Shows the settings that contain a word. */
export function filter(form, word) {
  for (const row of form.querySelectorAll(".setting")) row.hidden = !row.dataset.find.includes(word.toLowerCase());
  for (const fields of form.querySelectorAll("fieldset")) fields.hidden = !fields.querySelector(".setting:not([hidden])");
}
