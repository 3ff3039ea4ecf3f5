// A worker that checks, plans and explains. One question at a time; a panic of the library ends it.
import init, { Project } from "./checker/umbragraph_web.js";

const ready = init();
let project = null;

const answers = {
  write: ({ files }) => Object.entries(files).forEach(([path, text]) => project.write(path, text)),
  plan: ({ path, values, size }) => JSON.parse(project.plan(path, values, ...size)),
  check: ({ path, size }) => JSON.parse(project.check(path, ...size)),
  project: ({ name, of }) => JSON.parse(Project.begin(name, of)),
  graph: ({ path, values, size }) => JSON.parse(project.graph(path, values, ...size)),
  slots: ({ path, values, size, pass }) => JSON.parse(project.slots(path, values, ...size, pass)),
  change: ({ path, values, size, change, is_tried }) =>
    JSON.parse(project.change(path, values, ...size, JSON.stringify(change), is_tried)),
  palette: () => JSON.parse(project.palette()),
  templates: () => JSON.parse(Project.templates()),
};

self.onmessage = async ({ data: { id, kind, ...asked } }) => {
  try {
    await ready;
    project ??= new Project();
    const begin = performance.now();
    const answer = answers[kind](asked) ?? null;
    if (answer?.diagnostics) answer.milliseconds = performance.now() - begin;
    self.postMessage({ id, answer });
  } catch (error) {
    // A text is an answer of the library. After anything else, what it holds may be half done.
    self.postMessage(typeof error === "string" ? { id, error } : { id, died: String(error) });
  }
};
