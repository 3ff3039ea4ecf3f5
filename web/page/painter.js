// A worker that draws, on a canvas that the page lends it: one frame after another for as long as something moves or was
// changed.
import init, { Painter, Project } from "./painter/umbragraph_web.js";

/** How many frames follow a change: what frames gather settles in them. */
const SETTLING = 24;

const ready = init();
let painter = null;
/** Where the browser cannot show what WebGPU draws, the pictures are read back and put here. */
let plain = null;
let size = [1, 1];
let project = null;
/** The last contents of a texture that were asked for. */
let contents = null;
let left = 0;
let playing = false;
let seconds = 0;
let index = 0;
let running = false;

/** Milliseconds in the browser's creation of shaders and pipelines since the last frame. */
let created = 0;
for (const name of ["createShaderModule", "createRenderPipeline", "createComputePipeline"]) {
  const create = self.GPUDevice?.prototype[name];
  if (!create) continue;
  GPUDevice.prototype[name] = function (...given) {
    const begin = performance.now();
    const made = create.apply(this, given);
    created += performance.now() - begin;
    return made;
  };
}
/** Whether the next frame is the first of a plan. */
let is_planned = false;

const answers = {
  async open({ canvas, is_plain }) {
    painter = await Painter.open(is_plain ? undefined : canvas);
    plain = is_plain ? canvas.getContext("2d") : null;
    project = new Project();
    return { name: painter.name() };
  },
  write: ({ files }) => Object.entries(files).forEach(([path, text]) => project.write(path, text)),
  scene({ name, bytes }) {
    painter.scene(name, new Uint8Array(bytes));
  },
  pipeline({ path, values, ...asked }) {
    size = asked.size;
    const answer = JSON.parse(painter.pipeline(project, path, values, ...size));
    is_planned = true;
    changed();
    return answer;
  },
  set({ name, value }) {
    painter.set(name, JSON.stringify(value));
    changed();
  },
  look({ view }) {
    painter.look(...view);
    changed();
  },
  play({ on }) {
    playing = on;
    changed();
  },
  async read() {
    return await painter.read();
  },
  async contents({ path, values, reference, mip }) {
    contents?.free();
    contents = null;
    contents = await painter.contents(project, path, values, reference, mip, index++, seconds);
    const { width, height, mips } = contents;
    return { width, height, mips, ranges: [...contents.ranges()], rgba: contents.rgba() };
  },
  texel: ({ x, y }) => [...(contents?.texel(x, y) ?? [])],
};

/** What is asked and drawn goes one after another: the library lends itself to one at a time. */
let last_work = ready;
const in_turn = (work) => (last_work = last_work.then(work, work));

function changed() {
  left = SETTLING;
  if (!running) draw();
}

async function show_plain() {
  const texels = await painter.read();
  [plain.canvas.width, plain.canvas.height] = size;
  plain.putImageData(new ImageData(new Uint8ClampedArray(texels.buffer), ...size), 0, 0);
}

async function draw() {
  running = true;
  let last = performance.now();
  while (left > 0 || playing) {
    const begin = performance.now();
    if (playing) seconds += (begin - last) / 1000;
    last = begin;
    try {
      await in_turn(async () => {
        const begin = performance.now();
        const is_drawn = painter.frame(index++, seconds);
        const recorded = performance.now() - begin;
        if (plain && is_drawn) await show_plain();
        else await painter.done();
        const lost = painter.lost();
        if (lost !== undefined) {
          playing = false;
          left = 0;
          return self.postMessage({ lost });
        }
        if (!is_drawn) return;
        self.postMessage({ frame: { recorded, total: performance.now() - begin, seconds, created, is_planned } });
        [created, is_planned] = [0, false];
      });
    } catch (error) {
      left = 0;
      playing = false;
      self.postMessage({ failed: String(error) });
      break;
    }
    left -= 1;
    // Messages that came meanwhile go first.
    await new Promise((resolve) => (self.requestAnimationFrame ?? setTimeout)(resolve));
  }
  running = false;
}

self.onmessage = async ({ data: { id, kind, ...asked } }) => {
  try {
    const answer = await in_turn(() => answers[kind](asked));
    self.postMessage({ id, answer: answer ?? null });
  } catch (error) {
    self.postMessage({ id, error: String(error), died: error instanceof WebAssembly.RuntimeError });
  }
};
