// The first screen: pictures that open live, and the steps of the course.
//
// The pictures are cells of the sheets in `examples/gallery/`, which `cargo xtask gallery` draws: cells of 320 by 180 with
// 4 texels between them, each below a label of 18. A card shows its cell by moving the sheet behind a window, which is a
// texel smaller on each side, since JPEG mixes neighbours.
import course from "./course.json";
import entries from "./gallery.json";
import { element } from "./element.js";
import { pipeline_address, step_address } from "./route.js";
import { words } from "./words.js";

const CELL = { right: 324, down: 204, left: 1, top: 19, sheet: 644 };
const WINDOW = { width: 318, height: (318 * 9) / 16 };
const percent = (part, whole) => `${(part / whole) * 100}%`;

function picture({ sheet, cell: [column, row], title }) {
  const image = element("img", { src: `gallery/${sheet}.jpg`, alt: `A frame of ${title}`, loading: "lazy", decoding: "async" });
  image.style.width = percent(CELL.sheet, WINDOW.width);
  image.style.left = percent(-column * CELL.right - CELL.left, WINDOW.width);
  image.style.top = percent(-row * CELL.down - CELL.top, WINDOW.height);
  return element("span", { className: "picture" }, image);
}

const card = (entry) => element("a", { className: "card", href: pipeline_address(entry.pipeline, entry.scene) },
  picture(entry), element("strong", { textContent: entry.title }), element("span", { className: "about" }, ...words(entry.about)));

function step(one, is_done) {
  const made = element("a", { href: step_address(one.id), textContent: one.title });
  if (is_done(one.id)) made.append(element("span", { className: "solved", textContent: " ✓", title: "solved" }));
  return element("li", {}, made);
}

/** Fills the first screen; `is_done` says which steps of the course are solved. */
export function fill_gallery(parent, is_done) {
  const next = course.find(({ id }) => !is_done(id)) ?? course[0];
  const is_begun = course.some(({ id }) => is_done(id));
  const begin = element("a", { className: "call", href: step_address(next.id), textContent: is_begun ? `Go on with “${next.title}”` : "Start the course" });
  parent.replaceChildren(
    element("div", { className: "welcome" },
      element("h2", { textContent: "A render graph that you can read" }),
      element("p", {}, "Passes are a few lines of JSON, shaders are templates of WGSL. Every shader is proven and every texture is planned " +
        "before a frame is drawn, here in your browser. Pick a picture: it opens live, with its text beside it."),
      element("p", { className: "calls" }, begin, element("span", { className: "about", textContent: "Five steps, ten minutes, nothing to install" }))),
    ...entries.map(({ title, cards }) => element("section", { ariaLabel: title }, element("h3", { textContent: title }),
      element("div", { className: "cards" }, ...cards.map(card)))),
    element("section", { ariaLabel: "Course" }, element("h3", { textContent: "The course, step by step" }),
      element("ol", { className: "steps" }, ...course.map((one) => step(one, is_done)))),
  );
}
