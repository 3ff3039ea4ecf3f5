// The contents of a texture: as a pass leaves it, or at the end of the frame, with the numbers under the pointer.
import { element } from "../element.js";

/** A short number. */
const short = (number) => (Number.isInteger(number) ? String(number) : Number(number.toPrecision(4)).toString());

/** The contents of one texture. `page` has `contents(reference, mip)`, a promise, and `texel(x, y)`, another. */
export class Contents {
  #page;
  #number = 0;
  #picture = element("canvas", { hidden: true });
  #said = element("p", { className: "soft", role: "status" });
  #under = element("output", {});
  #mip = element("select", { hidden: true });
  #version;

  /** Of a texture with the passes that write it, in their order; first as the pass of that name leaves it. */
  constructor(page, name, writers, after) {
    this.#page = page;
    const option = (value, textContent) => element("option", { value, textContent, selected: value === `${name}@${after}` });
    this.#version = element("select", {}, option(name, "at the end of the frame"), ...writers.map((pass) => option(`${name}@${pass}`, `after ${pass}`)));
    this.#version.setAttribute("aria-label", `Time in the frame at which ${name} is shown`);
    this.#mip.setAttribute("aria-label", "Mip level");
    this.#version.onchange = this.#mip.onchange = () => this.show();
    this.#picture.setAttribute("role", "img");
    this.#picture.setAttribute("aria-label", `Contents of ${name}`);
    this.#picture.onpointermove = (event) => this.#point(event);
    this.element = element("section", { className: "contents" }, element("h3", { textContent: `Contents of ${name}` }),
      element("div", { className: "does" }, this.#version, this.#mip, this.#under), this.#said, this.#picture);
  }

  /** Draws a frame, and shows what it left. */
  async show() {
    const number = ++this.#number;
    this.#said.textContent = "A frame is drawn…";
    try {
      const found = await this.#page.contents(this.#version.value, Number(this.#mip.value || 0));
      if (number !== this.#number) return;
      this.#draw(found);
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
    const spans = Array.from({ length: ranges.length / 2 }, (_, at) => `${short(ranges[2 * at])} to ${short(ranges[2 * at + 1])}`);
    const shown = spans.length ? `black to white is ${[...new Set(spans)].join(", ")}` : "shown as it is";
    this.#said.textContent = `${width} × ${height}: ${shown}`;
    if (this.#mip.options.length !== mips) {
      this.#mip.replaceChildren(...Array.from({ length: mips }, (_, mip) => element("option", { value: String(mip), textContent: `mip ${mip}` })));
    }
    this.#mip.hidden = mips < 2;
  }

  async #point({ offsetX, offsetY }) {
    const { clientWidth, clientHeight, width, height } = this.#picture;
    const [x, y] = [Math.floor((offsetX / clientWidth) * width), Math.floor((offsetY / clientHeight) * height)];
    const texel = await this.#page.texel(x, y).catch(() => []);
    this.#under.textContent = texel.length ? `${x}, ${y}: ${texel.map(short).join("  ")}` : "";
  }
}
