// The list of what can be added to a pipeline: node kinds, and files that are subgraphs.
import { element } from "../element.js";

const short = (path) => path.replace(/^pipelines\//, "");

/** A dialog that asks for one of them; `add` is told which. */
export class Palette {
  #dialog;
  #list = element("ul", { role: "list" });
  #search = element("input", { type: "search", placeholder: "Find a kind or a file" });

  constructor(parent, add) {
    this.#search.setAttribute("aria-label", "Find a kind or a file");
    const close = element("button", { type: "button", textContent: "Close", onclick: () => this.#dialog.close() });
    this.#dialog = element("dialog", { className: "palette" },
      element("div", { className: "does" }, element("h2", { textContent: "Add a pass" }), close), this.#search, this.#list);
    this.#dialog.setAttribute("aria-label", "Add a pass");
    parent.append(this.#dialog);
    this.#search.oninput = () => this.#filter();
    this.#list.onclick = (event) => {
      const chosen = event.target.closest("button")?.dataset.kind;
      if (!chosen) return;
      this.#dialog.close();
      add(chosen);
    };
    this.#dialog.onclick = (event) => event.target === this.#dialog && this.#dialog.close();
  }

  open({ kinds, files }) {
    const entry = ({ kind, description }) => element("li", {},
      Object.assign(element("button", { type: "button" }, element("b", { textContent: short(kind) }), element("span", { textContent: description ?? "" })), {}));
    const rows = [...kinds, ...files].map((one) => {
      const row = entry(one);
      row.firstChild.dataset.kind = one.kind;
      row.dataset.find = `${one.kind} ${one.description ?? ""}`.toLowerCase();
      return row;
    });
    const title = (textContent) => element("li", { className: "title", textContent });
    this.#list.replaceChildren(title("Node kinds"), ...rows.slice(0, kinds.length), title("Files"), ...rows.slice(kinds.length));
    this.#search.value = "";
    this.#dialog.showModal();
    this.#search.focus();
  }

  #filter() {
    const wanted = this.#search.value.trim().toLowerCase();
    for (const row of this.#list.querySelectorAll("[data-find]")) row.hidden = !row.dataset.find.includes(wanted);
  }
}
