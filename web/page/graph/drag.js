// What one does to the graph with the pointer: move the picture, pick nodes, connect resources, move passes.
import { element } from "../element.js";

const SVG = "http://www.w3.org/2000/svg";
/** So far a pointer goes before it drags. */
const FAR = 5;

/** The pass of the text that a pass of the plan is, or is part of. */
export const written = (name) => name.split(".")[0];

/**
 * Listens to the pointer. `graph` has the `canvas`, the `report`, `pick(node, is_added)`, `slots(pass)`, `attempt(change)`
 * and `make(change)`.
 */
export class Drags {
  #graph;
  #line = null;
  #menu;
  #label;
  /** The number of the list of slots: one that is no longer wanted is not shown. */
  #number = 0;

  constructor(graph) {
    this.#graph = graph;
    this.#menu = element("div", { className: "slots", hidden: true });
    this.#label = element("div", { className: "carried", hidden: true });
    graph.canvas.element.append(this.#menu, this.#label);
    graph.canvas.element.addEventListener("pointerdown", (event) => this.#down(event));
  }

  #down(event) {
    if (event.button !== 0 || this.#menu.contains(event.target)) return;
    this.close();
    const { canvas, pick } = this.#graph;
    const node = canvas.node_at(event.clientX, event.clientY);
    const dot = event.target.closest?.("circle.write");
    let [x, y] = [event.clientX, event.clientY];
    let work = null;
    const move = (event) => {
      if (!work) {
        if (Math.hypot(event.clientX - x, event.clientY - y) < FAR) return;
        work = this.#work(node, dot, event);
      }
      work.move(event.clientX, event.clientY, event.clientX - x, event.clientY - y);
      [x, y] = [event.clientX, event.clientY];
    };
    const stop = () => {
      for (const [name, listener] of Object.entries(listeners)) window.removeEventListener(name, listener);
    };
    const up = (event) => {
      stop();
      if (work) work.drop?.(event.clientX, event.clientY);
      else pick(node, event.shiftKey || event.ctrlKey || event.metaKey);
    };
    const cancel = () => {
      stop();
      work?.cancel?.();
    };
    const listeners = {
      pointermove: move, pointerup: up, pointercancel: cancel,
      keydown: (event) => event.key === "Escape" && cancel(),
    };
    for (const [name, listener] of Object.entries(listeners)) window.addEventListener(name, listener);
    // The text beside is not selected meanwhile.
    event.preventDefault();
    (node ?? canvas.element).focus({ preventScroll: true });
  }

  #work(node, dot, event) {
    if (node?.dataset.resource) return this.#connects(this.#reference(node, dot), event);
    if (node?.dataset.pass) return this.#moves(node.dataset.pass, event);
    return { move: (x, y, dx, dy) => this.#graph.canvas.pan(dx, dy) };
  }

  /** What a resource is called where it is dragged from: at the dot of a write, as that left it. */
  #reference(node, dot) {
    const name = node.dataset.resource;
    const { resources, passes } = this.#graph.report;
    const resource = resources.find((one) => one.name === name);
    if (!dot || !resource) return `&${name}`;
    const [first, last] = resource.columns;
    const writers = resource.written_in.filter((column) => column >= first && column <= last);
    const at = [...node.querySelectorAll("circle.write")].indexOf(dot);
    return writers[at] === undefined ? `&${name}` : `&${name}@${passes[writers[at]].name}`;
  }

  #carry(text, x, y) {
    const area = this.#graph.canvas.element.getBoundingClientRect();
    this.#label.hidden = !text;
    this.#label.textContent = text ?? "";
    this.#label.style.transform = `translate(${x - area.left + 14}px, ${y - area.top + 14}px)`;
  }

  // ------------------------------------------------------------- connections

  #connects(reference, event) {
    const { canvas } = this.#graph;
    const from = canvas.point(event.clientX, event.clientY);
    this.#line = document.createElementNS(SVG, "path");
    this.#line.classList.add("dragged");
    canvas.svg.append(this.#line);
    canvas.element.classList.add("connecting");
    let over = null;
    let at = [event.clientX, event.clientY];
    const look = () => {
      const node = canvas.node_at(...at) ?? document.elementFromPoint(...at)?.closest?.("#graph .absent [data-pass]");
      const pass = node?.dataset.pass ? node : null;
      if (pass === over) return;
      over?.classList.remove("target");
      over = pass ?? over;
      over?.classList.toggle("target", Boolean(pass));
      if (pass) this.#open(pass, reference);
    };
    // Also while the pointer rests: the picture moves below it, or is drawn anew.
    const edge = setInterval(() => {
      this.#at_edge(...at);
      look();
    }, 30);
    const row_at = (x, y) => document.elementFromPoint(x, y)?.closest?.(".slots button") ?? null;
    const finish = () => {
      clearInterval(edge);
      this.#line.remove();
      this.#line = null;
      canvas.element.classList.remove("connecting");
      over?.classList.remove("target");
      this.#carry(null, 0, 0);
    };
    return {
      move: (x, y) => {
        at = [x, y];
        const is_in_list = Boolean(document.elementFromPoint(x, y)?.closest?.(".slots"));
        // The list has the name in its head.
        this.#carry(is_in_list ? null : reference, x, y);
        const [toX, toY] = canvas.point(x, y);
        this.#line.setAttribute("d", `M${from[0]} ${from[1]}C${from[0]} ${(from[1] + toY) / 2} ${toX} ${(from[1] + toY) / 2} ${toX} ${toY}`);
        if (is_in_list) return this.#mark(row_at(x, y));
        this.#mark(null);
        look();
      },
      drop: (x, y) => {
        const row = row_at(x, y);
        const is_on_pass = document.elementFromPoint(x, y)?.closest?.("#graph [data-pass]");
        finish();
        if (row) return row.click();
        // Dropped on the pass itself: its slots stay open for a click.
        if (!is_on_pass) this.close();
      },
      cancel: () => {
        finish();
        this.close();
      },
    };
  }

