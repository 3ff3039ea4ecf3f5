// Diagnostics as a list.
import { element } from "./element.js";

/** So many are listed. */
const MOST = 100;

const place_of = ({ file, line }) => `${file}${line ? `:${line}` : ""}`;

function item(one, { go, mend }) {
  const made = element("li", { className: one.severity }, element("p", { className: "message", textContent: one.message }));
  if (one.place) {
    const where = element("button", { type: "button", className: "where", textContent: place_of(one.place) });
    where.onclick = () => go(one.place);
    made.append(where);
  }
  if (one.help) made.append(element("p", { className: "help", textContent: one.help }));
  const mending = mend(one);
  if (mending) made.append(element("button", { type: "button", className: "mend", textContent: "Mend", onclick: mending }));
  return made;
}

/** The list; `go` leads to a place, and `mend` gives a function that mends a diagnostic, if it can be. */
function listed(diagnostics, actions) {
  if (!diagnostics.length) return element("p", { className: "none", textContent: "No diagnostics" });
  return element("ol", {}, ...diagnostics.slice(0, MOST).map((one) => item(one, actions)));
}

/** Underlines what an editor shows of diagnostics, and lists all; `show` brings the file of a place into the editor. */
export function told(diagnostics, editor, shown, show) {
  const range = ({ line, column, end_line, end_column }) => {
    const from = editor.offset(line, column);
    return { from, to: Math.max(from, editor.offset(end_line, end_column)) };
  };
  const changes = (fix) => fix.map(({ place, replacement }) => ({ ...range(place), insert: replacement }));
  const mend = (one) => one.fix?.every(({ place }) => place?.file === shown) && (() => editor.edit(changes(one.fix)));
  const here = diagnostics.filter((one) => one.place?.file === shown && one.place.line);
  editor.underline(here.map((one) => ({
    ...range(one.place), severity: one.severity === "note" ? "info" : one.severity,
    message: `${one.message}${one.help ? `\n${one.help}` : ""}`,
    actions: mend(one) ? [{ name: "Mend", apply: () => mend(one)() }] : [],
  })));
  return listed(diagnostics, {
    mend,
    go({ file, line, column }) {
      show(file);
      if (line) editor.go(editor.offset(line, column));
    },
  });
}
