// The frame: a worker that draws on a canvas of the page, and what the page asks of it.
//
// A canvas that was lent once cannot be lent again, so each start makes another. A device that is lost is replaced once, by
// one whose pictures are read back: some browsers draw, and lose the device when they are to show it.
import { element } from "./element.js";
import { Answerer } from "./worker.js";

/** A worker that draws for less than this, in milliseconds, is not started again when it dies. */
const AGAIN_AFTER = 5000;

const $ = (id) => document.getElementById(id);

/** Words over the frame, or none. */
export const cover = (text) => {
  $("cover").hidden = !text;
  $("cover").textContent = text ?? "";
  // Diagnostics show lines of a text.
  $("cover").classList.toggle("report", Boolean(text?.includes("-->")));
};

export class Frame {
  #size;
  #state;
  #painter = null;
  #is_opened = false;
  #begun = 0;
  #view = [0, 0, 1];
  #is_drawing = false;
  #is_due = false;

  /** `state` says what there is to draw: `files()`, `scene()` with `scene_bytes()` of one's own, and `asked()`, nothing without a plan. */
  constructor(size, state) {
    [this.#size, this.#state] = [size, state];
  }

  get is_started() {
    return this.#painter !== null;
  }

  async start(is_plain = false) {
    this.#is_opened = false;
    this.#painter?.stop("it is replaced");
    $("stage").querySelector("canvas")?.remove();
    const canvas = element("canvas", { width: this.#size[0], height: this.#size[1] });
    $("stage").append(canvas);
    this.#painter = new Answerer("painter.js", {
      died: (reason) => this.#died(reason),
      events: ({ frame, failed, lost }) => {
        if (lost !== undefined && !is_plain) return void this.start(true).catch((error) => cover(error.message));
        if (lost !== undefined) return cover(`The device is lost: ${lost}\nReload the page to get another.`);
        if (failed) return cover(failed);
        cover("");
        $("time").textContent = `${frame.recorded.toFixed(1)} ms to record, ${frame.total.toFixed(0)} ms to the end of the frame`;
        if (frame.is_planned) {
          performance.clearMarks("planned frame");
          performance.mark("planned frame", { detail: frame });
        }
        document.documentElement.dataset.frames = Number(document.documentElement.dataset.frames ?? 0) + 1;
      },
    });
    const lent = canvas.transferControlToOffscreen();
    await this.#painter.ask("open", { canvas: lent, is_plain }, [lent]);
    await this.#painter.ask("write", { files: this.#state.files() });
    this.#is_opened = true;
    this.#begun = performance.now();
    await this.take_scene();
  }

  /** Starts a worker that died again, unless it did so at once. */
  #died(reason) {
    if (!this.#is_opened) return;
    cover(`Drawing stopped: ${reason}\nReload the page to start it again.`);
    if (performance.now() - this.#begun > AGAIN_AFTER) this.start().catch((error) => cover(error.message));
  }

  /** Takes a scene: one of the page's, or bytes that were dropped on it. */
  async take_scene(bytes, name = this.#state.scene()) {
    if (!this.#is_opened) return;
    const taken = bytes ?? this.#state.scene_bytes(name) ?? (await (await fetch(`scenes/${name}.glb`)).arrayBuffer());
    try {
      await this.#painter.ask("scene", { name, bytes: taken }, [taken]);
      await this.draw();
    } catch (error) {
      cover(error.message);
    }
  }

  /** Gives the painter what is written; what is written meanwhile is given next. */
  async draw() {
    const asked = this.#state.asked();
    if (!this.#is_opened || !asked) return;
    if (this.#is_drawing) {
      this.#is_due = true;
      return;
    }
    this.#is_drawing = true;
    const answer = await this.#painter.ask("pipeline", { ...asked, size: this.#size }).catch(() => null);
    const errors = answer?.diagnostics.filter((one) => one.severity === "error") ?? [];
    if (errors.length) cover(answer.text);
    this.#is_drawing = false;
    if (!this.#is_due) return;
    this.#is_due = false;
    this.draw();
  }

  write(files) {
    this.#painter?.ask("write", { files }).catch(() => {});
  }

  /** Sets a live parameter; a value that it does not take is an error. */
  async set(name, value) {
    const painter = this.#painter;
    try {
      await painter?.ask("set", { name, value });
    } catch (error) {
      // One that replaces it begins with all values.
      if (painter === this.#painter) throw error;
    }
  }

  play(on) {
    this.#painter?.ask("play", { on }).catch(() => {});
  }

  look(side, up, distance) {
    const [sideways, upwards, away] = this.#view;
    this.#view = [sideways + side, Math.max(-1.2, Math.min(1.2, upwards + up)), Math.max(0.1, Math.min(6, away * distance))];
    this.#painter?.ask("look", { view: this.#view }).catch(() => {});
  }

  reset() {
    this.#view = [0, 0, 1];
    this.look(0, 0, 1);
  }

  /** What a texture holds in a frame of its own: `NAME`, or `NAME@PASS` after a pass. */
  contents(reference, mip) {
    const asked = this.#state.asked();
    if (!this.#is_opened || !asked) return Promise.reject(new Error("nothing is drawn yet"));
    return this.#painter.ask("contents", { ...asked, reference, mip });
  }

  /** The numbers of a texel of the last contents. */
  texel(x, y) {
    return this.#painter.ask("texel", { x, y });
  }

  /** Saves the last frame as a file. */
  async save(name) {
    const texels = await this.#painter.ask("read");
    const canvas = new OffscreenCanvas(...this.#size);
    canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(texels), ...this.#size), 0, 0);
    download(await canvas.convertToBlob(), name);
  }
}

/** Gives a file to the browser's downloads. */
export function download(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  URL.revokeObjectURL(link.href);
}
