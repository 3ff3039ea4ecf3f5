// The graph of a pipeline as an editor: another view of the same text. Every change is made by the library as edits of the
// text, which the page's editor makes as one step of undo; then the graph is drawn anew.
import { element } from "../element.js";
import { Details } from "./details.js";
import { Drags, written } from "./drag.js";
import { Palette } from "./palette.js";
import { Canvas } from "./svg.js";

/**
 * The view in an element of the page. `page` has `ask(kind, asked)`, which asks the checker about the pipeline;
 * `edit(edits)`, `undo()` and `redo()` of the editor; `go(declared, is_focused)`, which shows a place `FILE:LINE`; and
 * `shows`, which tells contents of textures.
 */
export class Graph {
  #page;
  #details;
  #palette;
  #drags;
  #kinds = null;
  #known = "";
  #slots = new Map();
  #picked = { kind: null, name: null };
  #several = new Set();
  #parts = {};
  #element;
  report = null;
  /** Whether the text has a plan: without one, what is refused for its first error can be a step of mending it. */
  has_plan = true;
  passes = [];

  constructor(parent, page) {
    this.#page = page;
    this.#element = parent;
    const button = (name, textContent, label, onclick) => {
      const made = element("button", { type: "button", textContent, title: label, onclick });
      // A sign is no name.
      if (textContent.length === 1) made.setAttribute("aria-label", label);
      this.#parts[name] = made;
      return made;
    };
    const area = element("div", { className: "canvas", tabIndex: 0 });
    area.setAttribute("role", "group");
    area.setAttribute("aria-label", "The graph. Arrow keys move it, plus and minus zoom. Tab goes to its passes and resources; there arrow keys go on, and Enter shows one.");
    const absent = element("div", { className: "absent" });
    const panel = element("section", { className: "details" });
    panel.setAttribute("aria-label", "The chosen node");
    panel.setAttribute("aria-live", "polite");
    const said = element("p", { className: "said", role: "status", hidden: true });
    const bar = element("div", { className: "tools" },
      button("add", "Add pass…", "Add a pass of a node kind, or a file that is a subgraph", () => this.#open_palette()),
      button("declare", "Add resource", "Add a texture or buffer: like the chosen one, or as large as the frame", () => this.#declare()),
      button("group", "Group…", "Group the chosen passes as a subgraph", () => this.#open_group()),
      element("span", { className: "space" }),
      button("undo", "Undo", "Undo the last change of the text", () => page.undo()),
      button("redo", "Redo", "Make it again", () => page.redo()),
      button("smaller", "−", "Smaller", () => this.canvas.zoom(0.8)),
      button("larger", "+", "Larger", () => this.canvas.zoom(1.25)),
      button("fit", "Fit", "Show it from the start", () => this.canvas.fit()));
    parent.append(bar, said, area, absent, panel);
    this.#parts = { ...this.#parts, absent, said };
    this.canvas = new Canvas(area);
    this.#details = new Details(panel, this);
    this.#palette = new Palette(parent, (kind) => this.#add(kind));
    this.#drags = new Drags(this);
    area.addEventListener("keydown", (event) => this.#key(event));
    this.#mark();
  }

  /** Shows a plan: its report, and what the checker said of its graph. A text without a plan has no picture of it. */
  show(name, report, { svg, written: passes }) {
    const key = JSON.stringify([svg, passes]);
    const is_other = this.#element.dataset.shows !== name;
    if (key === this.#known && !is_other) return;
    if (is_other) {
      this.#drags.close();
      this.canvas.forget();
      this.#several.clear();
      this.#picked = { kind: null, name: null };
    }
    this.#known = key;
    this.#element.dataset.shows = name;
    this.#slots.clear();
    this.passes = passes;
    this.has_plan = Boolean(svg);
    this.#say(svg ? null : "The text has no plan. The graph is that of the last text that had one.");
    if (svg) this.#draw(svg, report);
    this.#show_absent();
    const known = new Set([...this.report.passes, ...this.report.resources, ...passes].map((one) => one.name));
    if (this.#picked.name && !known.has(this.#picked.name)) this.#picked = { kind: null, name: null };
    for (const pass of this.#several) if (!passes.some((one) => one.name === pass)) this.#several.delete(pass);
    this.#mark();
    this.#details.show(this.#picked.kind, this.#picked.name);
  }

  /** Lists the passes of the text that the picture does not have; resources can be dropped on them, too. */
  #show_absent() {
    const drawn = new Set(this.report.passes.map((one) => written(one.name)));
    const absent = this.passes.filter((pass) => !pass.is_on || !drawn.has(pass.name));
    const is_off = absent.every((pass) => !pass.is_on);
    this.#parts.absent.hidden = !absent.length;
    this.#parts.absent.replaceChildren(element("span", { textContent: is_off ? "Not in this configuration" : "Not in the picture" }),
      ...absent.map(({ name }) => {
        const chip = element("button", { type: "button", textContent: name, onclick: () => this.pick_name("pass", name) });
        chip.dataset.pass = name;
        return chip;
      }));
  }

  #draw(svg, report) {
    this.report = report;
    const focused = this.canvas.svg?.contains(document.activeElement) ? { ...document.activeElement.dataset } : null;
    this.canvas.show(svg);
    this.#label();
    if (focused) this.#node(focused.pass ? "pass" : "resource", focused.pass ?? focused.resource)?.focus({ preventScroll: true });
  }

  /** What a screen reader says of the nodes, and which of them Tab goes to. */
  #label() {
    for (const node of this.canvas.svg.querySelectorAll("[data-pass], [data-resource]")) {
      node.setAttribute("role", "button");
      const title = node.querySelector("title");
      const texts = [...node.querySelectorAll("text")];
      const seen = texts.map((text) => text.textContent).join(" ");
      // Words of their own, for who compares the name with them.
      texts.forEach((text) => text.after(" "));
      node.setAttribute("aria-label", `${seen}: ${title?.textContent.replaceAll("\n", ", ") ?? ""}`);
      // What stands in the node itself would be a second name.
      if (title) node.querySelector(".body, .bar").append(title);
      const found = node.dataset.resource && this.report.resources.find((one) => one.name === node.dataset.resource);
      if (found?.shares_with.length) node.classList.add("aliased");
    }
  }

  /** What contents of textures are asked of. */
  get shows() {
    return this.#page.shows;
  }

  #node(kind, name) {
    return this.canvas.svg?.querySelector(`[data-${kind}="${CSS.escape(name ?? "")}"]`) ?? null;
  }

  // ------------------------------------------------------------- choice

  pick = (node, is_added) => {
    if (!node) return this.pick_name(null, null);
    const kind = node.dataset.pass ? "pass" : "resource";
    const name = node.dataset[kind];
    if (is_added && kind === "pass") {
      const own = written(name);
      if (!this.#several.size && this.#picked.kind === "pass") this.#several.add(written(this.#picked.name));
      if (!this.#several.delete(own)) this.#several.add(own);
      return this.#mark();
    }
    this.#several.clear();
    this.pick_name(kind, name);
  };

  pick_name(kind, name, is_shown = true) {
    this.#picked = { kind, name };
    this.#mark();
    this.#details.show(kind, name);
    const node = this.#node(kind ?? "pass", name);
    if (node) this.canvas.reveal(node);
    const found = [...(this.report?.passes ?? []), ...(this.report?.resources ?? []), ...this.passes].find((one) => one.name === name);
    if (found && is_shown) this.go(found.declared, false);
  }

  go = (declared, is_focused = true) => this.#page.go(declared, is_focused);

  /** Marks what is chosen, and what it has to do with. */
  #mark() {
    this.#parts.group.disabled = !this.#chosen().length;
    const svg = this.canvas.svg;
    if (!svg || !this.report) return;
    const { kind, name } = this.#picked;
    const found = kind && this.report?.[kind === "pass" ? "passes" : "resources"].find((one) => one.name === name);
    const near = new Set(found ? [name] : []);
    for (const one of found?.reads ?? []) near.add(one);
    for (const one of found?.writes ?? []) near.add(one);
    for (const column of [...(found?.read_in ?? []), ...(found?.written_in ?? [])]) near.add(this.report.passes[column].name);
    svg.classList.toggle("dim", near.size > 0);
    let first = null;
    for (const node of svg.querySelectorAll("[data-pass], [data-resource], .edge[data-from]")) {
      const own = node.dataset.pass ?? node.dataset.resource;
      node.classList.toggle("near", own ? near.has(own) : near.has(node.dataset.from) && near.has(node.dataset.to));
      if (!own) continue;
      const is_picked = own === name && Boolean(node.dataset[kind]);
      const is_several = node.dataset.pass !== undefined && this.#several.has(written(own));
      node.classList.toggle("picked", is_picked || is_several);
      node.setAttribute("aria-pressed", String(is_picked || is_several));
      node.tabIndex = -1;
      first ??= node;
      if (is_picked) first = node;
    }
    if (first) first.tabIndex = 0;
  }

  /** The arrow keys go from pass to pass and to resources, Enter picks. */
  #key(event) {
    const { svg } = this.canvas;
    const node = event.target.closest?.("[data-pass], [data-resource]");
    const is_mine = event.ctrlKey || event.metaKey;
    if (is_mine && event.key.toLowerCase() === "z") {
      event.preventDefault();
      return event.shiftKey ? this.#page.redo() : this.#page.undo();
    }
    if (!node || is_mine) return;
    const kind = node.dataset.pass ? "pass" : "resource";
    const all = [...svg.querySelectorAll(`[data-${kind}]`)];
    const others = () => {
      const name = node.dataset[kind];
      const pass = this.report.passes.find((one) => one.name === name);
      if (kind === "pass") return [...(pass?.writes ?? []), ...(pass?.reads ?? [])].map((name) => this.#node("resource", name));
      const resource = this.report.resources.find((one) => one.name === name);
      return [...(resource?.written_in ?? []), ...(resource?.read_in ?? [])].map((column) => this.#node("pass", this.report.passes[column].name));
    };
    const to = {
      ArrowRight: () => all[all.indexOf(node) + 1], ArrowLeft: () => all[all.indexOf(node) - 1],
      ArrowDown: () => (kind === "pass" ? others()[0] : all[all.indexOf(node) + 1]),
      ArrowUp: () => (kind === "resource" ? others()[0] : null),
      Enter: () => (this.pick(node, event.shiftKey), null), " ": () => (this.pick(node, event.shiftKey), null),
      Escape: () => (this.pick(null), null),
      Delete: () => (kind === "pass" && this.make({ change: "remove", pass: written(node.dataset.pass) }), null),
    }[event.key];
    if (!to) return;
    event.preventDefault();
    event.stopPropagation();
    const next = to();
    if (!next) return;
    next.focus({ preventScroll: true });
    this.canvas.reveal(next);
  }

  // ------------------------------------------------------------- changes

  /** The slots of a pass of the text. */
  slots = (pass) => {
    if (!this.#slots.has(pass)) this.#slots.set(pass, this.#page.ask("slots", { pass }).catch(() => []));
    return this.#slots.get(pass);
  };

  /** What a change would bring: edits, or why it is refused. */
  attempt = (change) => this.#page.ask("change", { change, is_tried: true }).catch((error) => ({ refused: error.message }));

  /** Makes a change, and says what became of it. */
  make = async (change, { renamed } = {}) => {
    const answer = await this.#page.ask("change", { change, is_tried: false }).catch((error) => ({ refused: error.message }));
    this.#say(answer.refused);
    if (answer.refused) return answer;
    if (renamed) {
      const { kind, name } = this.#picked;
      this.#picked = { kind, name: name === change.from ? renamed : name.replace(`${change.from}.`, `${renamed}.`) };
    }
    this.#page.edit(answer.edits);
    return answer;
  };

  #say(text) {
    this.#parts.said.hidden = !text;
    this.#parts.said.textContent = text ?? "";
  }

  async #open_palette() {
    this.#kinds = await this.#page.ask("palette");
    this.#palette.open(this.#kinds);
  }

  async #add(kind) {
    const after = this.#picked.kind === "pass" ? written(this.#picked.name) : undefined;
    const before = new Set(this.passes.map((one) => one.name));
    const answer = await this.make({ change: "add", kind, after });
    if (answer.refused) return;
    const { written: passes } = await this.#page.ask("graph");
    const added = passes.find((one) => !before.has(one.name));
    this.passes = passes;
    this.#slots.clear();
    if (!added) return;
    this.#show_absent();
    this.pick_name("pass", added.name);
  }

  /** Adds a resource; its bar is in the picture once a pass uses it, so its line in the text is shown. */
  async #declare() {
    const like = this.#picked.kind === "resource" ? this.#picked.name : undefined;
    await this.make({ change: "declare", like });
  }

  #chosen() {
    if (this.#several.size) return [...this.#several];
    return this.#picked.kind === "pass" ? [written(this.#picked.name)] : [];
  }

  #open_group() {
    const passes = this.#chosen();
    const name = element("input", { type: "text", value: "group", spellcheck: false });
    const note = element("p", { className: "refused", hidden: true });
    const dialog = element("dialog", { className: "palette" });
    const make = async () => {
      const answer = await this.make({ change: "group", passes, name: name.value });
      note.hidden = !answer.refused;
      note.textContent = answer.refused ?? "";
      if (!answer.refused) dialog.close();
    };
    const button = (textContent, onclick) => element("button", { type: "button", textContent, onclick });
    dialog.append(element("h2", { textContent: "Group as a subgraph" }),
      element("p", { className: "soft", textContent: `${passes.join(", ")}: a subgraph of the pipeline holds them, with what they use as inputs.` }),
      element("label", { className: "rename" }, "Name ", name), note, element("div", { className: "does" }, button("Group", make), button("Close", () => dialog.close())));
    name.onkeydown = (event) => event.key === "Enter" && make();
    dialog.onclose = () => dialog.remove();
    this.canvas.element.parentElement.append(dialog);
    dialog.showModal();
    name.select();
  }
}
