// The picture of a plan, which the library draws: shown, moved with pointer, wheel and keys, and its nodes found.

/** So much larger or smaller a picture becomes with one key. */
const STEP = 1.25;
const SCALES = [0.15, 3];
/** The height of the title and the legend. */
const HEAD = 92;

/** The area that shows the picture. */
export class Canvas {
  #svg = null;
  #at = { x: 0, y: 0, scale: 1 };
  #size = [1, 1];
  /** The names on bars: each text, and from where to where it can stand. */
  #names = [];
  #is_placed = false;

  constructor(element) {
    this.element = element;
    element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    element.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#apply()).observe(element);
  }

  get svg() {
    return this.#svg;
  }

  /** Shows a picture where the one before was. */
  show(text) {
    const svg = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    // The page has colours for light and dark.
    svg.querySelector("style")?.remove();
    svg.querySelector("rect")?.classList.add("paper");
    this.#size = ["width", "height"].map((name) => Number(svg.getAttribute(name)));
    for (const name of ["width", "height", "role", "aria-label"]) svg.removeAttribute(name);
    this.#svg?.remove();
    this.#svg = document.importNode(svg, true);
    this.element.prepend(this.#svg);
    this.#names = [...this.#svg.querySelectorAll("[data-resource]")].map((node) => {
      const [bar, text] = [node.querySelector(".bar"), node.querySelector(".name")];
      const [x, width] = ["x", "width"].map((name) => Number(bar.getAttribute(name)));
      return { text, from: x + 9, to: x + width - 9 - 7 * text.textContent.length };
    });
    if (this.#is_placed) this.#apply();
    else this.fit();
  }

  /** Forgets where the picture was, as for another pipeline. */
  forget() {
    this.#is_placed = false;
  }

  /** As much of the picture as is readable, from its first pass on. */
  fit() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !this.#svg) return;
    this.#is_placed = true;
    const top = Number(this.#svg.querySelector(".pass rect.body")?.getAttribute("y") ?? 0);
    // Arcs stand above the passes, and above these a head whose words the page has, too.
    const y = Math.max(0, Math.min(top - 20, HEAD));
    const scale = Math.min(width / this.#size[0], height / (this.#size[1] - y));
    this.#at = { x: 0, y, scale: Math.max(0.9, Math.min(1.1, scale)) };
    this.#apply();
  }

  zoom(factor, [x, y] = [this.element.clientWidth / 2, this.element.clientHeight / 2]) {
    const { scale } = this.#at;
    const next = Math.max(SCALES[0], Math.min(SCALES[1], scale * factor));
    this.#at = { x: this.#at.x + x / scale - x / next, y: this.#at.y + y / scale - y / next, scale: next };
    this.#apply();
  }

  /** Moves the picture by so many pixels. */
  pan(x, y) {
    this.#at.x -= x / this.#at.scale;
    this.#at.y -= y / this.#at.scale;
    this.#apply();
  }

  /** A place of the picture, from one of the window. */
  point(x, y) {
    const { left, top } = this.element.getBoundingClientRect();
    return [this.#at.x + (x - left) / this.#at.scale, this.#at.y + (y - top) / this.#at.scale];
  }

  /** Brings a node into view. */
  reveal(node) {
    const [box, area] = [node, this.element].map((one) => one.getBoundingClientRect());
    const way = (from, to, low, high) => (from < low ? low - from + 24 : to > high ? Math.max(high - to - 24, low - from + 24) : 0);
    this.pan(way(box.left, box.right, area.left, area.right), way(box.top, box.bottom, area.top, area.bottom));
  }

  /** The node at a place of the window, and which it is. */
  node_at(x, y) {
    const node = document.elementFromPoint(x, y)?.closest?.("[data-pass], [data-resource]");
    return node && this.#svg?.contains(node) ? node : null;
  }

  #apply() {
    const { clientWidth, clientHeight } = this.element;
    if (!this.#svg || !clientWidth) return;
    if (!this.#is_placed) return this.fit();
    const at = this.#at;
    // Some of the picture stays in view.
    at.x = Math.max(-clientWidth / at.scale + 120, Math.min(this.#size[0] - 120, at.x));
    at.y = Math.max(-clientHeight / at.scale + 60, Math.min(this.#size[1] - 60, at.y));
    // The name of a bar stays in view while its start is not.
    for (const { text, from, to } of this.#names) text.setAttribute("x", Math.max(from, Math.min(at.x + 8, to)));
    this.#svg.setAttribute("viewBox", [at.x, at.y, clientWidth / at.scale, clientHeight / at.scale].join(" "));
  }

  #wheel(event) {
    event.preventDefault();
    const { left, top } = this.element.getBoundingClientRect();
    if (event.ctrlKey || event.metaKey) return this.zoom(Math.exp(-event.deltaY / 300), [event.clientX - left, event.clientY - top]);
    if (event.shiftKey) this.pan(-event.deltaY, 0);
    else this.pan(-event.deltaX, -event.deltaY);
  }

  #key(event) {
    if (event.target !== this.element || event.ctrlKey || event.metaKey) return;
    const keys = {
      ArrowLeft: () => this.pan(60, 0), ArrowRight: () => this.pan(-60, 0), ArrowUp: () => this.pan(0, 60), ArrowDown: () => this.pan(0, -60),
      "+": () => this.zoom(STEP), "-": () => this.zoom(1 / STEP), 0: () => this.fit(),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  }
}
