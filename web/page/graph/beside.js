// What the graph asks of the page around it.

/** The page as `Graph` takes it: the checker, the editor, and the files that this shows. */
export const beside = ({ ask, editor, text_of, show, shown, frame }) => ({
  ask,
  shows: {
    is_drawn: () => frame().is_started,
    contents: (reference, mip) => frame().contents(reference, mip),
    texel: (x, y) => frame().texel(x, y),
  },
  edit(edits) {
    const [first] = Object.keys(edits);
    if (first && !(shown() in edits)) show(first);
    editor.edit_files(edits, text_of);
  },
  undo: () => editor.undo(show),
  redo: () => editor.redo(show),
  go(declared, is_focused) {
    const [, file, line] = declared.match(/^(.*):(\d+)$/) ?? [];
    if (!file || !text_of(file)) return;
    if (file !== shown()) show(file);
    editor.go(editor.offset(Number(line), 1), is_focused);
  },
});
