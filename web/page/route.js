// The address behind "#": which part of the page is shown, so that a browser's history and bookmarks work.
//
//   (nothing)                                     the gallery
//   #pipeline=pipelines/lore.json&scene=interior  a pipeline
//   #step=alias                                   a step of the course
//   #1…                                           what a link holds (share.js)

/** What a fragment asks for: `link`, `step`, `pipeline` with `scene`, or nothing. */
export function parse(fragment) {
  if (fragment.startsWith("#1")) return { link: fragment };
  const given = new URLSearchParams(fragment.slice(1));
  const named = (name) => given.get(name) ?? undefined;
  return { step: named("step"), pipeline: named("pipeline"), scene: named("scene") };
}

/** The address of a step of the course. */
export const step_address = (id) => `#step=${encodeURIComponent(id)}`;

/** The address of a pipeline, with a scene if one matters. */
export const pipeline_address = (pipeline, scene) => `#pipeline=${pipeline}${scene ? `&scene=${scene}` : ""}`;