  /** Near an edge the picture moves on. */
  #at_edge(x, y) {
    const area = this.#graph.canvas.element.getBoundingClientRect();
    if (x < area.left || x > area.right || y < area.top || y > area.bottom) return;
    const push = (at, low, high) => (at < low + 28 ? 10 : at > high - 28 ? -10 : 0);
    const [dx, dy] = [push(x, area.left, area.right), push(y, area.top, area.bottom)];
    if ((dx || dy) && this.#menu.hidden) this.#graph.canvas.pan(dx, dy);
  }

  /** Takes the list of slots away. */
  close() {
    this.#number += 1;
    this.#menu.hidden = true;
    this.#menu.replaceChildren();
  }

  /** Lists the slots of a pass below it, each with what would become of it. */
  async #open(node, reference) {
    const { canvas, slots, attempt, make } = this.#graph;
    const pass = written(node.dataset.pass);
    const number = ++this.#number;
    const found = await slots(pass);
    if (number !== this.#number || !node.isConnected) return;
    const [box, area] = [node, canvas.element].map((one) => one.getBoundingClientRect());
    const rows = found.map(({ keys, label, value, refused }) => {
      const change = { change: "connect", pass, slot: keys, to: reference };
      const row = element("button", { type: "button" },
        element("b", { textContent: label }), element("span", { textContent: value ?? "nothing yet" }), element("small", {}));
      row.dataset.slot = keys.join("/");
      let tried = refused ? Promise.resolve({ refused }) : null;
      row.attempt = () => (tried ??= attempt(change));
      row.onclick = async () => {
        const { refused } = await row.attempt();
        if (refused && this.#graph.has_plan) return this.#say(row, refused);
        this.close();
        make(change);
      };
      row.onpointerenter = row.onfocus = () => this.#mark(row);
      return row;
    });
    const none = element("p", { textContent: "Nothing can be connected to this pass." });
    this.#menu.replaceChildren(element("h3", { textContent: `${reference} to ${pass}` }), ...(rows.length ? rows : [none]));
    this.#menu.hidden = false;
    const { offsetWidth } = this.#menu;
    // With room for a reason.
    const height = Math.min(this.#menu.offsetHeight + 130, 0.75 * area.height);
    const x = Math.max(8, Math.min(area.width - offsetWidth - 8, box.left - area.left + box.width / 2 - offsetWidth / 2));
    const below = box.bottom - area.top;
    const y = below + height < area.height ? below : Math.max(8, area.height - height - 8);
    this.#menu.style.transform = `translate(${x}px, ${y}px)`;
    this.#menu.onkeydown = (event) => event.key === "Escape" && this.close();
  }

  #say(row, refused) {
    row.classList.toggle("refused", Boolean(refused));
    row.classList.toggle("fine", !refused);
    row.lastChild.textContent = refused ?? "fits";
  }

  async #mark(row) {
    for (const other of this.#menu.querySelectorAll("button")) other.classList.toggle("marked", other === row);
    if (!row) return;
    const { refused } = await row.attempt();
    this.#say(row, refused ?? null);
  }

  // ------------------------------------------------------------- order

  #moves(name, event) {
    const { canvas, make, report } = this.#graph;
    const pass = written(name);
    const boxes = [...canvas.svg.querySelectorAll("g.pass")];
    const body = (box) => box.querySelector("rect.body");
    const marker = document.createElementNS(SVG, "path");
    marker.classList.add("dragged");
    canvas.svg.append(marker);
    const number = (box, name) => Number(body(box).getAttribute(name));
    let before;
    const finish = () => {
      marker.remove();
      this.#carry(null, 0, 0);
    };
    return {
      move: (x, y) => {
        const [at] = canvas.point(x, y);
        const behind = boxes.filter((box) => written(box.dataset.pass) !== pass);
        const next = behind.find((box) => number(box, "x") + number(box, "width") / 2 > at);
        before = next ? written(next.dataset.pass) : null;
        const last = behind.at(-1);
        if (last) {
          const line = next ? number(next, "x") - 8 : number(last, "x") + number(last, "width") + 8;
          const top = number(last, "y");
          marker.setAttribute("d", `M${line} ${top - 6}v${number(last, "height") + 12}`);
        }
        this.#carry(before ? `${pass}: before ${before} in the text` : `${pass}: last in the text`, x, y);
      },
      drop: (x, y) => {
        finish();
        const area = canvas.element.getBoundingClientRect();
        const is_inside = x > area.left && x < area.right && y > area.top && y < area.bottom;
        if (is_inside && before !== undefined && report.passes.length > 1) make({ change: "move", pass, before });
      },
      cancel: finish,
    };
  }
}
