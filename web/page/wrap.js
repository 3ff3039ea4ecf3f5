// Lines that are too long go on below, indented by two more than they begin.
import { RangeSetBuilder } from "@codemirror/state";
import { Decoration, EditorView, ViewPlugin } from "@codemirror/view";

/** The deepest indent that is kept, in characters: on a small screen there is little room. */
const DEEPEST = 16;
const MORE = 2;

const decorations = new Map();

function indented(by) {
  if (!decorations.has(by)) {
    const style = `text-indent: -${by}ch; padding-left: calc(6px + ${by}ch)`;
    decorations.set(by, Decoration.line({ attributes: { style } }));
  }
  return decorations.get(by);
}

function visible(view) {
  const builder = new RangeSetBuilder();
  for (const { from, to } of view.visibleRanges) {
    for (let at = from; at <= to;) {
      const line = view.state.doc.lineAt(at);
      const spaces = /^ */.exec(line.text)[0].length;
      builder.add(line.from, line.from, indented(Math.min(spaces, DEEPEST) + MORE));
      at = line.to + 1;
    }
  }
  return builder.finish();
}

/** Wraps long lines. */
export const wrapping = [
  EditorView.lineWrapping,
  ViewPlugin.define((view) => ({
    lines: visible(view),
    update({ view, docChanged, viewportChanged }) {
      if (docChanged || viewportChanged) this.lines = visible(view);
    },
  }), { decorations: (plugin) => plugin.lines }),
];
