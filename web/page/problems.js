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
export function listed(diagnostics, actions) {
  if (!diagnostics.length) return element("p", { className: "none", textContent: "No diagnostics" });
  return element("ol", {}, ...diagnostics.slice(0, MOST).map((one) => item(one, actions)));
}
