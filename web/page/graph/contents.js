// The contents of textures: as a pass leaves them, or at the end of the frame, with the numbers under the pointer.
import { element } from "../element.js";

/** A short number. */
const short = (number) => (Number.isInteger(number) ? String(number) : Number(number.toPrecision(4)).toString());

/**
 * The contents of one of several textures, each with its `name` and the names of its `writers`, in their order. `page` has
 * `contents(reference, mip)`, a promise, and `texel(x, y)`, another, of the contents that were asked for last.
 */
export class Contents {
  #page;
  #number = 0;
  #is_asking = false;
  #picture = element("canvas", { hidden: true });
  #said = element("p", { className: "soft", role: "status" });
  #under = element("output", {});
  #mip = element("select", { hidden: true });
  #version;

  /** First the first texture as the pass `after` leaves it. */
  constructor(page, textures, after) {
    this.#page = page;
    const option = (value, textContent) => element("option", { value, textContent });
    this.#version = element("select", {}, ...textures.map(({ name, writers }) =>
      element("optgroup", { label: name }, ...writers.map((pass) => option(`${name}@${pass}`, `${name} after ${pass}`)), option(name, `${name} at the end of the frame`))));
    const [{ name, writers }] = textures;
    this.#version.value = writers.includes(after) ? `${name}@${after}` : name;
    this.#version.setAttribute("aria-label", "Texture, and time in the frame");
    this.#mip.setAttribute("aria-label", "Mip level");
    this.#version.onchange = () => {
      this.#mip.replaceChildren();
      this.show();
    };
    this.#mip.onchange = () => this.show();
    this.#picture.setAttribute("role", "img");
    this.#picture.onpointermove = (event) => this.#point(event);
    this.element = element("section", { className: "contents" }, element("h3", { textContent: "Contents" }),
      element("div", { className: "does" }, this.#version, this.#mip, this.#under), this.#said, this.#picture);
  }

  /** Draws a frame, and shows what it left. */
  async show() {
    const number = ++this.#number;
    this.#said.textContent = "A frame is drawn…";
    this.#under.textContent = "";
    try {
      const found = await this.#page.contents(this.#version.value, Number(this.#mip.value || 0));
      if (number === this.#number) this.#draw(found);
    } catch (error) {
      if (number !== this.#number) return;
      this.#picture.hidden = true;
      this.#said.textContent = error.message;
    }
  }

  #draw({ width, height, mips, ranges, rgba }) {
    [this.#picture.width, this.#picture.height] = [width, height];
    this.#picture.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(rgba.buffer), width, height), 0, 0);
    this.#picture.hidden = false;
    this.#picture.dataset.shows = this.#version.value;
    this.#picture.setAttribute("aria-label", `Contents of ${this.#version.selectedOptions[0].textContent}`);
    const spans = Array.from({ length: ranges.length / 2 }, (_, at) => `${short(ranges[2 * at])} to ${short(ranges[2 * at + 1])}`);
    const shown = spans.length ? `black to white is ${[...new Set(spans)].join(", ")}` : "shown as it is";
    this.#said.textContent = `${width} × ${height}: ${shown}`;
    if (this.#mip.options.length !== mips) {
      this.#mip.replaceChildren(...Array.from({ length: mips }, (_, mip) => element("option", { value: String(mip), textContent: `mip ${mip}` })));
    }
    this.#mip.hidden = mips < 2;
  }

  /** Tells the texel under the pointer; one question at a time, since frames are drawn between answers. */
  async #point({ offsetX, offsetY }) {
    if (this.#is_asking) return;
    this.#is_asking = true;
    const { clientWidth, clientHeight, width, height } = this.#picture;
    const [x, y] = [Math.floor((offsetX / clientWidth) * width), Math.floor((offsetY / clientHeight) * height)];
    const texel = await this.#page.texel(x, y).catch(() => []);
    this.#is_asking = false;
    this.#under.textContent = texel.length ? `${x}, ${y}: ${texel.map(short).join("  ")}` : "";
  }
}
