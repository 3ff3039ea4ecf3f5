// The editor's side of the language server: completion, hover, rename, definition, references and formatting.
//
// All texts of the page are files of the workspace, so that a rename reaches those that no tab shows. Files that were shown
// once stay open for the server; others are on what it takes for its disk. The worker starts with the first use of the
// editor, and again when it dies.
import { LSPClient, LSPPlugin, Workspace, findReferencesKeymap, formatKeymap, hoverTooltips, jumpToDefinitionKeymap, renameKeymap, serverCompletion } from "@codemirror/lsp-client";
import { Text } from "@codemirror/state";
import { keymap } from "@codemirror/view";
import { changed, files, templates, text_of } from "./texts.js";
import { Answerer } from "./worker.js";

const SCHEME = "file:///";
const uri_of = (path) => SCHEME + path.split("/").map(encodeURIComponent).join("/");
const path_of = (uri) => decodeURIComponent(uri.slice(SCHEME.length));
const is_document = (path) => /\.jsonc?$/.test(path) && !path.endsWith(".axes.json");

/** The time, in milliseconds, in which the server has to answer: in a browser its first plan takes a while. */
const TIMEOUT = 20_000;

/** A file of the workspace; `view` is the editor that shows it. */
class File {
  languageId = "json";
  version = 0;
  view = null;
  is_open = false;

  constructor(path) {
    [this.path, this.uri, this.doc] = [path, uri_of(path), Text.empty];
    this.refresh();
  }

  getView() {
    return this.view;
  }

  /** Takes the text of the page, where no editor has it. */
  refresh() {
    const text = text_of(this.path);
    if (!this.view && text !== this.text) [this.text, this.doc] = [text, Text.of(text.split("\n"))];
    return this;
  }
}

class Pages extends Workspace {
  #page;
  #known = new Map();

  constructor(client, page) {
    super(client);
    this.#page = page;
  }

  #file(path) {
    if (!this.#known.has(path)) this.#known.set(path, new File(path));
    return this.#known.get(path).refresh();
  }

  get files() {
    return [...new Set([...Object.keys(files), ...Object.keys(changed)])].filter(is_document).map((path) => this.#file(path));
  }

  getFile(uri) {
    return this.#file(path_of(uri));
  }

  connected() {
    for (const file of this.#known.values()) if (file.is_open) this.client.didOpen(file);
  }

  openFile(uri, _, view) {
    const file = this.getFile(uri);
    const is_other = file.is_open && !file.doc.eq(view.state.doc);
    [file.view, file.doc] = [view, view.state.doc];
    if (is_other) this.#changed(file);
    else if (!file.is_open) this.client.didOpen(file);
    file.is_open = true;
  }

  closeFile(uri) {
    const file = this.getFile(uri);
    [file.text, file.doc] = [file.view.state.doc.toString(), file.view.state.doc];
    file.view = null;
  }

  syncFiles() {
    return this.files.flatMap((file) => {
      const plugin = file.view && LSPPlugin.get(file.view);
      if (!plugin || plugin.uri !== file.uri || plugin.unsyncedChanges.empty) return [];
      const update = { file, changes: plugin.unsyncedChanges, prevDoc: file.doc };
      file.doc = file.view.state.doc;
      file.version++;
      plugin.clear();
      return [update];
    });
  }

  /** A text that changed without an editor. */
  refresh(path) {
    const known = this.#known.get(path);
    if (known?.view) return;
    if (known?.is_open) this.#changed(known.refresh());
    else this.client.notification("workspace/didChangeWatchedFiles", { changes: [{ uri: uri_of(path), type: 2 }] });
  }

  #changed(file) {
    file.version++;
    const textDocument = { uri: file.uri, version: file.version };
    this.client.notification("textDocument/didChange", { textDocument, contentChanges: [{ text: file.doc.toString() }] });
  }

  updateFile(uri, update) {
    const { view, path } = this.getFile(uri);
    if (view) view.dispatch(update);
    else this.#page.edit(path, update);
  }

  displayFile(uri) {
    return Promise.resolve(this.#page.show(path_of(uri)));
  }
}

export class LanguageClient {
  #client;
  #worker;
  #hear = () => {};
  #is_started = false;

  /** `page.show(path)` shows a file and returns the editor's view; `page.edit(path, update)` edits one that is not shown. */
  constructor(page) {
    this.#client = new LSPClient({
      rootUri: SCHEME,
      timeout: TIMEOUT,
      workspace: (client) => new Pages(client, page),
      extensions: [
        serverCompletion(), hoverTooltips(),
        keymap.of([...renameKeymap, ...jumpToDefinitionKeymap, ...findReferencesKeymap, ...formatKeymap]),
      ],
    });
    this.#worker = new Answerer("server.js", {
      begin: (worker) => void worker.ask("write", { files: { ...files, ...changed } }).catch(() => {}),
      died: () => this.#is_started && this.#connect(),
    });
  }

  /** The extension of an editor for a file; nothing for one that is no document. */
  extension(path) {
    return is_document(path) ? this.#client.plugin(uri_of(path), "json") : [];
  }

  /** Starts the server, unless it runs. */
  start() {
    if (this.#is_started) return;
    this.#is_started = true;
    this.#connect();
  }

  /** Tells of texts that changed. A template of a new name is known to a new server alone. */
  write(texts) {
    if (!this.#is_started) return;
    if (Object.keys(texts).some((path) => /\.(jinja|axes\.json)$/.test(path) && !(path in templates))) return this.#worker.stop("it begins anew");
    this.#worker.ask("write", { files: texts }).catch(() => {});
    Object.keys(texts).forEach((path) => this.#client.workspace.refresh(path));
  }

  #connect() {
    this.#client.connect({
      send: (message) => {
        this.#worker.ask("message", { message }).then((answers) => answers.forEach((answer) => this.#hear(answer)), () => {});
      },
      subscribe: (hear) => (this.#hear = hear),
      unsubscribe: () => (this.#hear = () => {}),
    });
  }
}
