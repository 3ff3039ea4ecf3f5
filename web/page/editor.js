// The editor: CodeMirror with the colours of the page, one state of it for each file.
import { defaultKeymap, history, historyKeymap, indentWithTab, invertedEffects, isolateHistory, redo, undo, undoDepth } from "@codemirror/commands";
import { HighlightStyle, StreamLanguage, bracketMatching, foldGutter, foldKeymap, indentOnInput, indentUnit, syntaxHighlighting } from "@codemirror/language";
import { json } from "@codemirror/legacy-modes/mode/javascript";
import { rust } from "@codemirror/legacy-modes/mode/rust";
import { lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import { completionKeymap } from "@codemirror/autocomplete";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState, StateEffect, Transaction } from "@codemirror/state";
import { EditorView, drawSelection, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { wrapping } from "./wrap.js";

const colour = (light, dark) => `light-dark(${light}, ${dark})`;
const colours = HighlightStyle.define([
  { tag: tags.string, color: colour("#1e6b3a", "#93d7a4") },
  // Of JSON a key is a string, too.
  { tag: tags.propertyName, color: colour("#1a4f9c", "#9cc4ff") },
  { tag: [tags.number, tags.bool, tags.null, tags.atom], color: colour("#8a3b00", "#f2b27a") },
  { tag: tags.comment, color: colour("#5d6570", "#98a1ac"), fontStyle: "italic" },
  { tag: [tags.keyword, tags.definitionKeyword], color: colour("#7a2d8f", "#d6a5e8") },
  { tag: [tags.typeName, tags.meta], color: colour("#00626b", "#7fd3db") },
]);

const json_of = StreamLanguage.define({ ...json, tokenTable: { property: tags.propertyName } });
// WGSL reads enough like Rust for colours.
const wgsl = StreamLanguage.define(rust);

/** Marks what was changed in several files at once, and is undone in all of them. */
const joined = StateEffect.define();

export class Editor {
  #view;
  #changed;
  /** The steps that can be undone in all files, in their order: the file, and how many it had then. */
  #done = [];
  #undone = [];
  #states = new Map();
  #path = null;

  #extension;

  /** `changed` is told of each edit; `extension(path)` gives what else the editor of a file does. */
  constructor(parent, { changed, extension = () => [] }) {
    [this.#changed, this.#extension] = [changed, extension];
    this.#view = new EditorView({
      parent,
      dispatchTransactions: (transactions, view) => {
        view.update(transactions);
        const is_edit = transactions.some((one) => one.docChanged && one.annotation(Transaction.userEvent) !== "load");
        if (is_edit) this.#note(this.#path, view.state, transactions);
        for (const one of transactions) this.#follow(one);
      },
    });
  }

  #state(path, text) {
    const language = path.endsWith(".json") ? json_of : wgsl;
    return EditorState.create({
      doc: text,
      extensions: [
        lineNumbers(), foldGutter(), lintGutter(), history(), drawSelection(),
        invertedEffects.of((one) => one.effects.filter((effect) => effect.is(joined))), indentOnInput(), bracketMatching(),
        highlightActiveLine(), highlightActiveLineGutter(), highlightSelectionMatches(),
        wrapping, indentUnit.of("  "), language, syntaxHighlighting(colours),
        keymap.of([...completionKeymap, ...defaultKeymap, ...historyKeymap, ...foldKeymap, ...searchKeymap, ...lintKeymap, indentWithTab]),
        EditorView.contentAttributes.of({ "aria-label": `The text of ${path}`, tabindex: "0" }),
        this.#extension(path),
      ],
    });
  }

  /** Shows a file; what was undone and selected in it before is kept. */
  show(path, text) {
    if (this.#path !== null) this.#states.set(this.#path, this.#view.state);
    const known = this.#states.get(path);
    this.#path = path;
    this.#view.setState(known && known.doc.toString() === text ? known : this.#state(path, text));
  }

  /** The editor's view. */
  get view() {
    return this.#view;
  }

  /** Edits a file that is not shown, as one step of its undo; returns its text. */
  edit_hidden(path, text, update) {
    const known = this.#states.get(path);
    const state = known && known.doc.toString() === text ? known : this.#state(path, text);
    const { state: next } = state.update(update);
    this.#states.set(path, next);
    return next.doc.toString();
  }

  /** Forgets all files. */
  clear() {
    this.#states.clear();
    this.#path = null;
    this.#done = [];
    this.#undone = [];
  }

  /** Replaces parts of the text as one step of undo; each part has `from`, `to` and `insert`. */
  edit(changes) {
    this.#view.dispatch({ changes, userEvent: "input" });
    this.#view.focus();
  }

  /** Changes files, each part as of `edit`, as one step of undo for all of them; `text_of` has the texts of the others. */
  edit_files(files, text_of) {
    const paths = Object.keys(files).filter((path) => files[path].length);
    const effects = paths.length > 1 ? [joined.of({ id: crypto.randomUUID(), paths })] : [];
    for (const path of paths) {
      const change = { changes: files[path], effects, userEvent: "input", annotations: isolateHistory.of("full") };
      if (path === this.#path) this.#view.dispatch(change);
      else this.#elsewhere(path, (this.#states.get(path) ?? this.#state(path, text_of(path))).update(change));
    }
  }

  /** Undoes the last step of all files; `show` is told the file. */
  undo(show) {
    for (let last; (last = this.#done.pop()); ) {
      const { path, depth } = last;
      if (this.#depth(path) < depth) continue;
      if (path !== this.#path) show(path);
      undo(this.#view);
      this.#undone.push(last);
      return;
    }
  }

  /** Makes the step again that was undone last. */
  redo(show) {
    const next = this.#undone.pop();
    if (!next) return;
    if (next.path !== this.#path) show(next.path);
    redo(this.#view);
    this.#done.push(next);
  }

  #depth(path) {
    const state = path === this.#path ? this.#view.state : this.#states.get(path);
    return state ? undoDepth(state) : 0;
  }

  /** Tells of a change, and notes what can be undone of it. */
  #note(path, state, transactions) {
    const is_back = transactions.some((one) => one.isUserEvent("undo") || one.isUserEvent("redo"));
    const depth = undoDepth(state);
    const last = this.#done.at(-1);
    if (!is_back) {
      this.#undone = [];
      if (last?.path !== path || last.depth < depth) this.#done.push({ path, depth });
    }
    this.#changed(path, state.doc.toString());
  }

  #elsewhere(path, transaction) {
    this.#states.set(path, transaction.state);
    this.#changed(path, transaction.state.doc.toString());
  }

  /** What is undone or made again in this file is in the others that were changed with it. */
  #follow(transaction) {
    const again = transaction.isUserEvent("undo") ? undo : transaction.isUserEvent("redo") ? redo : null;
    const mark = transaction.effects.find((effect) => effect.is(joined))?.value;
    if (!again || !mark) return;
    for (const path of mark.paths.filter((path) => path !== this.#path && this.#states.has(path))) {
      const dispatch = (other) => {
        const is_same = other.effects.some((effect) => effect.is(joined) && effect.value.id === mark.id);
        if (is_same) this.#elsewhere(path, other);
      };
      again({ state: this.#states.get(path), dispatch });
    }
  }

  /** The offset of a line and a column, both from 1; columns count characters. */
  offset(line, column) {
    const { doc } = this.#view.state;
    if (line > doc.lines) return doc.length;
    const { from, text } = doc.line(line);
    return from + Array.from(text).slice(0, column - 1).join("").length;
  }

  /** Underlines diagnostics, each with `from`, `to`, `severity`, `message` and `actions`. */
  underline(diagnostics) {
    const { length } = this.#view.state.doc;
    const within = diagnostics.map((one) => ({ ...one, from: Math.min(one.from, length), to: Math.min(one.to, length) }));
    this.#view.dispatch(setDiagnostics(this.#view.state, within));
  }

  /** Puts the cursor at an offset and shows it. */
  go(offset, is_focused = true) {
    this.#view.dispatch({ selection: { anchor: offset }, effects: EditorView.scrollIntoView(offset, { y: "center" }) });
    if (is_focused) this.#view.focus();
  }
}
