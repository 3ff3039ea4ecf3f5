// What a node of the graph is, in words, with all that one can do to it: everything that a drag does can be done here, too.
import { element } from "../element.js";
import { Contents } from "./contents.js";
import { written } from "./drag.js";

export const bytes = (count) => {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  for (; count >= 1024 && unit < 4; unit++) count /= 1024;
  return unit ? `${count.toFixed(1)} ${units[unit]}` : `${count} B`;
};

const titled = (title, ...content) => [element("section", {}, element("h3", { textContent: title }), ...content)];
/** Short parts side by side. */
const facts = (...parts) => element("div", { className: "facts" }, ...parts);
const tag = (text, kind = "") => element("span", { className: `tag ${kind}`, textContent: text });
const button = (text, onclick, properties = {}) => element("button", { type: "button", textContent: text, onclick, ...properties });

/** The panel of one node, or of all. `graph` has `report`, `passes`, `pick`, `go`, `slots`, `attempt`, `make` and `shows`. */
export class Details {
  #graph;
  #number = 0;

  constructor(parent, graph) {
    this.parent = parent;
    this.#graph = graph;
  }

  /** Shows a node by its kind, `pass` or `resource`, and its name. */
  async show(kind, name) {
    const number = ++this.#number;
    const { report, passes } = this.#graph;
    const found = kind && report?.[kind === "pass" ? "passes" : "resources"].find((one) => one.name === name);
    const own = passes.find((one) => one.name === written(name ?? ""));
    if (kind === "pass" && (found || own)) {
      const slots = own ? await this.#graph.slots(own.name) : [];
      if (number !== this.#number) return;
      const is_drawn = found && own?.is_on !== false;
      this.parent.replaceChildren(...(is_drawn ? this.#pass(found, own, slots) : this.#absent(own, slots)));
      const colors = found?.attachments.filter(({ kind }) => kind.startsWith("color")).map(({ resource }) => resource) ?? [];
      if (is_drawn) this.#contents([...new Set([...colors, ...found.writes])], found.name);
    } else if (found && kind === "resource") {
      this.parent.replaceChildren(...this.#resource(found));
      this.#contents([found.name]);
    } else {
      this.parent.replaceChildren(...this.#overview());
    }
  }

  /** The contents of those of some resources that are textures and drawn. */
  #contents(names, after) {
    const { shows, report } = this.#graph;
    const found = names.map((name) => report.resources.find((one) => one.name === name));
    const textures = found.filter((one) => one?.kind === "texture" && one.live)
      .map(({ name, written_in }) => ({ name, writers: written_in.map((column) => report.passes[column].name) }));
    if (!shows.is_drawn() || !textures.length) return;
    const contents = new Contents(shows, textures, after);
    this.parent.append(contents.element);
    contents.show();
  }

  #links(kind, names) {
    if (!names.length) return [element("span", { className: "soft", textContent: "nothing" })];
    return [...new Set(names)].map((name) => button(name, () => this.#graph.pick_name(kind, name), { className: "link" }));
  }

  #head(name, tags, declared, own, is_renamed, tools = []) {
    const rename = element("input", { type: "text", value: own, spellcheck: false });
    rename.setAttribute("aria-label", `New name of ${own}`);
    const note = element("p", { className: "refused", hidden: true });
    const give = async () => {
      if (rename.value === own || !rename.value) return;
      const { refused } = await this.#graph.make({ change: "rename", from: own, to: rename.value }, { renamed: rename.value });
      note.hidden = !refused;
      note.textContent = refused ?? "";
    };
    rename.onkeydown = (event) => {
      if (event.key === "Enter") give();
      if (event.key === "Escape") rename.value = own;
    };
    const place = button(declared, () => this.#graph.go(declared), { className: "link", title: "Show it in the text" });
    const does = element("div", { className: "does" });
    if (is_renamed) does.append(element("label", { className: "rename" }, "Name ", rename), button("Rename", give));
    does.append(...tools);
    return [element("h2", { textContent: name }), element("p", {}, ...tags, place), does, note];
  }

  #tools(own) {
    const { make } = this.#graph;
    const switched = own.is_on
      ? button("Disable", () => make({ change: "switch", pass: own.name, on: false }), { title: "\"when\": false" })
      : button("Enable", () => make({ change: "switch", pass: own.name, on: true }));
    return [switched, button("Delete", () => make({ change: "remove", pass: own.name }))];
  }

  #pass(pass, own, slots) {
    const { report } = this.#graph;
    const memory = [...new Set([...pass.reads, ...pass.writes])].map((name) => report.resources.find((one) => one.name === name));
    const sum = memory.reduce((sum, one) => sum + (one?.bytes ?? 0), 0);
    const attachments = pass.attachments.map((one) =>
      element("li", { textContent: `${one.kind} ${one.resource}: ${one.load}, ${one.store}${one.transient_attachment ? ", never leaves the pass" : ""}` }));
    const settings = Object.entries(pass.settings ?? {}).flatMap(([key, value]) =>
      [element("dt", { textContent: key }), element("dd", { textContent: typeof value === "string" ? value : JSON.stringify(value) })]);
    return [
      ...this.#head(pass.name, [tag(pass.kind), tag(pass.live ? "kept" : "culled", pass.live ? "" : "off"), ...(pass.toggle ? [tag(`toggle ${pass.toggle}`)] : [])],
        pass.declared, own?.name ?? pass.name, Boolean(own), own ? this.#tools(own) : []),
      ...(own && own.name !== pass.name ? [element("p", { className: "soft", textContent: `A part of the pass “${own.name}” of the text, which all changes are made to.` })] : []),
      ...(own?.description ? [element("p", { textContent: own.description })] : []),
      facts(
        ...titled(pass.live ? "Why it is kept" : "Why it is culled", element("ol", {}, ...pass.why.map((step) => element("li", { textContent: step })))),
        ...titled("Reads", element("p", {}, ...this.#links("resource", pass.reads))),
        ...titled("Writes", element("p", {}, ...this.#links("resource", pass.writes))),
        ...titled("Memory", element("p", { textContent: `${bytes(sum)} in what it reads and writes` })),
        ...(attachments.length ? titled("Attachments", element("ul", {}, ...attachments)) : []),
        ...(pass.workgroups ? titled("Workgroups", element("p", { textContent: pass.workgroups.join(" × ") })) : []),
        ...(settings.length ? titled("Settings", element("dl", {}, ...settings)) : []),
        ...(pass.variants.length ? titled("Shader variants", element("ul", {}, ...pass.variants.map((one) => element("li", { textContent: one })))) : []),
      ),
      ...(own && slots.length ? titled("Connections", ...slots.map((slot) => this.#slot(own.name, slot))) : []),
    ];
  }

  /** A slot with the resources to choose from: what a drag does, by keys. */
  #slot(pass, { keys, label, value, refused }) {
    const { report, attempt, make } = this.#graph;
    const names = report.resources.map(({ name }) => `&${name}`);
    const choice = element("select", { disabled: Boolean(refused), title: refused ?? "" });
    choice.dataset.slot = keys.join("/");
    const all = [...new Set([...(value ? [value] : []), ...names])];
    choice.append(...(value ? [] : [element("option", { value: "", textContent: "nothing yet" })]),
      ...all.map((name) => element("option", { value: name, textContent: name, selected: name === value })));
    const note = element("small", { textContent: refused ?? "" });
    choice.onchange = async () => {
      const change = { change: "connect", pass, slot: keys, to: choice.value };
      const answer = await attempt(change);
      note.textContent = answer.refused ?? "";
      if (answer.refused && this.#graph.has_plan) choice.value = value ?? "";
      else make(change);
    };
    return element("label", { className: "slot" }, element("span", { textContent: label }), choice, note);
  }

  #resource(one) {
    const { report } = this.#graph;
    const names = (columns) => columns.map((column) => report.passes[column].name);
    const can_rename = !one.name.includes(".") && one.kind !== "data";
    return [
      ...this.#head(one.name, [tag(one.kind), tag(one.lifetime), tag(one.live ? "live" : "allocated nowhere", one.live ? "" : "off"),
        ...(one.shares_with.length ? [tag("aliased")] : [])], one.declared, one.name, can_rename,
        can_rename ? [button("Delete", () => this.#graph.make({ change: "forget", resource: one.name }))] : []),
      facts(...titled("Format and size", element("p", { textContent: one.description || one.kind })),
      ...titled("Memory", element("p", { textContent: `${bytes(one.bytes)} in ${one.place}` }),
        element("p", {}, "Shares memory with ", ...this.#links("resource", one.shares_with))),
      ...titled("Written by", element("p", {}, ...this.#links("pass", names(one.written_in)))),
      ...titled("Read by", element("p", {}, ...this.#links("pass", names(one.read_in)))),
      ...(one.frames > 1 ? titled("Kept", element("p", { textContent: `${one.frames} frames` })) : [])),
    ];
  }

  #absent(own, slots) {
    return [
      ...this.#head(own.name, [tag(own.kind), tag(own.is_on ? "not in the picture" : "not in this configuration", "off")], own.declared, own.name, true, this.#tools(own)),
      ...(own.description ? [element("p", { textContent: own.description })] : []),
      element("p", { className: "soft", textContent: own.is_on
        ? "There is no plan with it yet; the diagnostics say why."
        : "Its “when” is false with the chosen settings, so that it is no part of the plan." }),
      ...(slots.length ? titled("Connections", ...slots.map((slot) => this.#slot(own.name, slot))) : []),
    ];
  }

  #overview() {
    const { report } = this.#graph;
    if (!report) return [];
    const { memory } = report;
    const live = report.passes.filter((one) => one.live).length;
    const lines = [
      `${live} passes run, ${report.passes.length - live} are culled.`,
      `${bytes(memory.created)} are created; without aliasing it would be ${bytes(memory.without_aliasing)}.`,
    ];
    const does = [
      "Click a pass or a resource: what it is, and its line in the text.",
      "Drag a resource, or the dot of a write, onto a pass: it lists what can be connected.",
      "Drag a pass: its place in the text.",
      "Shift and click: several passes, to group.",
    ];
    const legend = [["cpu", "CPU"], ["draw", "draws"], ["compute", "computes"], ["copy", "copies"]].map(([kind, words]) =>
      element("span", { className: `key ${kind}`, textContent: words }));
    const marks = [["wrote", "writes"], ["reads", "reads"], ["culled", "culled"], ["aliased", "shares memory"]].map(([kind, words]) =>
      element("span", { className: `key ${kind}`, textContent: words }));
    return [element("h2", { textContent: "Overview" }), element("p", { className: "legend" }, ...legend, ...marks), ...lines.map((textContent) => element("p", { textContent })),
      element("ul", { className: "soft" }, ...does.map((textContent) => element("li", { textContent })))];
  }
}
