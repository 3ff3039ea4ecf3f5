// A worker that is the language server of editors: messages of the Language Server Protocol, as texts, in and out.
import init, { Language } from "./checker/umbragraph_web.js";

const ready = init();
let language = null;

const answers = {
  write: ({ files }) => Object.entries(files).forEach(([path, text]) => language.write(path, text)),
  message: ({ message }) => language.handle(message),
};

self.onmessage = async ({ data: { id, kind, ...asked } }) => {
  try {
    await ready;
    language ??= new Language();
    self.postMessage({ id, answer: answers[kind](asked) ?? null });
  } catch (error) {
    // What the library holds may be half done.
    self.postMessage({ id, died: String(error) });
  }
};
